"""What all apps of the lessons show alike: the heading, the numbers, and a problem in place of an answer."""

from __future__ import annotations

import html
from collections.abc import Callable
from typing import TypeVar

import marimo as mo

from studies.lessons.lesson import LESSONS, LessonError
from studies.texts import unbroken

Answer = TypeVar("Answer")

NUMBERS = "display:flex;flex-wrap:wrap;gap:0.6rem;margin:0.4rem 0"
NUMBER = "border:1px solid #c8c8c8;border-radius:6px;padding:0.5rem 0.9rem;min-width:8.5rem;flex:1"


def heading(lesson_id: str, introduction: str) -> mo.Html:
    """The question of a lesson as its title, the way back, and an introduction in Markdown."""
    number, lesson = next((n, each) for n, each in enumerate(LESSONS, start=1) if each.id == lesson_id)
    return mo.md(f"[All lessons](../) · lesson {number} of {len(LESSONS)}\n\n# {lesson.question}\n\n{introduction}")


def numbers(*shown: tuple[str, str, str]) -> mo.Html:
    """Numbers side by side: what it is, the value with its unit, and a remark."""
    cells = "".join(_number(*each) for each in shown)
    return mo.Html(f'<dl style="{NUMBERS}">{cells}</dl>')


def _number(label: str, value: str, remark: str) -> str:
    name, shown = html.escape(label, quote=True), html.escape(value.replace("-", "−"))
    return (
        f'<div style="{NUMBER}"><dt style="font-size:0.85rem">{name}</dt>'
        f'<dd style="font-size:1.45rem;margin:0" data-number="{name}">{shown}</dd>'
        f'<div style="font-size:0.8rem;color:#5a5a5a">{html.escape(unbroken(remark))}</div></div>'
    )


def controls(*elements: object) -> mo.Html:
    """The controls in a row that wraps on narrow screens."""
    return mo.hstack(list(elements), justify="start", gap=2.0, wrap=True, align="end")


def answered(compute: Callable[[], Answer]) -> Answer:
    """The answer; where there is none, its reason is shown and nothing that hangs on it."""
    try:
        return compute()
    except LessonError as error:
        sentence = html.escape(str(error)[:1].upper() + str(error)[1:])
        mo.stop(True, mo.callout(mo.Html(f'<div data-problem="">{sentence}.</div>'), kind="warn"))
        raise
