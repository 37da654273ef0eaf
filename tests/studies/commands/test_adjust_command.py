"""`simfield adjust` as a surveyor meets it: what cannot be adjusted is named in one line, further files are used."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

from adjust import adjust_block
from simfield.block.block import Block
from simfield.block.further import Further, Lines
from simfield.files.block_folder import write_block
from studies.commands.program import main
from tests import synthetic
from tests.adjust.observations.test_stated import MODEL, further
from tests.adjust.solution.test_failures import TestImages

USERS_SET = '''"""A set of the user's own: an affinity, whose scale a flying height carries just as well."""
from adjust.ap_models.model import ApModel, Certainty


class Affine(ApModel):
    id = "affine"
    title, author, year, source, certainty = "Affine", "-", 0, "-", Certainty.CERTAIN
    parameters = ("k1", "k2")

    def terms(self, x, y):
        return [(x, y), (x, -y)]
'''


def call(block: Block, folder: Path, *arguments: str) -> Result:
    write_block(block, folder)
    return CliRunner().invoke(main, ["adjust", str(folder), *arguments])


def partial(w: synthetic.World, *, scale: bool) -> synthetic.World:
    """Control that holds shifts and rotations, with or without a second X that gives the scale."""
    ids = w.block.points.ids
    sigma = np.full_like(w.coordinates, np.nan)
    sigma[ids.index("11")] = 0.0
    sigma[ids.index("15"), 0 if scale else 1 :] = 0.0
    sigma[ids.index("55"), 2] = 0.0
    role = np.where(np.isfinite(sigma).any(axis=1), "control", "tie").tolist()
    return w.with_points(role=role, coordinates=np.where(np.isfinite(sigma), w.coordinates, np.nan), sigma=sigma)


def with_distance(w: synthetic.World) -> Block:
    ids = w.block.points.ids
    ends = ids.index("16"), ids.index("49")
    length = float(np.linalg.norm(w.coordinates[ends[1]] - w.coordinates[ends[0]]))
    return replace(w.block, further=Further(distances=Lines([ends[0]], [ends[1]], [length], [0.01])))


DEFECTS: dict[str, tuple[Callable[[synthetic.World], Block], str]] = {
    "no control": (lambda w: w.controlled([]).block, "there is no control, so the datum is free"),
    "one control point": (
        lambda w: w.controlled(["33"]).block,
        "the control fixes only 3 of the 7 datum elements; free: rotation about X, rotation about Y, rotation about Z "
        "and scale",
    ),
    "no scale": (
        lambda w: partial(w, scale=False).block,
        "the control fixes only 6 of the 7 datum elements; free: mainly scale",
    ),
    "an image with two points": (
        lambda w: TestImages().thinned(w, 2, 2),
        "image ww-3 (2 measured points) cannot be oriented: three or more points are needed, not on one line",
    ),
}


@pytest.mark.parametrize("name", DEFECTS)
def test_a_rank_defect_is_refused_in_one_line(ww_world: synthetic.World, tmp_path: Path, name: str) -> None:
    make, said = DEFECTS[name]
    done = call(make(ww_world.with_noise(np.random.default_rng(1))), tmp_path / "block", "--ap", "none")
    assert done.exit_code == 1
    assert done.stdout == ""
    assert done.stderr.splitlines() == [line for line in done.stderr.splitlines() if "singular" in line]
    assert said in done.stderr


def test_parameters_of_the_form_of_an_orientation(vertical_world: synthetic.World, tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(USERS_SET, encoding="utf-8")
    block = vertical_world.with_noise(np.random.default_rng(1)).block
    done = call(block, tmp_path / "block", "--ap", f"{tmp_path / 'mine.py'}:Affine")
    assert done.exit_code == 1
    assert "k1 of camera ww and Z0 of all 12 images cannot be separated" in done.stderr
    done = call(block, tmp_path / "block", "--ap", "brown1971")
    assert done.exit_code == 1
    assert "dc of camera ww and Z0 of all 12 images cannot be separated" in done.stderr


def test_what_cures_them(ww_world: synthetic.World, tmp_path: Path) -> None:
    """A free network without control; a second X, or a distance, where the scale was missing."""
    w = ww_world.with_noise(np.random.default_rng(1))
    free = call(w.controlled([]).block, tmp_path / "free", "--ap", "none", "--datum", "inner", "--json", "-")
    scaled = call(partial(w, scale=True).block, tmp_path / "scaled", "--ap", "none", "--json", "-")
    measured = call(with_distance(partial(w, scale=False)), tmp_path / "measured", "--ap", "none", "--json", "-")
    found = [json.loads(done.stdout) for done in (free, scaled, measured)]
    assert {each["status"] for each in found} == {"converged"}
    for each in found[1:]:
        assert each["sigma0"] == pytest.approx(found[0]["sigma0"], rel=1e-9), "the datum strains no block"
    assert found[2]["observations"] == found[1]["observations"] + 1
    assert found[2]["unknowns"] == found[1]["unknowns"] + 1


@pytest.fixture
def stated(ww_world: synthetic.World) -> Block:
    w = ww_world.with_noise(np.random.default_rng(5)).controlled(synthetic.CONTROL, (0.02, 0.02, 0.02))
    return replace(w.block, further=further(ww_world))


def test_further_files_are_used_and_stand_in_the_protocol(stated: Block, tmp_path: Path) -> None:
    done = call(stated, tmp_path / "block", "--ap", "torlegard", "-o", str(tmp_path / "out"))
    assert done.exit_code == 0, done.output
    found = json.loads((tmp_path / "out" / "protocol.json").read_text(encoding="utf-8"))
    a = adjust_block(stated, MODEL)
    assert found["sigma0"] == a.sigma0
    groups = {g["group"]: g for g in found["groups"]}
    assert list(groups) == [
        "images of ww",
        "control",
        "positions",
        "attitudes",
        "distances",
        "height differences",
        "priors of ww",
    ]
    assert sum(g["redundancy"] for g in groups.values()) == pytest.approx(a.redundancy, abs=1e-7)
    assert len(found["further"]) == 30 + 15 + 3 + 2 + 2
    kappa = next(e for e in found["further"] if e["observation"] == "kappa of image ww-1")
    assert kappa["unit"] == "deg"
    # delta0 of the search, and the component of the attitudes, 15 of them, that was found
    stated = np.degrees(found["reliability"]["delta0"] * 1e-4) / np.sqrt(kappa["redundancy"])
    assert kappa["mdb"] == pytest.approx(stated * groups["attitudes"]["sigma_factor"], rel=0.1)
    bias = next(e for e in found["biases"] if (e["owner"], e["name"]) == ("position of strip s2", "offset X0"))
    assert abs(bias["value"] + 0.7) < 4.5 * bias["std"]
    text = (tmp_path / "out" / "protocol.txt").read_text(encoding="utf-8")
    for line in ("further observations: positions, attitudes,", "offset Z0 of position of strip s3", "prior of a5 of"):
        assert line in text
    header = (tmp_path / "out" / "correlations.csv").read_text(encoding="utf-8").splitlines()[0]
    assert "position of strip s2 drift X0" in header
    assert header.endswith(",48 Z"), "coordinates that distances tie stand among the orientation unknowns"


def test_they_can_be_left_out(stated: Block, tmp_path: Path) -> None:
    arguments = [part for name in ("stations", "ap_priors") for part in ("--leave-out", name)]
    done = call(stated, tmp_path / "block", "--ap", "optical", "--json", "-", *arguments)
    assert done.exit_code == 0, done.output
    assert json.loads(done.stdout)["observations"] == 2 * len(stated.observations) + 15 + 3 + 2


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--ap", "none"], "ap_priors: the set none of camera ww has no parameter 'a1'"),
        (["--ap", "torlegard", "--datum", "inner"], "a free network cannot hold observed stations"),
    ],
)
def test_what_does_not_fit_is_said_in_one_line(stated: Block, tmp_path: Path, arguments: list[str], said: str) -> None:
    done = call(stated, tmp_path / "block", *arguments)
    assert done.exit_code == 1
    assert said in done.stderr
    assert len(done.stderr.splitlines()) == 1


def test_a_wrong_further_file_is_named_with_its_place(stated: Block, tmp_path: Path) -> None:
    write_block(stated, tmp_path / "block")
    file = tmp_path / "block" / "distances.csv"
    file.write_text(file.read_text(encoding="utf-8").replace("11,16", "11,nobody"), encoding="utf-8")
    done = CliRunner().invoke(main, ["adjust", str(tmp_path / "block"), "--ap", "torlegard"])
    assert done.exit_code == 1
    assert "distances.csv, row 2, column to_point_id: 'nobody' is not in points.csv" in done.stderr
