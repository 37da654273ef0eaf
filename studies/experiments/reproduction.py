"""What every reproduction of a published experiment comes to: files, failures, or a sentence why there is none."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path


class ReproductionError(RuntimeError):
    """The experiment cannot be reproduced; one line says why."""


@dataclass(frozen=True)
class Reproduction:
    """What was written, and a line for every adjustment of a trial that failed."""

    files: list[Path]
    failures: list[str]
