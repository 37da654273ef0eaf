"""Say so when numerical code is compiled: once on a machine, and again after an update."""

from __future__ import annotations

import logging
from typing import Any

from numba.core import event

OURS = ("adjust", "simfield", "_simfield_terms")
logger = logging.getLogger("adjust")


class _Notice(event.Listener):
    """Logs one line a process, at the first compilation of one of our functions."""

    def __init__(self) -> None:
        self.said = False

    def on_start(self, event: Any) -> None:
        module = str(getattr(event.data["dispatcher"].py_func, "__module__", ""))
        if not self.said and module.startswith(OURS):
            self.said = True
            logger.warning("compiling numerical code, once on this machine; this takes some seconds")

    def on_end(self, event: Any) -> None:
        pass


def install() -> None:
    """Watch numba's compilations from now on."""
    event.register("numba:compile", _Notice())  # type: ignore[no-untyped-call]
