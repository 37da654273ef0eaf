"""Nothing is found in good blocks; the usual mistakes, put in at random, are named with their place."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from adjust import adjust_block, ap_models
from adjust.plausibility import Finding, before, checked
from simfield import presets, simulate, write_block
from simfield.block import Block
from studies.commands.program import main
from tests.adjust.plausibility.mistakes import MISTAKES, Made, Random, control_exchanged, metres, y_down

HARMLESS = {("grid-small", "kappa the other way")}
"""headings of 0 and 180 degrees alone: a kappa of the other sign is nearly the same attitude"""
SEEDS = {"grid-small": 40, "rheidt-1980": 4}
"""a large block that does not converge takes a minute in some cases"""
CLEAN, CLEAN_LONG = 3, 200
NAMED_LEAST = 0.95
FOUND_MOST = 0.01
STANDARD_ERRORS = 3.0


def model(preset: str):
    return ap_models.get("optical" if preset in ("grid-small", "convergent") else "brown14")


def is_named(found: tuple[Finding, ...], kind: str, words: tuple[str, ...]) -> bool:
    return any(each.kind == kind and all(word in each.place + each.text for word in words) for each in found)


def share_named(preset: str, name: str, make: Callable[[Block, Random], Made], seeds: int) -> float:
    named = 0
    for seed in range(seeds):
        block, (kind, words) = make(simulate(presets[preset], seed)[0], np.random.default_rng([seed, len(name)]))
        named += is_named(checked(adjust_block(block, ap_models.get("optical"))), kind, words)
    return named / seeds


@pytest.mark.parametrize("preset", presets)
def test_nothing_is_found_in_a_good_block(preset: str) -> None:
    for seed in range(CLEAN):
        assert checked(adjust_block(simulate(presets[preset], seed)[0], model(preset))) == ()


@pytest.mark.slow
@pytest.mark.parametrize("preset", presets)
def test_nothing_is_found_in_two_hundred_good_blocks(preset: str) -> None:
    found = [checked(adjust_block(simulate(presets[preset], seed)[0], model(preset))) for seed in range(CLEAN_LONG)]
    share = sum(bool(each) for each in found) / CLEAN_LONG
    assert share <= FOUND_MOST, [each for each in found if each][:3]


@pytest.mark.parametrize("name", [name for name in MISTAKES if ("grid-small", name) not in HARMLESS])
def test_a_mistake_is_named(name: str) -> None:
    assert share_named("grid-small", name, MISTAKES[name], 3) == 1.0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("preset", "name"), [(preset, name) for preset in SEEDS for name in MISTAKES if (preset, name) not in HARMLESS]
)
def test_a_mistake_is_named_nearly_always(preset: str, name: str) -> None:
    share = share_named(preset, name, MISTAKES[name], SEEDS[preset])
    assert share >= NAMED_LEAST - STANDARD_ERRORS * np.sqrt(NAMED_LEAST * (1.0 - NAMED_LEAST) / SEEDS[preset])


def test_the_tables_alone_say_what_needs_no_adjustment() -> None:
    block = simulate(presets["grid-small"], 1)[0]
    assert before(block) == ()
    found = before(metres(block, np.random.default_rng(1))[0])
    assert (found[0].kind, found[0].severity) == ("units", "worthless")


class TestCommand:
    def test_a_good_block(self, tmp_path: Path) -> None:
        write_block(simulate(presets["grid-small"], 1)[0], tmp_path)
        done = CliRunner().invoke(main, ["check", str(tmp_path), "--ap", "optical"])
        assert (done.exit_code, done.output) == (0, "nothing found\n")

    @pytest.mark.parametrize("make", [y_down, control_exchanged])
    def test_a_bad_block_is_1_and_says_what_where_and_what_to_try(
        self, tmp_path: Path, make: Callable[[Block, Random], Made]
    ) -> None:
        block, (kind, words) = make(simulate(presets["rheidt-1980"], 1)[0], np.random.default_rng(2))
        write_block(block, tmp_path / "block")
        done = CliRunner().invoke(main, ["check", str(tmp_path / "block"), "--json", str(tmp_path / "found.json")])
        assert done.exit_code == 1
        assert "worthless" in done.output
        found = json.loads((tmp_path / "found.json").read_text())["findings"]
        assert {tuple(each) for each in found} == {("kind", "severity", "place", "text", "advice")}
        assert any(each["kind"] == kind and all(w in each["place"] + each["text"] for w in words) for each in found)
        adjusted = CliRunner().invoke(main, ["adjust", str(tmp_path / "block"), "--ap", "optical", "--json", "-"])
        assert f'"kind": "{kind}"' in adjusted.output
        assert "probably wrong: " in adjusted.stderr

    def test_a_folder_that_is_no_block_is_1(self, tmp_path: Path) -> None:
        done = CliRunner().invoke(main, ["check", str(tmp_path)])
        assert done.exit_code == 1
        assert "cameras.csv" in done.output
