"""What a worker process does before it works: it outlives neither its parent nor an interrupt meant for the parent."""

from __future__ import annotations

import os
import signal
import threading
import time
from functools import cache

LOOKS_EVERY_S = 1.0
MAIN = os.environ.get("SIMFIELD_MAIN", "")


def become_main() -> None:
    """Tell the processes that this one starts whose they are."""
    os.environ["SIMFIELD_MAIN"] = str(os.getpid())


@cache
def prepare() -> None:
    """In a worker of ours: ignore the interrupt of the terminal, and end when the parent has ended."""
    if not MAIN or str(os.getpid()) == MAIN or threading.current_thread() is not threading.main_thread():
        return  # no process of ours: the caller itself, or a worker of a cluster
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = os.getppid()
    threading.Thread(target=_watch, args=(parent,), daemon=True).start()


def _watch(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(LOOKS_EVERY_S)
    os._exit(1)
