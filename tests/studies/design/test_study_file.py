"""The study file: every fault at once, each with its place, and none that ends in a traceback or takes for ever."""

from __future__ import annotations

import itertools
import subprocess
import sys
import time

import pytest

from adjust import ap_models
from studies.design import shipped
from studies.design.conditions import condition_seed, conditions_of
from studies.design.factors import NAMED
from studies.design.methods import MODEL_SETTINGS, methods_of, references
from studies.design.study import StudyError
from studies.design.study_file import LARGEST_FILE, read_study, study_from_text
from tests.studies.small_study import TEXT, study


def faults(text: str) -> list[str]:
    with pytest.raises(StudyError) as caught:
        study_from_text(text)
    return str(caught.value).splitlines()


def test_every_fault_is_reported_at_once_with_place_found_and_allowed() -> None:
    wrong = TEXT.replace("noise_um = [3.0, 6.0]", 'noise_um = [3.0, "much"]\nnoise_ums = [1.0]')
    wrong = wrong.replace('"optical"', '"opticl"').replace("seed = 7", "seed = -7")
    found = "\n".join(faults(wrong))
    assert "study.seed: found -7, allowed: 0 and above" in found
    assert "methods.ap[1]: no AP model 'opticl', did you mean 'optical'?" in found
    assert "grid.noise_ums: unknown factor, did you mean 'noise_um'?" in found
    found = "\n".join(faults(TEXT.replace("[3.0, 6.0]", '[3.0, "much"]')))
    assert 'grid.noise_um[1]: noise.image_um: found "much", allowed' in found


def test_several_wrong_types_and_unknown_keys_are_reported_at_once() -> None:
    wrong = TEXT.replace("max = 96", 'max = "many"\nmaxx = 3').replace('name = "small"', "name = 5")
    found = faults(wrong)
    assert any(line.startswith('trials.max: found "many", allowed: a integer') for line in found)
    assert "trials.maxx: unknown key, did you mean 'max'?" in found
    assert any(line.startswith("study.name: found 5, allowed:") for line in found)


def test_faults_of_form_hide_no_fault_of_content() -> None:
    wrong = TEXT.replace("max = 96", 'max = "many"\nblok = 3').replace('"optical"', '"opticl"')
    wrong = wrong.replace('name = "small"', 'name = "A B"').replace('"grid-small"', '"grid-smal"')
    wrong = wrong.replace("[grid]", "[grid]\nnoise_umm = [1.0]")
    places = ("trials.max", "trials.blok", "study.name", "methods.ap[1]", "scenario.preset", "grid.noise_umm")
    found = faults(wrong)
    assert [place for place in places if not any(line.startswith(f"{place}: ") for line in found)] == []
    assert len(found) == len(places)


@pytest.mark.parametrize(
    ("old", "new", "line"),
    [
        ('name = "small"', 'name = "../../x"', 'study.name: found "../../x"'),
        ('name = "small"', f'name = "{"x" * 65}"', "study.name: found"),
        ('question = "Does it run?"', 'question = " "', "study.question: is empty"),
        ("block = 32", "block = 33", "trials.block: found 33, allowed: multiples of 32"),
        ("block = 32", "block = 32\nmin = 20", "trials.min: found 20, allowed: 500 and above"),
        ("block = 32", "block = 32\ntarget_mcse = { m0_um = 0.0 }", "trials.target_mcse.m0_um: found 0"),
        ("[3.0, 6.0]", "[3.0, 3]", "grid.noise_um[1]: 3 stands there twice"),
        ("[3.0, 6.0]", "[]", "grid.noise_um: found [], allowed: at least one level"),
        ("[3.0, 6.0]", "[3.0, nan]", "grid.noise_um[1]: found nan, allowed: finite numbers"),
        ("[3.0, 6.0]", "[3.0, 1e999]", "grid.noise_um[1]: found inf, allowed: finite numbers"),
        ("[3.0, 6.0]", "[3.0, 12:30:00]", "grid.noise_um[1]: found"),
        ("seed = 7", "seed = 99999999999999999999", "study.seed: found a whole number beyond 2^63"),
        ("[methods]", "[[zip]]\nscale = [1.0, 2.0]\nstrips = [1]\n[methods]", "zip[0]: factors that move together"),
        ("[methods]", "[[exclude]]\nnoise = 3.0\n[methods]", "exclude[0].noise: no factor of this study"),
        ("[methods]", "[[include]]\n[methods]", "include[0].noise_um: is missing"),
        ("[methods]", '[methods]\ncameras = ["sw"]', "methods.cameras[0]: no camera 'sw'"),
        ("[methods]", "[methods]\naux_points = [1]", "methods.aux_points[0]: found 1, allowed: true or false"),
        ('"none", ', '{ id = "optical", r0 = 3 }, ', "methods.ap[0].r0: unknown setting of optical"),
        ("[report]", '[paired]\nfactors = ["x"]\n[report]', "paired.factors[0]: 'x' is no factor"),
        ("[report]", '[paired]\nagainst = { ap = "x" }\n[report]', "paired.against.ap: found"),
        ('x = "noise_um"', 'x = "noise"', "report.x: 'noise' is neither factor nor key"),
        ('preset = "grid-small"', 'preset = "grid-smal"', "scenario.preset: no preset named 'grid-smal'"),
        (
            "[grid]",
            '[grid]\n"flights[9].scale" = [1.0]',
            "grid.flights[9].scale[0]: flights[9].scale: there is no entry",
        ),
        ("[grid]", "[factors]\nlens = 5\n[grid]", "factors.lens: found 5, allowed: a dotted path"),
        ("[study]", "[study]\ntext = 5", "study.text: unknown key"),
        ("[study]", "text = 5\n[study]", "text: unknown key"),
    ],
)
def test_a_fault_has_its_place(old: str, new: str, line: str) -> None:
    assert old in TEXT
    assert any(found.startswith(line) for found in faults(TEXT.replace(old, new))), faults(TEXT.replace(old, new))


@pytest.mark.parametrize(
    ("raw", "line"),
    [
        (b"\xef\xbb\xbf[study]", "byte-order mark"),
        (b"[study]\nname = \0", "line 2: there is a NUL byte"),
        (b"[study]\nname = '\xff'", "line 2: byte 0xff is no UTF-8"),
        (b"x = " + b"[" * 100_000, "nested too deeply"),
        (b"x = " + b"9" * 5000, "no TOML"),
        (b"x = " + b"{a=" * 5000, "nested too deeply"),
        (b"#" * (LARGEST_FILE + 1), "the file has more than"),
        (b"", "study: is missing"),
    ],
)
def test_what_is_no_study_file_is_refused_at_once(tmp_path, raw: bytes, line: str) -> None:  # type: ignore[no-untyped-def]
    path = tmp_path / "study.toml"
    path.write_bytes(raw)
    started = time.monotonic()
    with pytest.raises(StudyError, match=line):
        read_study(path)
    assert time.monotonic() - started < 5.0


def test_a_grid_is_counted_before_it_is_built() -> None:
    levels = ", ".join(str(0.001 * i) for i in range(1, 1001))
    text = TEXT.replace(
        "noise_um = [3.0, 6.0]", f'noise_um = [{levels}]\nscale = [{levels}]\n"flights[0].sidelap" = [{levels}]'
    )
    started = time.monotonic()
    assert faults(text) == ["grid: 1000000000 conditions, allowed: at most 10000"]
    assert time.monotonic() - started < 5.0


def test_conditions_are_grid_times_zip_minus_exclude_plus_include() -> None:
    made = study(
        TEXT,
        ("[methods]", "[[zip]]\nscale = [9000.0, 10000.0]\nsidelap = [0.2, 0.3]\n[methods]"),
        ("[methods]", "[[exclude]]\nnoise_um = 6\nscale = 9000\n[methods]"),
        ("[methods]", "[[include]]\nnoise_um = 9.0\nscale = 9500.0\nsidelap = 0.25\n[methods]"),
    )
    found = [tuple(c.levels.values()) for c in conditions_of(made)]
    assert found == [(3.0, 9000.0, 0.2), (3.0, 10000.0, 0.3), (6.0, 10000.0, 0.3), (9.0, 9500.0, 0.25)]
    scenarios = [c.scenario for c in conditions_of(made)]
    assert [s.noise.image_um for s in scenarios] == [3.0, 3.0, 6.0, 9.0]
    assert [s.flights[0].sidelap for s in scenarios] == [0.2, 0.3, 0.3, 0.25]


def test_an_id_comes_from_the_content_and_not_from_the_place() -> None:
    before = {c.columns["noise_um"]: (c.id, c.seed) for c in conditions_of(study())}
    after = {c.columns["noise_um"]: (c.id, c.seed) for c in conditions_of(study(TEXT, ("[3.0, 6.0]", "[9, 6, 4, 3]")))}
    assert {level: after[level] for level in before} == before
    assert (
        len({c.id for c in conditions_of(study(TEXT, ("seed = 7", "seed = 8")))} | {i for i, _ in before.values()}) == 4
    )


def test_paired_factors_share_the_seed_and_others_do_not() -> None:
    own = conditions_of(study())
    shared = conditions_of(study(TEXT, ("[report]", '[paired]\nfactors = ["noise_um"]\n[report]')))
    assert len({c.seed for c in own}) == 2
    assert len({c.seed for c in shared}) == 1
    assert len({c.id for c in shared}) == 2
    assert condition_seed(7, {"noise_um": 3.0}) == own[0].seed < 2**63


def test_factors_can_multiply_and_be_labelled() -> None:
    made = study(
        TEXT,
        (
            "[grid]",
            '[factors]\nlens = { paths = ["effects[0].effect.k1", "effects[*].effect.k2"], times = true }\n[grid]',
        ),
        ("[3.0, 6.0]", '[3.0]\nlens = [0.0, 2]\nheadings_gon = [{ label = "north", value = [0.0] }]'),
    )
    none, twice = conditions_of(made)
    assert (none.scenario.effects[0].effect.k1, twice.scenario.effects[0].effect.k1) == (0.0, 2 * -1.76e-8)  # type: ignore[attr-defined]
    assert twice.scenario.effects[0].effect.k2 == 2 * 5.4e-13  # type: ignore[attr-defined]
    assert twice.columns["headings_gon"] == "north"
    assert twice.scenario.flights[0].headings_gon == (0.0,)


def test_methods_are_crossed_and_compared_with_their_reference() -> None:
    made = study(
        TEXT, ('"none", ', '"none", { id = "optical", r0_mm = 90 }, '), ("[methods]", "[methods]\nimage_um = [3, 5]")
    )
    keys = [m.key for m in methods_of(made)]
    assert len(keys) == 6
    assert "optical r0_mm=90, cameras all, with aux, image_um 3" in keys
    assert references(made)["optical, cameras all, with aux, image_um 5"] == "none, cameras all, with aux, image_um 5"


def test_a_study_may_set_what_the_models_of_the_catalogue_take_and_nothing_else() -> None:
    assert {name: tuple(ap_models.get(name).settings) for name in ap_models.names()} == MODEL_SETTINGS
    assert MODEL_SETTINGS["brown14"] == ("r0_mm", "as_printed", "b4_printed", "sign_printed")


def test_the_shipped_studies_are_without_fault_and_named_as_their_files() -> None:
    wanted = {"ap-models", "redundancy", "second-zero", "stationarity", "wrong-model", "control", "ap-choice", "film"}
    assert set(shipped.names()) == wanted
    for name in shipped.names():
        asked = shipped.study(name)
        assert asked.name == name
        assert conditions_of(asked)
        for method in methods_of(asked):
            method.ap_model()


def test_a_dry_run_imports_no_numerics() -> None:
    code = (
        "import sys; from click.testing import CliRunner; from studies.commands.program import main\n"
        "r = CliRunner().invoke(main, ['run', 'redundancy', '--dry-run']); assert r.exit_code == 0, r.output\n"
        "assert '27 conditions in 10 geometries x 1 methods = 270 cells' in r.output\n"
        "print([m for m in ('scipy', 'numba', 'pandas', 'pyarrow', 'matplotlib', 'joblib') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True)
    assert done.stdout.strip() == "[]"


LEVELS = {
    "noise_um": "[3.0, 6.0]",
    "noise_times": "[0.5, 2.0]",
    "assumed_um": "[4.0, 5.5]",
    "geodetic_mm": "[0.0, 9.5]",
    "scale": "[9000.0, 10000.0]",
    "scale_times": "[0.9, 1.1]",
    "forward_overlap": "[0.5, 0.8]",
    "sidelap": "[0.2, 0.4]",
    "strips": "[2, 8]",
    "images_per_strip": "[2, 5]",
    "headings_gon": "[[0.0], [0.0, 100.0]]",
    "spacing_m": "[400.0, 600.0]",
    "points_per_side": "[3, 4]",
    "group_size": "[1, 2]",
    "relief_m": "[0.0, 40.0]",
    "control": '["corners", "perimeter"]',
    "control_sigma_xy_mm": "[5.0, 20.0]",
    "control_sigma_z_mm": "[5.0, 20.0]",
    "lens": "[0.0, 2.0]",
    '"effects[0].effect.r0_mm"': "[90.0, 110.0]",
    "chain": '["undisturbed", {preset = "psk-1969", without = ["lens"]}]',
    "chain_without": '["errors", ["lens", "settings"]]',
    "film_field_um": "[1.0, 3.0]",
    "inner_orientation": '["affine", "projective"]',
    '"chain.lenses[0].tilt_deg[0]"': "[0.0, 0.1]",
    '"reductions.lens"': "[false]",
}
"""two levels of every factor, none of them that of the scenario"""
EVERYTHING = """
[study]
name = "everything"
question = "Can it be swept?"
seed = 1
[scenario]
preset = "rheidt-1980"
measurement = { unused_groups = [], counts = {} }
chain = "psk-1969"
[factors]
lens = { paths = ["effects[0].effect.k1", "effects[1].effect.k1"], times = true }
[grid]
FACTOR = LEVELS
[methods]
ap = ["none"]
"""


@pytest.mark.parametrize("factor", LEVELS)
def test_everything_in_the_scenario_can_be_a_factor(factor: str) -> None:
    asked = study_from_text(EVERYTHING.replace("FACTOR", factor).replace("LEVELS", LEVELS[factor]))
    base = conditions_of(study_from_text(EVERYTHING.replace("FACTOR = LEVELS", "")))
    situations = [(c.scenario, c.measuring) for c in (*base, *conditions_of(asked))]
    assert len(situations) == (2 if factor == '"reductions.lens"' else 3)
    assert all(a != b for a, b in itertools.combinations(situations, 2))


def test_every_named_factor_is_tried() -> None:
    assert set(NAMED) <= set(LEVELS)
