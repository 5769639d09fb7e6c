"""Short vectors of numbers inside kernels: the parallelism that the compiler's own search misses, said outright.

A vector holds a fixed count of numbers and lives in registers only. Operators work lane by lane, and a plain number
beside a vector stands for a vector of it. Compiled to whatever vector instructions the machine has.
"""

from collections.abc import Callable, Iterable
from typing import Any

from llvmlite import ir
from numba.core import cgutils
from numba.extending import intrinsic
from numba.types import Array, Integer, Number, Type, boolean, float32, float64, int64, void

from rasteriser.vector_type import SCALARS, Vector, as_vector, common, shuffled, splat

LANES = 8
"""Numbers in a vector of doubles, of pixels' faces, and in what is made of them."""
WIDE = 16
"""Numbers in a vector of `load_wide`."""


def _address(builder: Any, context: Any, array_type: Any, array: Any, start: Any, vector: Any) -> Any:
    data = cgutils.create_struct_proxy(array_type)(context, builder, array).data
    return builder.bitcast(builder.gep(data, [start]), vector.as_pointer())


def _is_row(kind: Type) -> bool:
    return isinstance(kind, Array) and kind.ndim == 1 and kind.dtype in SCALARS


def _loader(lanes: int, times: int = 1) -> Any:
    def load(typingctx, row, start):
        if not (_is_row(row) and isinstance(start, Integer)):
            return None
        kind, result = Vector(row.dtype, lanes), Vector(row.dtype, lanes * times)

        def codegen(context, builder, sig, args):
            address = _address(builder, context, sig.args[0], args[0], args[1], context.get_value_type(kind))
            numbers = builder.load(address, align=row.dtype.bitwidth // 8)
            return numbers if times == 1 else shuffled(builder, numbers, numbers, list(range(lanes)) * times)

        return result(row, start), codegen

    return load


load = intrinsic(_loader(LANES))
"""load(row, start): the LANES numbers from row[start] on, of a contiguous row; they must all exist."""
load_wide = intrinsic(_loader(WIDE))
"""load_wide(row, start): the same for WIDE numbers."""
load_twice = intrinsic(_loader(LANES // 2, 2))
"""load_twice(row, start): half as many numbers as `load` takes, and the same once more."""


@intrinsic
def store(typingctx, row, start, vector):
    """store(row, start, vector): writes all lanes, from row[start] on, where there must be room for them."""
    if not (_is_row(row) and isinstance(vector, Vector) and vector.dtype == row.dtype):
        return None

    def codegen(context, builder, sig, args):
        address = _address(builder, context, sig.args[0], args[0], args[1], args[2].type)
        builder.store(args[2], address, align=row.dtype.bitwidth // 8)
        return context.get_dummy_value()

    return void(row, start, vector), codegen


@intrinsic
def select(typingctx, mask, chosen, other):
    """select(mask, chosen, other): `chosen` where the mask is set, `other` elsewhere; one of the two is a vector."""
    result = common(chosen, other) if isinstance(mask, Vector) and mask.dtype == boolean else None
    if result is None or result.lanes != mask.lanes:
        return None

    def codegen(context, builder, sig, args):
        one, two = (as_vector(context, builder, args[k], sig.args[k], result) for k in (1, 2))
        return builder.select(args[0], one, two)

    return result(mask, chosen, other), codegen


@intrinsic
def ramp(typingctx, first):
    """ramp(first): first, first + 1, … in doubles."""
    result = Vector(float64, LANES)

    def codegen(context, builder, sig, args):
        start = as_vector(context, builder, args[0], sig.args[0], result)
        return builder.fadd(start, ir.Constant(start.type, [float(lane) for lane in range(LANES)]))

    return (result(first), codegen) if isinstance(first, Number) else None


@intrinsic
def first_lanes(typingctx, count):
    """first_lanes(count): a mask of WIDE lanes, of which the first `count` are set, or all of them."""
    result = Vector(boolean, WIDE)

    def codegen(context, builder, sig, args):
        bound = splat(builder, context.cast(builder, args[0], sig.args[0], int64), WIDE)
        return builder.icmp_signed("<", ir.Constant(bound.type, list(range(WIDE))), bound)

    return (result(count), codegen) if isinstance(count, Integer) else None


def _zeros(dtype: Any, lanes: int) -> Any:
    def zeros(typingctx):
        result = Vector(dtype, lanes)
        return result(), lambda context, builder, sig, args: ir.Constant(context.get_value_type(result), [0.0] * lanes)

    return intrinsic(zeros)


zeros = _zeros(float64, LANES)
"""zeros(): LANES doubles."""
zeros_wide = _zeros(float32, WIDE)
"""zeros_wide(): WIDE singles."""


def _conversion(dtype: Any, instruction: str) -> Any:
    def convert(typingctx, vector):
        result = Vector(dtype, vector.lanes)

        def codegen(context, builder, sig, args):
            return getattr(builder, instruction)(args[0], context.get_value_type(result))

        return result(vector), codegen

    return intrinsic(convert)


as_doubles = _conversion(float64, "fpext")
"""as_doubles(vector): of singles."""
as_singles = _conversion(float32, "fptrunc")
"""as_singles(vector): of doubles, rounded."""


@intrinsic
def beside(typingctx, first, second):
    """beside(first, second): a number in the lower half of the lanes, another one in the upper half."""
    result = Vector(float64, LANES)

    def codegen(context, builder, sig, args):
        one, two = (as_vector(context, builder, args[k], sig.args[k], result) for k in (0, 1))
        return shuffled(builder, one, two, [LANES * (2 * k // LANES) for k in range(LANES)])

    return (result(first, second), codegen) if isinstance(first, Number) and isinstance(second, Number) else None


def _half(upper: bool) -> tuple[Any, Any]:
    """Intrinsics that ask one half of the lanes."""

    def all_set(typingctx, mask):
        def codegen(context, builder, sig, args):
            bits, lanes = builder.bitcast(args[0], ir.IntType(mask.lanes)), mask.lanes // 2
            ones = ir.Constant(bits.type, (2**lanes - 1) << (lanes if upper else 0))
            return builder.icmp_unsigned("==", builder.and_(bits, ones), ones)

        return boolean(mask), codegen

    def last(typingctx, vector):
        def codegen(context, builder, sig, args):
            place = vector.lanes - 1 if upper else vector.lanes // 2 - 1
            return builder.extract_element(args[0], ir.Constant(ir.IntType(32), place))

        return vector.dtype(vector), codegen

    return intrinsic(all_set), intrinsic(last)


all_set_below, last_below = _half(upper=False)
"""all_set_below(mask), last_below(vector): whether a mask's lower half is all set; the last number of that half."""
all_set_above, last_above = _half(upper=True)
"""all_set_above(mask), last_above(vector): the same of the upper half."""


@intrinsic
def total(typingctx, vector):
    """total(vector): the sum of all lanes, halves first."""

    def codegen(context, builder, sig, args):
        value, lanes = args[0], vector.lanes
        while lanes > 1:
            lanes //= 2
            low, high = (shuffled(builder, value, value, range(k * lanes, (k + 1) * lanes)) for k in range(2))
            value = builder.fadd(low, high)
        return builder.extract_element(value, ir.Constant(ir.IntType(32), 0))

    return vector.dtype(vector), codegen


def _shuffle(order: Callable[[int], Iterable[int]]) -> Any:
    """An intrinsic that picks lanes out of two vectors set one behind the other."""

    def shuffle(typingctx, first, second):
        def codegen(context, builder, sig, args):
            return shuffled(builder, *args, order(first.lanes))

        return first(first, second), codegen

    return intrinsic(shuffle)


evens = _shuffle(lambda lanes: range(0, 2 * lanes, 2))
"""evens(first, second): every second number of the two in a row, from the first one on."""
odds = _shuffle(lambda lanes: range(1, 2 * lanes, 2))
"""odds(first, second): every second number of the two in a row, from the second one on."""
zipped_low = _shuffle(lambda lanes: [k // 2 + k % 2 * lanes for k in range(lanes)])
"""zipped_low(first, second): first[0], second[0], first[1], … as far as one vector holds."""
zipped_high = _shuffle(lambda lanes: [lanes // 2 + k // 2 + k % 2 * lanes for k in range(lanes)])
"""zipped_high(first, second): what follows `zipped_low`."""
