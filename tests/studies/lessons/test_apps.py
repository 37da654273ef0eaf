"""Every app runs without a browser, with controls moved too, and shows a reason where there is no answer."""

import importlib
import re
from types import SimpleNamespace

import pytest

from studies.lessons.apps.picture import Picture
from studies.lessons.lesson import LESSONS

pytest.importorskip("marimo", reason="the lessons need the extra `teach`")


MOVED = {
    "redundancy": {"strips": 2, "headings": 4, "points": 3},
    "second_zero": {"r0": 100, "camera": "sww", "auxiliary": True},
    "which_model": {"truth": "film: cubic", "model": "brown14", "headings": 1},
    "interval": {"model": "none", "quantity": "height at the edge", "trials": 50, "again": 3},
    "gross_error": {"place": "seen in 2 images", "axis": "y, across the flight", "size": 0},
    "own_block": {"scale": 16000, "overlap": 80, "control": "all around"},
}
"""values of the controls by the name of their variable"""


def run(lesson_id, **controls):
    """The numbers that are shown by what they are called, the figures, and everything as HTML."""
    app = importlib.import_module(f"studies.lessons.apps.{lesson_id}").app
    defs = {name: SimpleNamespace(value=value) for name, value in controls.items()}
    outputs, _ = app.run(defs=defs or None)
    pictures = [output for output in outputs if isinstance(output, Picture)]
    text = "\n".join(output.text for output in outputs if hasattr(output, "text"))
    return dict(re.findall(r'data-number="([^"]+)">([^<]+)<', text)), pictures, text


@pytest.mark.parametrize("lesson", LESSONS, ids=lambda lesson: lesson.id)
def test_an_app_runs_and_answers_to_its_controls(lesson):
    numbers, pictures, text = run(lesson.id)
    moved, others, _ = run(lesson.id, **MOVED[lesson.id])
    assert lesson.question in text
    assert len(numbers) == 4
    assert list(moved) == list(numbers)
    assert all(re.search(r"\d", value) for value in (*numbers.values(), *moved.values()))
    assert sum(moved[name] != numbers[name] for name in numbers) >= 3
    assert len(pictures) == len(others) == 1
    assert pictures[0].svg != others[0].svg


def test_the_formulas_of_the_paper_are_shown():
    for lesson in ("redundancy", "second_zero", "which_model"):
        assert "a_3(r^2-r_0^2) + a_4(r^4-r_0^4)" in run(lesson)[2]


def test_a_problem_is_shown_in_place_of_an_answer():
    numbers, pictures, text = run("own_block", scale=10000, overlap=60, control="none")
    assert (numbers, pictures) == ({}, [])
    # marimo carries the HTML of a callout in an attribute, escaped twice
    assert re.search(r"<marimo-callout-output [^>]*data-problem=.*This block cannot be adjusted: .*no control", text)


def test_what_a_picture_says_is_escaped():
    assert 'alt="&lt;script&gt; &quot;"' in Picture(b"<svg/>", '<script> "')._repr_html_()


def test_every_lesson_has_its_app_and_its_script():
    assert [lesson.id for lesson in LESSONS] == list(MOVED)
    for lesson in LESSONS:
        assert lesson.app_file.is_file()
