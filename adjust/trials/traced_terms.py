"""The terms of an AP model as one compiled function, traced from its declaration.

A model's `terms` is run once on symbols; every operation is recorded once, the record is written out as scalar code,
and that is compiled. A model that does more than arithmetic, square roots and the like cannot be traced; it raises
UntraceableError, and callers fall back to its numpy basis.
"""

from __future__ import annotations

import functools
import hashlib
import importlib.util
import inspect
import itertools
import os
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from adjust.ap_models import ApModel
from adjust.trials import gradient_compiled as kernels
from simfield.numerics import lanes_compiled

UFUNCS = {
    np.add: "{0} + {1}",
    np.subtract: "{0} - {1}",
    np.multiply: "{0} * {1}",
    np.true_divide: "{0} / {1}",
    np.negative: "-{0}",
    np.sqrt: "root({0})",
    np.sin: "sine({0})",
    np.cos: "cosine({0})",
    np.arctan2: "direction({0}, {1})",
    np.exp: "exponential({0})",
    np.abs: "magnitude({0})",
    np.square: "{0} * {0}",
    np.hypot: "root({0} * {0} + {1} * {1})",
    np.equal: "equal({0}, {1})",
    np.not_equal: "not_equal({0}, {1})",
    np.greater: "greater({0}, {1})",
    np.less: "less({0}, {1})",
}
POWER_MOST = 16
"""whole powers up to this are written as products"""


class UntraceableError(TypeError):
    """The model's terms do something that has no scalar form here."""


@dataclass(eq=False)
class _Record:
    """Single-assignment lines, each written once."""

    lines: list[str] = field(default_factory=list)
    known: dict[str, str] = field(default_factory=dict)

    def put(self, expression: str) -> _Symbol:
        if expression not in self.known:
            name = f"t{len(self.lines)}"
            self.lines.append(f"{name} = {expression}")
            self.known[expression] = name
        return _Symbol(self, self.known[expression])


class _Symbol(np.lib.mixins.NDArrayOperatorsMixin):
    """A traced value: numpy's operators and functions on it are recorded instead of computed."""

    __hash__ = None  # type: ignore[assignment]

    def __init__(self, record: _Record, name: str) -> None:
        self.record, self.name = record, name

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **options: Any) -> Any:
        if method != "__call__" or options:
            raise UntraceableError(f"numpy.{ufunc.__name__}.{method}")
        if ufunc is np.power:
            return self._power(*inputs)
        if ufunc is np.positive:
            return inputs[0]
        if ufunc not in UFUNCS:
            raise UntraceableError(f"numpy.{ufunc.__name__}")
        return self.record.put(UFUNCS[ufunc].format(*(self._operand(i) for i in inputs)))

    def part(self, value: Any) -> str:
        """The operand that stands for one part of a term, or nothing for 0."""
        if not isinstance(value, _Symbol) and np.ndim(value) == 0 and value == 0:
            return ""
        return self._operand(value)

    def _operand(self, value: Any) -> str:
        if isinstance(value, _Symbol):
            return value.name
        if np.ndim(value) == 0 and np.isrealobj(value):
            return repr(float(value))
        raise UntraceableError(f"an operand of type {type(value).__name__}")

    def _power(self, base: Any, exponent: Any) -> Any:
        if isinstance(exponent, _Symbol) or not isinstance(base, _Symbol):
            raise UntraceableError("a variable exponent")
        if exponent == 0.5:
            return np.sqrt(base)
        if float(exponent).is_integer() and 1 <= exponent <= POWER_MOST:
            return self._whole_power(base, int(exponent))
        return self.record.put(f"power({base.name}, {float(exponent)!r})")

    def _whole_power(self, base: Any, exponent: int) -> Any:
        if exponent == 1:
            return base
        half = self._whole_power(base, exponent // 2)
        square = half * half
        return square * base if exponent % 2 else square

    def __array_function__(self, function: Any, types: Any, args: Any, kwargs: Any) -> Any:
        if function is np.zeros_like:
            return 0.0
        if function is np.ones_like:
            return 1.0
        if function is np.where and len(args) == 3:
            condition, yes, no = (self._operand(a) for a in args)
            return self.record.put(f"choose({condition}, {yes}, {no})")
        raise UntraceableError(f"numpy.{function.__name__}")

    def __bool__(self) -> bool:
        raise UntraceableError("a branch on a coordinate")


@dataclass(frozen=True)
class Trace:
    """The terms of a model as scalar code in x and y: lines to be run in order, then (dx, dy) of each parameter.

    A part is the name of a value, a number, or empty where the term is 0.
    """

    lines: tuple[str, ...]
    parts: tuple[tuple[str, str], ...]

    @classmethod
    def of(cls, model: ApModel) -> Trace:
        """Raises UntraceableError."""
        record = _Record()
        x, y = _Symbol(record, "x"), _Symbol(record, "y")
        try:
            terms = list(model.terms(x, y))  # type: ignore[arg-type]
            parts = tuple((x.part(dx), x.part(dy)) for dx, dy in terms)
        except UntraceableError:
            raise
        except Exception as error:
            raise UntraceableError(f"{type(error).__name__}: {error}") from error
        if len(parts) != len(model.parameters):
            raise UntraceableError(f"{len(parts)} terms for {len(model.parameters)} parameters")
        return cls(tuple(record.lines), parts)

    @property
    def distortion(self) -> str:
        """The expression (dx, dy) of the distortion."""
        rows = enumerate(self.parts, start=kernels.PARAMETERS)
        named = [(f"load(context, image, {row})", part) for row, part in rows]
        sums = (" + ".join(f"{a} * {part[axis]}" for a, part in named if part[axis]) or "0.0" for axis in range(2))
        return ", ".join(sums)

    @property
    def pulls(self) -> str:
        """The tuple of the sums with B^T (fx, fy) added."""
        added = []
        for number, part in enumerate(self.parts):
            forces = [f"{name} * {force}" for name, force in zip(part, ("fx", "fy"), strict=True) if name]
            added.append(f"pulls[{number}] + ({' + '.join(forces)})" if forces else f"pulls[{number}]")
        return _tuple(added)


def _tuple(items: list[str]) -> str:
    return f"({', '.join(items)}{',' if items else ''})"


def compile_gradient(model: ApModel) -> Callable[..., Any]:
    """`adjust.trials.gradient_compiled.gradient_block` with the terms of this model, compiled. Raises
    UntraceableError.
    """
    gradient: Callable[..., Any] = _load(_source(Trace.of(model))).gradient_block
    return gradient


_source_of = functools.cache(inspect.getsource)


def _source(trace: Trace) -> str:
    inline = '@numba.njit(error_model="numpy", inline="always")'
    keep = [f"store(sums, pulls[{row}], image, {kernels.PULL + row})" for row in range(len(trace.parts))]
    bodies = {
        "distort(x, y, context, image)": [*trace.lines, f"return {trace.distortion}"],
        "no_pull(zero)": [f"return {_tuple(['zero'] * len(trace.parts))}"],
        "pull(x, y, fx, fy, pulls)": [*trace.lines, f"return {trace.pulls}"],
        "keep_pull(pulls, sums, image)": keep or ["pass"],
    }
    functions = [[inline, f"def {head}:", *(f"    {line}" for line in body)] for head, body in bodies.items()]
    return "\n".join(
        [
            f"# {_digest(_source_of(lanes_compiled))}: code kept on disk is compiled anew when lanes change",
            "from typing import Any",
            "import numba",
            "import numpy as np",
            "import simfield.numerics.lanes_compiled",
            "from simfield.numerics.lanes import *",
            *itertools.chain.from_iterable(functions),
            '@numba.njit(error_model="numpy")',
            _source_of(kernels.gradient_tile),
            '@numba.njit(cache=CACHE, error_model="numpy")',
            _source_of(kernels.gradient_block),
        ]
    )


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def _cache_folder() -> Path | None:
    """Where generated code is kept, so that a second process need not compile; None where nothing can be written."""
    given = os.environ.get("SIMFIELD_CACHE_DIR")
    folder = Path(given) if given else Path.home() / ".cache" / "simfield"
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return None
    return folder if os.access(folder, os.W_OK) else None


def _load(source: str) -> ModuleType:
    name = f"_simfield_terms_{_digest(source)}"
    if name in sys.modules:
        return sys.modules[name]
    folder = _cache_folder()
    if folder is None:
        module = ModuleType(name)
        exec(compile(source.replace("CACHE", "False"), name, "exec"), module.__dict__)
        sys.modules[name] = module
        return module
    path = folder / f"{name}.py"
    text = source.replace("CACHE", "True")
    if not path.exists() or path.read_text(encoding="utf-8") != text:
        temporary = path.with_suffix(f".{os.getpid()}.tmp")
        temporary.write_text(text, encoding="utf-8")
        temporary.replace(path)
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module
