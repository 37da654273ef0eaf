"""Compiled code of an older version is not gone on with."""

from __future__ import annotations

import importlib
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from numba.core.dispatcher import Dispatcher

from simfield.numerics import machine_code
from simfield.numerics.machine_code import HOME, PACKAGES, mark, sources

COMPILED = sorted(
    path.relative_to(HOME).with_suffix("").as_posix().replace("/", ".")
    for package in PACKAGES
    for path in (HOME / package).rglob("*_compiled.py")
)


HERE = "simfield"
"""the package in which modules are made up"""


def dispatchers(module: str) -> list[Dispatcher]:
    found = importlib.import_module(module)
    return [each for each in vars(found).values() if isinstance(each, Dispatcher) and each.py_func.__module__ == module]


@pytest.mark.parametrize("module", COMPILED)
def test_every_compiled_function_has_the_mark(module: str) -> None:
    for each in dispatchers(module):
        assert each._cache._cache_file._source_stamp[1] == mark(), each.py_func.__name__


@pytest.mark.parametrize("module", COMPILED)
def test_every_module_marks_its_functions_when_it_is_the_first_to_be_imported(module: str) -> None:
    if not dispatchers(module):
        return  # compiled by what it imports
    text = (HOME / module.replace(".", "/")).with_suffix(".py").read_text(encoding="utf-8")
    own = "machine_code.install()" in text
    by_kernels = "import" in text and any(
        line.startswith(("from simfield.numerics import", "from simfield.random import")) and word in text
        for line in text.splitlines()
        for word in ("kernel", "draw")
    )
    assert own or by_kernels


@pytest.mark.parametrize("module", COMPILED)
def test_constants_that_are_compiled_in_come_from_files_that_the_mark_has(module: str) -> None:
    """A number imported from elsewhere could change without a new mark."""
    found = importlib.import_module(module)
    marked = {path.relative_to(HOME).with_suffix("").as_posix().replace("/", ".") for path in sources()}
    used = {name for each in dispatchers(module) for name in each.py_func.__code__.co_names}
    for name in used & set(vars(found)):
        value = vars(found)[name]
        if isinstance(value, (int, float, tuple)) and not isinstance(value, bool):
            holders = [m for m in marked if m in sys.modules and vars(sys.modules[m]).get(name) is value]
            assert holders, f"{module} compiles in {name}"


def test_another_function_of_ours_is_compiled_again_when_an_inlined_one_changes(tmp_path: Path) -> None:
    """The case itself: two files, the second holds what the first one writes into itself."""
    home = tmp_path / "simfield"
    shutil.copytree(HOME / "simfield", home, ignore=shutil.ignore_patterns("__pycache__"))
    (home / "inner_compiled.py").write_text(
        "from simfield.numerics import inlined\n\n\n@inlined\ndef one(x):\n    return x + 1.0\n", encoding="utf-8"
    )
    (home / "outer_compiled.py").write_text(
        f"from {HERE}.inner_compiled import one\nfrom simfield.numerics import kernel\n\n\n"
        "@kernel\ndef two(x):\n    return 10.0 * one(x)\n",
        encoding="utf-8",
    )

    def asked() -> str:
        environment = {k: v for k, v in os.environ.items() if k != "NUMBA_CACHE_DIR"} | {"PYTHONPATH": str(tmp_path)}
        run = subprocess.run(
            [sys.executable, "-c", f"from {HERE}.outer_compiled import two; print(two(1.0))"],
            cwd=tmp_path,
            env=environment,
            capture_output=True,
            text=True,
            timeout=300,
        )
        assert run.returncode == 0, run.stderr
        return run.stdout.strip()

    assert asked() == "20.0"
    assert list((home / "__pycache__").glob("outer_compiled.two*.nbi"))
    text = (home / "inner_compiled.py").read_text(encoding="utf-8")
    (home / "inner_compiled.py").write_text(text.replace("1.0", "2.0"), encoding="utf-8")
    assert asked() == "30.0"


def test_functions_of_others_are_not_touched() -> None:
    machine_code.install()
    known = machine_code.CacheImpl._locator_classes
    assert sum(each.__name__ == "Marked" for each in known) == len(known) / 2
    assert all(each.from_function(shutil.copytree, shutil.__file__) is None for each in known[: len(known) // 2])
