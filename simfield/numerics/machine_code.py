"""Compiled code on disk belongs to the sources it was made from.

numba keeps what it compiles and looks at the file of a function alone: after an update that changes a function which is
written into others, these would go on with the old one. So the mark of a compiled function has all sources in it that
may be written into another.
"""

from __future__ import annotations

import hashlib
from functools import lru_cache
from pathlib import Path
from typing import Any

from numba.core.caching import CacheImpl

HOME = Path(__file__).resolve().parents[2]
PACKAGES = ("simfield", "adjust", "studies")
WRITTEN_INTO_OTHERS = (
    *("*_compiled.py", "numerics/lanes.py", "numerics/arena.py", "random/counter_normals.py"),
    *("disturbances/expansion.py", "reductions/inner.py", "reductions/lens.py", "trials/traced_terms.py"),
)
"""functions that are inlined, and modules whose constants are"""
GENERATED = "_simfield_terms_"
"""what modules are called that are generated for a set of additional parameters"""


@lru_cache(maxsize=1)
def sources() -> tuple[Path, ...]:
    """The files whose functions and constants are compiled into those of others."""
    found = {path for package in PACKAGES for kind in WRITTEN_INTO_OTHERS for path in (HOME / package).rglob(kind)}
    return tuple(sorted(found))


@lru_cache(maxsize=1)
def mark() -> str:
    """A hash of these files."""
    total = hashlib.sha256()
    for path in sources():
        total.update(path.read_bytes() + b"\0")
    return total.hexdigest()


def _marked(locator: Any) -> Any:
    """A locator of numba's that takes our functions alone, and marks them."""

    class Marked(locator):  # type: ignore[misc]
        @classmethod
        def from_function(cls, py_func: Any, py_file: str) -> Any:
            ours = GENERATED in py_file or any((HOME / p) in Path(py_file).resolve().parents for p in PACKAGES)
            return super().from_function(py_func, py_file) if ours else None

        def get_source_stamp(self) -> Any:
            return super().get_source_stamp(), mark()

    return Marked


def install() -> None:
    """Mark all of our functions that are compiled from now on."""
    known: Any = CacheImpl._locator_classes
    if not any(each.__name__ == "Marked" for each in known):
        CacheImpl._locator_classes = [*map(_marked, known), *known]
