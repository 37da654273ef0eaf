"""Scenario files: whole, as a preset with changes, and with every kind of fault named in one line."""

import subprocess
import sys

import pytest

from simfield import changed, presets, read_scenario, simulate
from simfield.disturbances.effects import RadialTable
from simfield.scenario.scenario import ScenarioError
from simfield.scenario.scenario_file import scenario_as_table, scenario_from_table

RHEIDT = presets["rheidt-1980"]

WHOLE = """
name = "my block"
flights = [{flight_id = "f", camera_id = "cam", scale = 10000, headings_gon = [0, 100]}]
[field]
kind = "grid"
nx = 7
ny = 7
spacing_m = 300
[control]
layout = "corners"
rest = "tie"
[[cameras]]
camera_id = "cam"
c_mm = 150
[[effects]]
camera = "cam"
effect = {kind = "radial-table", radius_mm = [50, 100, 163], distortion_um = [3, 0, -5]}
[noise]
image_um = 4
"""


def faults(table):
    with pytest.raises(ScenarioError) as error:
        scenario_from_table(table)
    return str(error.value).splitlines()


def fault(path, value):
    with pytest.raises(ScenarioError) as error:
        changed(RHEIDT, {path: value})
    return str(error.value)


def test_a_whole_scenario(tmp_path):
    path = tmp_path / "scenario.toml"
    path.write_text(WHOLE, encoding="utf-8")
    scenario = read_scenario(path)
    assert scenario.effects[0].effect == RadialTable((50.0, 100.0, 163.0), (3.0, 0.0, -5.0))
    assert scenario.flights[0].headings_gon == (0.0, 100.0)
    assert len(simulate(scenario, 1)[0].images) == 6


def test_a_preset_with_changes(tmp_path):
    path = tmp_path / "scenario.toml"
    text = """
    preset = "rheidt-1980"
    name = "calm"
    [noise]
    geodetic_mm = 0
    [changes]
    "flights[0].scale" = 9000
    "flights[*].position_sigma_m" = 10.0
    "noise.image_um.ww" = 2.0
    "measurement.counts" = {}
    """
    path.write_text(text, encoding="utf-8")
    scenario = read_scenario(path)
    assert (scenario.name, scenario.flights[0].scale, scenario.flights[1].scale) == ("calm", 9000.0, 10200.0)
    assert [f.position_sigma_m for f in scenario.flights] == [10.0] * 4
    assert scenario.noise.image_um == {"ww": 2.0, "sww": 5.7}
    assert (scenario.noise.geodetic_mm, scenario.noise.assumed_um) == (0.0, 5.0)
    assert scenario.measurement.counts == {}
    assert scenario.effects == RHEIDT.effects


def test_another_kind_of_field_replaces_the_presets():
    scenario = scenario_from_table(
        {
            "preset": "rheidt-1980",
            "field": {"kind": "grid", "nx": 5, "ny": 5, "spacing_m": 400},
            "changes": {"measurement": {}},
        }
    )
    assert scenario.field.build(1).group_ids[0] == "r1c1"


@pytest.mark.parametrize("name", sorted(presets))
def test_every_preset_survives_the_way_through_a_table(name):
    assert scenario_from_table(scenario_as_table(presets[name])) == presets[name]
    assert changed(presets[name], {}) == presets[name]


@pytest.mark.parametrize(
    ("path", "value", "line"),
    [
        ("flights[0].scal", 3.0, "flights[0].scal: unknown key, did you mean 'scale'?"),
        ("flight[0].scale", 3.0, "flight[0].scale: unknown key 'flight', did you mean 'flights'?"),
        ("flights[7].scale", 3.0, "flights[7].scale: there is no entry [7], the list has 4, counted from 0"),
        ("flights[0].scale", "x", 'flights[0].scale: found "x", allowed: a number'),
        ("flights[0].scale", "3", 'flights[0].scale: found "3", allowed: a number'),
        ("flights[0].scale", True, "flights[0].scale: found true, allowed: a number"),
        ("flights[0].scale", float("nan"), "flights[0].scale: found NaN, allowed: a finite number"),
        ("flights[0].scale", float("inf"), "flights[0].scale: found Infinity, allowed: a finite number"),
        ("noise.image_um.ww", float("nan"), "noise.image_um.ww: found NaN, allowed: a finite number"),
        ("noise.image_um", "much", 'noise.image_um: found "much", allowed: a number or a table'),
        ("noise.image_um.wv", 3.0, "noise.image_um names the cameras ['sww', 'wv', 'ww']"),
        ("effects[0].effect.k9", 3.0, "effects[0].effect.k9: unknown key; known are k1, k2, k3, kind, r0_mm"),
        ("effects[0].effect.kind", "radial", 'effects[0].effect.kind: found "radial", allowed: '),
        ("effects[0].effect", {"k1": 3.0}, "effects[0].effect.kind: is missing"),
        ("field.spacing", 3.0, "field.spacing: unknown key, did you mean 'spacing_m'?"),
        ("field.relief.sigma", 1.0, "field.relief.sigma: unknown key, did you mean 'sigma_m'?"),
        ("field.group_size", 4, "field.group_size: found 4, allowed: 1, 2 or 3"),
        ("field.kind", "hexagon", "field.kind: found \"hexagon\", allowed: 'quincunx', 'grid'"),
        ("measurement.counts.ww", 3, "measurement.counts.ww: found 3, allowed: a table"),
        ("measurement.counts.ww.mian", 3, "measurement.counts.ww.mian: unknown key, did you mean 'main'?"),
        ("control.layout", "corner", "control.layout: found \"corner\", allowed: 'none', 'corners'"),
        ("flights[0].scale.x", 1.0, "flights[0].scale.x: 'x' does not lead into 9600.0"),
        ("a..b", 3, "'a..b' is no path"),
        ("flights[x].scale", 3, "'flights[x].scale' is no path"),
        ("", 3, "'' is no path"),
        ("flights[0].scale", -1.0, "flights[0]: flight 'sww-before': scale -1 is not allowed"),
        ("flights", [], "a scenario needs at least one flight"),
    ],
)
def test_a_fault_is_one_line_with_place_finding_and_allowance(path, value, line):
    found = fault(path, value)
    assert found.startswith(line)
    assert "\n" not in found


def test_all_faults_are_reported_at_once():
    lines = faults(
        {
            "preset": "rheidt-1980",
            "stat": {},
            "noise": {"geodtic_mm": 1.0, "image_um": "a"},
            "flights": [{"flight_id": "a", "camera_id": "ww", "scale": 1e4, "heading": 3}],
        }
    )
    assert sorted(line.partition(":")[0] for line in lines) == [
        "flights[0].heading",
        "noise.geodtic_mm",
        "noise.image_um",
        "stat",
    ]
    assert faults({"name": "x"}) == ["field: is missing", "cameras: is missing", "flights: is missing"]


def test_unknown_presets_and_broken_files(tmp_path):
    assert faults({"preset": "rheid-1980"}) == ["preset: no preset named 'rheid-1980', did you mean 'rheidt-1980'?"]
    assert faults({"preset": "rheidt-1980", "changes": 3})[0].startswith("changes: found 3")
    assert faults({"preset": 3})[0].startswith("preset: no preset named 3")
    broken = tmp_path / "broken.toml"
    broken.write_text("name = ", encoding="utf-8")
    with pytest.raises(ScenarioError, match=r"broken\.toml: no TOML"):
        read_scenario(broken)
    broken.write_text('nam = "x"\npreset = "rheidt-1980"\n', encoding="utf-8")
    with pytest.raises(ScenarioError, match=r"broken\.toml: nam: unknown key, did you mean 'name'"):
        read_scenario(broken)


def test_a_date_is_no_number():
    import tomllib

    table = tomllib.loads('preset = "rheidt-1980"\nnoise.geodetic_mm = 12:30:00')
    assert faults(table) == ['noise.geodetic_mm: found "12:30:00", allowed: a number']


def test_importing_the_simulator_imports_neither_pydantic_nor_scipy():
    code = "import simfield, sys; print(sorted({'pydantic', 'scipy', 'pandas', 'matplotlib'} & set(sys.modules)))"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "[]"
