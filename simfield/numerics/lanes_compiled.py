"""Lanes (simfield.numerics.lanes) as vectors, for numba.

Sums of products may be fused, quotients by one divisor may share its reciprocal; nothing else is reordered, so results
do not depend on how many trials there are. Written with numba's low-level extension interface, in terms of LLVM.

Readable form: `simfield.numerics.lanes`. Agreement: `tests/simfield/numerics/test_lanes.py`.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from typing import Any

import numba
from llvmlite import ir
from numba.core import cgutils, types
from numba.core.typing.templates import ConcreteTemplate, infer_global, signature
from numba.extending import intrinsic, lower_builtin, models, overload, register_model

from simfield.numerics import lanes as plain, machine_code
from simfield.numerics.arena import CACHE_LINE
from simfield.numerics.lanes import WIDTH, WIDTH_SINGLE

machine_code.install()

OPTIONS: dict[str, Any] = {"cache": True, "error_model": "numpy", "_nrt": False}
kernel = numba.njit(**OPTIONS)
"""Compile a function that makes no arrays and keeps none: numba then does not count who holds which. In inner loops
over arrays of a named tuple, counting cost more than the arithmetic."""
inlined = numba.njit(**OPTIONS, inline="always")
"""The same for a function that is written into those that call it."""
FLAGS = ("contract", "nsz", "arcp")
"""what LLVM may do with the arithmetic of lanes"""


class LanesType(types.Type):
    """`width` numbers of one precision."""

    def __init__(self, number: types.Float, llvm: ir.Type, width: int) -> None:
        self.number, self.width = number, width
        self.vector = ir.VectorType(llvm, width)
        super().__init__(name=f"lanes({width} x {number})")


DOUBLE = LanesType(types.float64, ir.DoubleType(), WIDTH)
SINGLE = LanesType(types.float32, ir.FloatType(), WIDTH_SINGLE)
KINDS = (DOUBLE, SINGLE)


@register_model(LanesType)
class _Model(models.PrimitiveModel):
    def __init__(self, manager: Any, lanes: LanesType) -> None:
        super().__init__(manager, lanes, lanes.vector)


def _splat(builder: ir.IRBuilder, lanes: LanesType, value: Any) -> Any:
    undefined, index = ir.Constant(lanes.vector, ir.Undefined), ir.IntType(32)
    one = builder.insert_element(undefined, value, ir.Constant(index, 0))
    return builder.shuffle_vector(one, undefined, ir.Constant(ir.VectorType(index, lanes.width), [0] * lanes.width))


def _all_lanes(builder: ir.IRBuilder, lanes: LanesType, argument_types: Any, arguments: Any) -> list[Any]:
    """Arguments of which some may be one number for all lanes."""
    pairs = zip(arguments, argument_types, strict=True)
    return [v if isinstance(t, LanesType) else _splat(builder, lanes, v) for v, t in pairs]


def _arithmetic(operation: Callable[..., Any], instruction: str) -> None:
    signatures = []
    for lanes in KINDS:
        signatures += [(lanes, lanes), (lanes, lanes.number), (lanes.number, lanes)]

        def lower(_context: Any, builder: Any, sig: Any, arguments: Any, lanes: LanesType = lanes) -> Any:
            return getattr(builder, instruction)(*_all_lanes(builder, lanes, sig.args, arguments), flags=FLAGS)

        for pair in signatures[-3:]:
            lower_builtin(operation, *pair)(lower)

    @infer_global(operation)
    class _Typing(ConcreteTemplate):
        cases = [signature(a if isinstance(a, LanesType) else b, a, b) for a, b in signatures]  # noqa: RUF012


for _operation, _instruction in (
    (operator.add, "fadd"), (operator.sub, "fsub"), (operator.mul, "fmul"), (operator.truediv, "fdiv"),
):  # fmt: skip
    _arithmetic(_operation, _instruction)


@infer_global(operator.neg)
class _Negative(ConcreteTemplate):
    cases = [signature(lanes, lanes) for lanes in KINDS]  # noqa: RUF012


for _lanes in KINDS:
    lower_builtin(operator.neg, _lanes)(lambda _context, builder, _sig, arguments: builder.fneg(arguments[0]))


def _pointer(context: Any, builder: Any, array_type: Any, array: Any, row_type: Any, row: Any) -> Any:
    """Where the lanes array[row] begin; rows are counted from the first, never from the last."""
    indices = zip(cgutils.unpack_tuple(builder, row, len(row_type)), row_type, strict=True)
    whole = [context.cast(builder, value, t, types.intp) for value, t in indices]
    whole.append(ir.Constant(ir.IntType(64), 0))
    made = context.make_array(array_type)(context, builder, array)
    pointer = cgutils.get_item_pointer(context, builder, array_type, made, whole, wraparound=False, boundscheck=False)
    return builder.bitcast(pointer, _kind(array_type).vector.as_pointer())


def _kind(array: Any) -> LanesType:
    return next(lanes for lanes in KINDS if lanes.number == array.dtype)


@intrinsic
def _load(_typing: Any, array: Any, row: Any) -> Any:
    def lower(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
        (array_type, row_type), (array, row) = sig.args, arguments
        pointer = _pointer(context, builder, array_type, array, row_type, row)
        return builder.load(pointer, align=array_type.dtype.bitwidth // 8)

    return _kind(array)(array, row), lower


@intrinsic
def _store(_typing: Any, array: Any, row: Any, _value: Any) -> Any:
    def lower(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
        lanes = _kind(sig.args[0])
        pointer = _pointer(context, builder, sig.args[0], arguments[0], sig.args[1], arguments[1])
        (value,) = _all_lanes(builder, lanes, sig.args[2:], arguments[2:])
        builder.store(value, pointer, align=lanes.number.bitwidth // 8)
        return context.get_dummy_value()

    return types.void(array, row, _value), lower


@overload(plain.load)
def _(array, *row):  # numba compares signatures, annotations included
    return lambda array, *row: _load(array, row)


@overload(plain.store)
def _(array, value, *row):
    return lambda array, value, *row: _store(array, row, value)


def _function(readable: Callable[..., Any], lower: Callable[[Any, Any, LanesType, list[Any]], Any]) -> None:
    """Teach the compiler `readable` for double precision lanes; lower(context, builder, lanes, vectors) writes it."""

    @infer_global(readable)
    class _Typing(ConcreteTemplate):
        cases = [  # noqa: RUF012
            signature(DOUBLE, *(DOUBLE if number >> place & 1 else types.float64 for place in range(count)))
            for count in (readable.__code__.co_argcount,)
            for number in range(1, 2**count)
        ]

    def lowered(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
        return lower(context, builder, DOUBLE, _all_lanes(builder, DOUBLE, sig.args, arguments))

    for case in _Typing.cases:
        lower_builtin(readable, *case.args)(lowered)


def _comparison(sign: str) -> Callable[..., Any]:
    def lower(_context: Any, builder: Any, lanes: LanesType, vectors: list[Any]) -> Any:
        zero, one = (ir.Constant(lanes.vector, [value] * lanes.width) for value in (0.0, 1.0))
        compare = builder.fcmp_unordered if sign == "!=" else builder.fcmp_ordered
        return builder.select(compare(sign, *vectors), one, zero)

    return lower


def _by_instruction(name: str) -> Callable[..., Any]:
    def lower(_context: Any, builder: Any, lanes: LanesType, vectors: list[Any]) -> Any:
        kind = ir.FunctionType(lanes.vector, [lanes.vector])
        return builder.call(cgutils.get_or_insert_function(builder.module, kind, f"llvm.{name}.v8f64"), vectors)

    return lower


def _lane_by_lane(function: Callable[..., Any]) -> Callable[..., Any]:
    """For what no vector instruction does."""

    def lower(context: Any, builder: Any, lanes: LanesType, vectors: list[Any]) -> Any:
        scalar = context.get_function(function, signature(lanes.number, *[lanes.number] * len(vectors)))
        result = ir.Constant(lanes.vector, ir.Undefined)
        for place in range(lanes.width):
            at = ir.Constant(ir.IntType(32), place)
            value = scalar(builder, [builder.extract_element(vector, at) for vector in vectors])
            result = builder.insert_element(result, value, at)
        return result

    return lower


def _least(_context: Any, builder: Any, _lanes: LanesType, vectors: list[Any]) -> Any:
    return builder.select(builder.fcmp_ordered("<", *vectors), *vectors)


def _choose(_context: Any, builder: Any, lanes: LanesType, vectors: list[Any]) -> Any:
    condition, yes, no = vectors
    return builder.select(
        builder.fcmp_unordered("!=", condition, ir.Constant(lanes.vector, [0.0] * lanes.width)), yes, no
    )


FUNCTIONS: dict[Callable[..., Any], Callable[..., Any]] = {
    plain.root: _by_instruction("sqrt"),
    plain.magnitude: _by_instruction("fabs"),
    plain.whole: _by_instruction("rint"),
    plain.least: _least,
    plain.choose: _choose,
    plain.equal: _comparison("=="),
    plain.not_equal: _comparison("!="),
    plain.greater: _comparison(">"),
    plain.less: _comparison("<"),
    plain.sine: _lane_by_lane(math.sin),
    plain.cosine: _lane_by_lane(math.cos),
    plain.exponential: _lane_by_lane(math.exp),
    plain.direction: _lane_by_lane(math.atan2),
    plain.power: _lane_by_lane(math.pow),
}
for _readable, _lower in FUNCTIONS.items():
    _function(_readable, _lower)


@intrinsic
def _align_stack(_typing: Any) -> Any:
    def lower(context: Any, builder: Any, _sig: Any, _arguments: Any) -> Any:
        attributes = builder.function.attributes
        attributes.alignstack = CACHE_LINE
        attributes.add("nounwind")  # llvmlite leaves out the alignment where it stands alone
        return context.get_dummy_value()

    return types.void(), lower


@intrinsic
def _same(_typing: Any, number: Any) -> Any:
    return DOUBLE(number), lambda _context, builder, _sig, arguments: _splat(builder, DOUBLE, arguments[0])


def _places(first: int, count: int) -> ir.Constant:
    return ir.Constant(ir.VectorType(ir.IntType(32), count), list(range(first, first + count)))


@intrinsic
def _narrow(_typing: Any, first: Any, second: Any) -> Any:
    def lower(_context: Any, builder: Any, _sig: Any, arguments: Any) -> Any:
        half = ir.VectorType(ir.FloatType(), WIDTH)
        return builder.shuffle_vector(*(builder.fptrunc(v, half) for v in arguments), _places(0, WIDTH_SINGLE))

    return SINGLE(first, second), lower


@intrinsic
def _widen(_typing: Any, value: Any) -> Any:
    def lower(context: Any, builder: Any, sig: Any, arguments: Any) -> Any:
        (vector,) = arguments
        halves = (builder.shuffle_vector(vector, vector, _places(first, WIDTH)) for first in (0, WIDTH))
        return context.make_tuple(builder, sig.return_type, [builder.fpext(h, DOUBLE.vector) for h in halves])

    return types.UniTuple(DOUBLE, 2)(value), lower


@intrinsic
def _any_above(_typing: Any, value: Any, limit: Any) -> Any:
    def lower(_context: Any, builder: Any, _sig: Any, arguments: Any) -> Any:
        above = builder.fcmp_unordered(">", arguments[0], _splat(builder, DOUBLE, arguments[1]))
        bits = ir.IntType(WIDTH)
        return builder.icmp_unsigned("!=", builder.bitcast(above, bits), ir.Constant(bits, 0))

    return types.boolean(value, limit), lower


overload(plain.align_stack, inline="always")(lambda: lambda: _align_stack())
overload(plain.any_above)(lambda a, b: lambda a, b: _any_above(a, b))
overload(plain.same)(lambda number: lambda number: _same(number))
overload(plain.narrow)(lambda first, second: lambda first, second: _narrow(first, second))
overload(plain.widen)(lambda value: lambda value: _widen(value))
