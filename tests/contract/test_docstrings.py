"""What every public name says of itself: what it is, the shapes and units of its arrays, the errors it raises.

Public are the names of `simfield`, `adjust` and `adjust.ap_models`, the tables of a block, and the attributes of all
of these. Arrays are recognised by their annotation, errors by the `raise` statements of the function itself.
"""

from __future__ import annotations

import ast
import dataclasses
import inspect
import re
import textwrap
from collections.abc import Iterator
from functools import cached_property
from typing import Any

import pytest

import adjust
import simfield
from adjust import ap_models
from simfield.block import block as block_tables

ARRAYS = ("Floats", "Indices", "NDArray", "ImagePointTrials")
WITH_UNITS = ("Floats", "ImagePointTrials")
"""numbers and truth values have no unit"""
SHAPE = re.compile(r"\((?:\d|[a-z]'?|size)(?:, (?:\d|[a-z]'?|size))*\)")
UNIT = re.compile(r"\b(m|mm|um|rad|metres|millimetres|radians|free of unit|units? (of|that)|per unit of)\b")

RAISED = {
    "simfield.Block": {"BlockError"},
    "simfield.Block.select": {"KeyError"},
    "simfield.read_block": {"BlockFolderError"},
    "simfield.write_block": {"BlockFolderError"},
    "simfield.Scenario": {"ScenarioError"},
    "simfield.read_scenario": {"ScenarioError", "OSError"},
    "simfield.changed": {"ScenarioError"},
    "simfield.simulate": {"CountError", "DistortionError", "ValueError"},
    "simfield.build_world": {"CountError", "DistortionError"},
    "simfield.read_truth": {"OSError", "ValueError", "KeyError"},
    "simfield.write_truth": {"OSError", "ValueError"},
    "adjust.adjust_block": {"KeyError", "ValueError"},
    "adjust.adjust_replicates": {"ValueError"},
    "adjust.Adjustment.std": {"ValueError"},
    "adjust.Adjustment.covariance": {"KeyError", "ValueError"},
    "adjust.Adjustment.correlation": {"KeyError", "ValueError"},
    "adjust.Adjustment.ap_correlation": {"KeyError", "ValueError"},
    "adjust.ap_models.get": {"KeyError", "TypeError"},
}
"""errors that come from deeper down, and must be named where a caller reads"""

SOURCES = {
    "simfield.simulate": "docs/conventions.md",
    "simfield.block.block.Images": "docs/conventions.md",
    "adjust.adjust_block": "Triggs",
    "adjust.Adjustment": "docs/conventions.md",
    "adjust.adjust_replicates": "adjust.trials.chord",
    "adjust.ApModel": "source",
}
"""names that stand for a formula or a convention, and what their docstring or that of their module refers to"""


@dataclasses.dataclass(frozen=True)
class Name:
    """A public name: where it is found, what it is, its docstring, and how its arrays are annotated."""

    path: str
    of: Any
    doc: str
    annotation: str

    def __str__(self) -> str:
        return self.path


def public_names() -> Iterator[Name]:
    """All public names with their attributes, each once."""
    for module in (simfield, adjust, ap_models):
        for name in module.__all__:
            yield from with_attributes(f"{module.__name__}.{name}", getattr(module, name))
    for name in ("Camera", "Images", "Points", "ImageObservations", "BlockError"):
        yield from with_attributes(f"simfield.block.block.{name}", getattr(block_tables, name))


def with_attributes(path: str, of: Any) -> Iterator[Name]:
    if inspect.isfunction(of):
        yield Name(path, of, of.__doc__ or "", signature_text(of))
    elif inspect.isclass(of):
        yield Name(path, of, own_doc(of), fields_text(of))
        for name, value in vars(of).items():
            function = attribute_function(value)
            if function is not None and not name.startswith("_"):
                yield Name(f"{path}.{name}", function, function.__doc__ or "", signature_text(function))


def own_doc(of: type) -> str:
    """The docstring of a class, with the strings below its fields; not what a dataclass makes of its signature."""
    body = ast.parse(textwrap.dedent(inspect.getsource(of))).body[0]
    assert isinstance(body, ast.ClassDef)
    below = [n.value.value for n in body.body if isinstance(n, ast.Expr) and isinstance(n.value, ast.Constant)]
    return "\n".join(str(text) for text in below) if ast.get_docstring(body) else ""


def attribute_function(value: Any) -> Any:
    if isinstance(value, property):
        return value.fget
    if isinstance(value, cached_property):
        return value.func
    if isinstance(value, classmethod | staticmethod):
        return value.__func__
    return value if inspect.isfunction(value) else None


def signature_text(function: Any) -> str:
    return " ".join(str(value) for value in function.__annotations__.values())


def fields_text(of: type) -> str:
    return " ".join(str(f.type) for f in dataclasses.fields(of)) if dataclasses.is_dataclass(of) else ""


def raised_by(of: Any) -> set[str]:
    """The errors that the body of a function raises by itself; those of `__post_init__` and `__init__` for a class."""
    if inspect.isclass(of):
        return set().union(*(raised_by(vars(of)[name]) for name in ("__post_init__",) if name in vars(of)))
    tree = ast.parse(textwrap.dedent(inspect.getsource(of)))
    raised = [node.exc for node in ast.walk(tree) if isinstance(node, ast.Raise) and node.exc is not None]
    called = [e.func if isinstance(e, ast.Call) else e for e in raised]
    return {e.id for e in called if isinstance(e, ast.Name)} - {"NotImplementedError"}


NAMES = list({name.path: name for name in public_names()}.values())
every_name = pytest.mark.parametrize("name", NAMES, ids=str)
WITH_ARRAYS = [name for name in NAMES if any(array in name.annotation for array in ARRAYS)]
MEASURED = [name for name in NAMES if any(array in name.annotation for array in WITH_UNITS)]


def test_the_names_are_found() -> None:
    paths = {name.path for name in NAMES}
    assert paths >= {
        "simfield.simulate",
        "adjust.Adjustment.covariance",
        "adjust.ap_models.get",
        "simfield.Block.select",
    }
    assert len(WITH_ARRAYS) > 30


@every_name
def test_says_what_it_is(name: Name) -> None:
    assert re.match(r"\S.*[.;)]", name.doc.strip().split("\n\n")[0], re.DOTALL), f"{name} has no docstring"


@pytest.mark.parametrize("name", WITH_ARRAYS, ids=str)
def test_says_the_shape_of_its_arrays(name: Name) -> None:
    assert SHAPE.search(name.doc), f"{name}: no shape in: {name.doc}"


@pytest.mark.parametrize("name", MEASURED, ids=str)
def test_says_the_unit_of_its_arrays(name: Name) -> None:
    assert UNIT.search(SHAPE.sub("", name.doc)), f"{name}: no unit in: {name.doc}"


@every_name
def test_says_what_it_raises(name: Name) -> None:
    raised = raised_by(name.of) | RAISED.get(name.path, set())
    missing = {error for error in raised if not re.search(rf"\b{error}\b", name.doc)}
    assert not missing, f"{name} raises {missing}"


@pytest.mark.parametrize(("path", "source"), SOURCES.items())
def test_names_its_source(path: str, source: str) -> None:
    name = next(n for n in NAMES if n.path == path)
    assert source in name.doc + (inspect.getdoc(inspect.getmodule(name.of)) or "")


def test_every_name_with_declared_errors_is_there() -> None:
    assert {name.path for name in NAMES} >= set(RAISED) | set(SOURCES)
