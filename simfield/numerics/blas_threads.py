"""BLAS on one thread while one block is adjusted.

Two threads change the last bits and, at the size of these matrices, cost up to 17 times when the other core is busy.
"""

from __future__ import annotations

from contextlib import AbstractContextManager
from functools import lru_cache
from typing import Any

from threadpoolctl import ThreadpoolController


@lru_cache(maxsize=1)
def _controller() -> ThreadpoolController:
    return ThreadpoolController()


def one_thread() -> AbstractContextManager[Any]:
    """A context in which BLAS takes one thread; the libraries are looked up once, entering it costs microseconds."""
    context: AbstractContextManager[Any] = _controller().limit(limits=1, user_api="blas")
    return context
