"""The program that decides the numbers of a store: our code and the libraries that compute."""

from __future__ import annotations

import hashlib
from functools import lru_cache

from studies.session.installation import home, versions

COMPUTING = ("simfield", "adjust", "studies/design", "studies/comparison", "studies/trials")
"""the packages from which the numbers of a trial come; summaries and pages can be made anew from the trials"""
DECIDING = ("simfield", "numpy", "scipy", "numba")


@lru_cache(maxsize=1)
def program() -> dict[str, str]:
    """Versions of what computes, and a hash of our code, which tells two checkouts of one version apart."""
    found = versions()
    return {name: found[name] for name in DECIDING} | {"code": _hash_of_code()}


def _hash_of_code() -> str:
    total = hashlib.sha256()
    for package in COMPUTING:
        for path in sorted((home() / package).rglob("*.py")):
            total.update(path.relative_to(home()).as_posix().encode() + b"\0")
            total.update(path.read_bytes().replace(b"\r\n", b"\n") + b"\0")
    return total.hexdigest()[:16]
