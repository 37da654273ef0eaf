"""The benchmark runs without any of the solvers it compares with, and writes what is read from it."""

from __future__ import annotations

import importlib
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

TOP = Path(__file__).parents[1]
KEYS = (
    "replicates_over_ceres",
    "adjust_over_ceres",
    "adjust_with_std_over_ceres",
    "share_of_flop_limit",
    "scaling_exponent",
)


@pytest.mark.slow
def test_the_quick_benchmark_runs_without_peers(tmp_path: Path) -> None:
    output = tmp_path / "quick.json"
    command = [sys.executable, "-m", "benchmarks.bench", "--quick", "--peers", "--output", str(output)]
    done = subprocess.run(command, cwd=TOP, capture_output=True, text=True, timeout=300, env=dict(os.environ))
    assert done.returncode == 0, done.stderr
    found = json.loads(output.read_text(encoding="utf-8"))
    assert set(KEYS) <= set(found)
    assert found["agree"]
    assert found["replicates_over_ceres"] is None
    assert 0.0 < found["share_of_flop_limit"] < 1.0
    assert found["agreement"]["forms"]["brown14"]["unknowns"] == 616
    assert (
        found["times"]["adjust_replicates brown14"]["median_ms"] < found["times"]["adjust_block brown14"]["median_ms"]
    )
    assert done.stdout.startswith("times faster")


@pytest.mark.parametrize("images", [39, 156])
def test_the_growing_block_is_what_it_says(images: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(TOP))
    block = importlib.import_module("benchmarks.growing").growing_block(images)
    assert len(block.images) == images
    assert 80.0 < len(block.observations) / images < 90.0
    assert block.points.fixed.any(axis=1).sum() > images / 5
