"""Is it our own packages that Python finds? A package index has unrelated ones named `adjust` and `studies`."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path

MARKS = {"simfield": "simulate.py", "adjust": "bundle.py", "studies": "session/installation.py"}
"""a file of ours that an unrelated package of the same name has not"""
LIBRARIES = (
    *("numpy", "scipy", "pandas", "matplotlib", "joblib", "numba", "click", "pydantic", "tqdm", "threadpoolctl"),
    *("pyarrow", "jinja2", "markdown-it-py", "lazy-loader"),
)


def home() -> Path:
    """The folder that holds our packages."""
    return Path(__file__).resolve().parents[2]


def shadows() -> list[str]:
    """A sentence for each of our packages that another one hides or has overwritten; nothing is imported."""
    sentences = []
    for package, mark in MARKS.items():
        spec = find_spec(package)
        folders = [Path(p).resolve() for p in (spec.submodule_search_locations or ())] if spec else []
        if not folders:
            found = spec.origin if spec else "nothing"
            sentences.append(f"package {package!r} of simfield is hidden: Python finds {found}")
        elif folders[0] != home() / package:
            sentences.append(f"package {package!r} of simfield is hidden by another one: {folders[0]}")
        elif not (folders[0] / mark).exists() or not _ours(folders[0] / "__init__.py", package):
            sentences.append(f"package {package!r} of simfield was overwritten by another one: {folders[0]}")
    return sentences


def versions() -> dict[str, str]:
    """The versions of simfield and of the libraries it stands on; "missing" for one that is not installed."""
    from importlib.metadata import PackageNotFoundError, version

    found = {}
    for name in ("simfield", *LIBRARIES):
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "missing"
    return found


def _ours(init: Path, package: str) -> bool:
    return package != "adjust" or "From a block to estimates" in init.read_text(encoding="utf-8", errors="replace")
