"""Sets of the user's own: a class in the user's file or module, named as "file.py:Class" or "module:Class"."""

from __future__ import annotations

import hashlib
import importlib
import importlib.util
import sys
from collections.abc import Mapping
from pathlib import Path
from types import ModuleType
from typing import Any

from adjust.ap_models.model import ApModel


def own_model(reference: str) -> type[ApModel]:
    """The class that a reference names; a path to a file is taken from the current folder.

    Raises KeyError, in one line, where there is no such file, module or class, or where it is no ApModel.
    """
    place, _, name = reference.rpartition(":")
    module = _from_file(Path(place)) if place.endswith(".py") else _from_path(place)
    found = getattr(module, name, None)
    if found is None:
        raise KeyError(f"{reference}: {place} has no class {name!r}")
    if not (isinstance(found, type) and issubclass(found, ApModel)):
        raise KeyError(f"{reference}: {name} is no subclass of adjust.ApModel")
    if place.endswith(".py"):
        # another process cannot import the class by name; it loads the file again
        again = f"{Path(place).resolve()}:{name}"
        setattr(found, "__reduce__", lambda model: (_remade, (again, model.settings)))  # noqa: B010
    return found


def _remade(reference: str, settings: Mapping[str, Any]) -> ApModel:
    return own_model(reference)(**settings)


def _from_path(place: str) -> ModuleType:
    try:
        return importlib.import_module(place)
    except Exception as error:  # whatever the user's module raises is a fault of the reference
        raise KeyError(f"{place}: cannot be imported: {type(error).__name__}: {error}") from error


def _from_file(path: Path) -> ModuleType:
    """The module of a file, run once as long as the file stays the same."""
    try:
        content = path.read_bytes()
    except OSError as error:
        raise KeyError(f"{path}: {error.strerror}") from error
    digest = hashlib.sha256(str(path.resolve()).encode() + content).hexdigest()[:16]
    name = f"_simfield_own_{digest}"
    if name in sys.modules:
        return sys.modules[name]
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    try:
        spec.loader.exec_module(module)
    except Exception as error:  # whatever the user's file raises is a fault of the reference
        del sys.modules[name]
        raise KeyError(f"{path}: cannot be run: {type(error).__name__}: {error}") from error
    return module
