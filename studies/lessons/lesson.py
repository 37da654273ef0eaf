"""What a lesson is, and which there are."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

SEED = 1984
"""of every world that the lessons fly, so that all visitors see the same numbers"""


class LessonError(ValueError):
    """What was asked cannot be answered; the sentence says why, and what to do."""


@dataclass(frozen=True)
class Lesson:
    """A lesson: its id, which names its modules and its address, its question, and in a line what is moved."""

    id: str
    question: str
    summary: str

    @property
    def app_file(self) -> Path:
        """The marimo app that shows the lesson."""
        return Path(__file__).parent / "apps" / f"{self.id}.py"


LESSONS = (
    Lesson(
        "redundancy",
        "What does redundancy buy?",
        "Fly more strips, more headings, measure more points a group, and see which standard errors fall.",
    ),
    Lesson(
        "second_zero",
        "Why a second zero crossing?",
        "Move r0 and see the correlation between flying height and radial distortion collapse.",
    ),
    Lesson(
        "which_model",
        "Which model for which distortion?",
        "Choose the truth and the additional parameters; see why sigma0 alone does not tell whether they fit.",
    ),
    Lesson(
        "interval",
        "What is a 95 % interval?",
        "Repeat a flight hundreds of times and count how many intervals hold the truth, with right and wrong models.",
    ),
    Lesson(
        "gross_error",
        "Find the gross error: can it hide?",
        "Plant an error in an image coordinate and see whether the w-test finds it, and what it does if not.",
    ),
    Lesson(
        "own_block",
        "Fly your own block: how well will it do?",
        "Choose scale, overlap and control, and know the accuracy before anybody flies.",
    ),
)
"""All lessons in the order of teaching."""
