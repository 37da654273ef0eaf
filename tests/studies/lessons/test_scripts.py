"""The lessons as scripts for Jupyter: plain Python in the percent format, and all of them run."""

import subprocess
import sys
from pathlib import Path

import pytest

from studies.lessons.lesson import LESSONS

TOP = Path(__file__).parents[3]
FOLDER = TOP / "docs/lessons"


def test_there_is_one_for_every_lesson():
    assert sorted(f.stem for f in FOLDER.glob("*.py")) == sorted(lesson.id for lesson in LESSONS)


@pytest.mark.slow
@pytest.mark.parametrize("lesson", LESSONS, ids=lambda lesson: lesson.id)
def test_a_script_runs(lesson, tmp_path):
    script = FOLDER / f"{lesson.id}.py"
    text = script.read_text(encoding="utf-8")
    assert text.startswith(f"# %% [markdown]\n# # {lesson.question}\n")
    assert text.count("\n# %%\n") >= 2
    command = [sys.executable, "-W", "error", str(script)]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip()
    assert list(tmp_path.iterdir()) == []
