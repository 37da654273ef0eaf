"""Study files with random damage: a StudyError or a study, never anything else, and soon."""

from __future__ import annotations

import random
import time
from collections.abc import Callable

import pytest

from studies.design import shipped
from studies.design.study import StudyError
from studies.design.study_file import read_study, study_from_text
from tests.studies.small_study import TEXT

SEEDS = (TEXT, *((shipped.FOLDER / f"{name}.toml").read_text(encoding="utf-8") for name in shipped.names()))
WORDS = (
    *("nan", "inf", "-1", "0", "1e999", "9" * 25, "true", '"x"', "[]", "{}", "[[1]]", "1979-05-27", "{ a = 1 }"),
    *('"\\u0000"', "[grid]", "[[zip]]", "[study]", "[methods]", "[scenario.changes]", "ap = 3", "=", '"""', ".."),
    *("flights[*].scale", "#"),
)
CHARACTERS = "\0\t\"'[]{\ufeff\U0001f600abc019.,=-_ "
Mutation = Callable[[random.Random, str], str]


def cut(chance: random.Random, text: str) -> str:
    first = chance.randrange(len(text))
    return text[:first] + text[first + chance.randrange(1, 40) :]


def doubled(chance: random.Random, text: str) -> str:
    lines = text.splitlines(keepends=True)
    line = chance.choice(lines)
    lines.insert(chance.randrange(len(lines)), line)
    return "".join(lines)


def replaced(chance: random.Random, text: str) -> str:
    first = chance.randrange(len(text))
    return text[:first] + chance.choice(WORDS) + text[first + chance.randrange(0, 12) :]


def swapped_value(chance: random.Random, text: str) -> str:
    lines = text.splitlines()
    places = [n for n, line in enumerate(lines) if "=" in line]
    place = chance.choice(places)
    lines[place] = f"{lines[place].partition('=')[0]}= {chance.choice(WORDS)}"
    return "\n".join(lines)


def character(chance: random.Random, text: str) -> str:
    place = chance.randrange(len(text))
    return text[:place] + chance.choice(CHARACTERS) + text[place:]


def try_one(chance: random.Random) -> bool:
    """Whether a mutated file is a study; anything but a StudyError with its lines is an error of ours."""
    text = chance.choice(SEEDS)
    for _ in range(chance.randrange(1, 4)):
        mutation: Mutation = chance.choice((cut, doubled, replaced, swapped_value, character))
        text = mutation(chance, text) or TEXT
    try:
        study_from_text(text)
    except StudyError as error:
        return not str(error).strip()  # a refusal without words would be no refusal
    return True


@pytest.mark.parametrize("part", [0, *(pytest.param(n, marks=pytest.mark.slow) for n in range(1, 10))])
def test_a_thousand_mutated_study_files(part: int) -> None:
    chance = random.Random(part)
    started = time.monotonic()
    accepted = sum(try_one(chance) for _ in range(1000))
    assert 0 < accepted < 1000
    assert time.monotonic() - started < 120.0


def test_binary_files(tmp_path) -> None:  # type: ignore[no-untyped-def]
    chance = random.Random(5)
    for _ in range(200):
        path = tmp_path / "study.toml"
        path.write_bytes(chance.randbytes(chance.randrange(0, 400)))
        with pytest.raises(StudyError):
            read_study(path)
