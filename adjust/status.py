"""How an adjustment ended, in a sentence."""

from __future__ import annotations

from enum import Enum

CHECK_START = "check the approximate orientations: Z0, the angles and their unit (degrees)"
"""what to look at when the iteration went astray"""


class Status(Enum):
    """The end of an adjustment; the value is the sentence that a user reads."""

    CONVERGED = "converged"
    NO_START = "no start values could be found"
    BEHIND_CAMERA = "a point lies behind a camera"
    SINGULAR = "the normal equations are singular"
    NOT_CONVERGED = "the iteration did not converge"
    TOO_LITTLE_REDUNDANCY = "there are too few observations"
    NOT_FINITE = "the computation left the range of numbers"

    @property
    def ok(self) -> bool:
        """Whether there are estimates: the iteration converged."""
        return self is Status.CONVERGED
