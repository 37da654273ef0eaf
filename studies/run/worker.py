"""What a worker process does before it works: it outlives neither its parent nor an interrupt meant for the parent."""

from __future__ import annotations

import contextlib
import ctypes
import os
import signal
import threading
import time
from functools import cache

LOOKS_EVERY_S = 0.2
TRIM_THRESHOLD, MMAP_THRESHOLD = -1, -3
KEPT_BYTES = 32 << 20
"""the largest that glibc takes"""
MAIN = int(os.environ.get("SIMFIELD_MAIN", "0"))


class BackendError(RuntimeError):
    """The machinery that computes has failed; one line says how. The store is whole."""


def become_main() -> None:
    """Tell the processes that this one starts whose they are."""
    global MAIN
    MAIN = os.getpid()
    os.environ["SIMFIELD_MAIN"] = str(MAIN)


@cache
def prepare() -> None:
    """In a worker of ours: ignore the interrupt of the terminal, and end when the parent has ended.

    The parent is the one that the environment names, not the one found here: it may have died while this process
    started, and nobody else would end a worker that waits for work.
    """
    if "MALLOC_TRIM_THRESHOLD_" in os.environ:
        _keep_memory()
    if not MAIN or os.getpid() == MAIN or threading.current_thread() is not threading.main_thread():
        return  # no process of ours: the caller itself, or a worker of a cluster
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_watch, daemon=True).start()


def _keep_memory() -> None:
    """Keep freed memory for the next block of trials, which needs the same again.

    dask has its workers give memory back at once, by that variable; getting it again took a tenth of the time.
    """
    with contextlib.suppress(OSError, AttributeError):  # no glibc
        mallopt = ctypes.CDLL("libc.so.6").mallopt
        mallopt(MMAP_THRESHOLD, KEPT_BYTES)
        mallopt(TRIM_THRESHOLD, 4 * KEPT_BYTES)


def _watch() -> None:
    while os.getppid() == MAIN:
        time.sleep(LOOKS_EVERY_S)
    os._exit(1)
