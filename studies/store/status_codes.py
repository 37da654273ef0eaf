"""How each trial ended, as a code in its status column; the codes of a store never change their meaning."""

from __future__ import annotations

from adjust import Status

CODES = {
    Status.CONVERGED: 0,
    Status.NO_START: 1,
    Status.BEHIND_CAMERA: 2,
    Status.SINGULAR: 3,
    Status.NOT_CONVERGED: 4,
    Status.TOO_LITTLE_REDUNDANCY: 5,
    Status.NOT_FINITE: 6,
}
CONVERGED, UNDRAWN, OTHER, CRASHED, TIMEOUT, NO_NOMINAL, ABSENT = 0, 98, 99, 100, 101, 102, 103
SENTENCES = {code: status.value for status, code in CODES.items()} | {
    UNDRAWN: "its image points could not be simulated",
    OTHER: "the adjustment failed",
    CRASHED: "its worker died",
    TIMEOUT: "it did not end",
    NO_NOMINAL: "the condition itself cannot be simulated or adjusted",
    ABSENT: "its block was computed without this method",
}
LOST = {"crashed": CRASHED, "timeout": TIMEOUT, "undrawn": UNDRAWN}
