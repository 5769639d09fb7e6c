"""The type of short vectors inside kernels, and the operators on them, as instructions for the compiler."""

import operator
from collections.abc import Iterable
from typing import Any

from llvmlite import ir
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import lower_builtin, models, register_model
from numba.types import Float, Integer, Number, Type, boolean, float32, float64, int32

# Products may be fused into the sums that they enter.
_CONTRACT = ("contract",)


class Vector(Type):
    """The type of a vector of `lanes` numbers of one numba type."""

    def __init__(self, dtype: Type, lanes: int) -> None:
        self.dtype, self.lanes = dtype, lanes
        super().__init__(name=f"Vector({dtype}, {lanes})")


SCALARS = {float64: ir.DoubleType(), float32: ir.FloatType(), int32: ir.IntType(32), boolean: ir.IntType(1)}


@register_model(Vector)
class _VectorModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Vector) -> None:
        super().__init__(manager, kind, ir.VectorType(SCALARS[kind.dtype], kind.lanes))


def shuffled(builder: Any, first: Any, second: Any, order: Iterable[int]) -> Any:
    """The LLVM vector of the numbers at the places `order` of two vectors set one behind the other."""
    places = [ir.Constant(ir.IntType(32), k) for k in order]
    return builder.shuffle_vector(first, second, ir.Constant(ir.VectorType(ir.IntType(32), len(places)), places))


def splat(builder: Any, scalar: Any, lanes: int) -> Any:
    """The LLVM vector of one number over and over."""
    nothing = ir.Constant(ir.VectorType(scalar.type, lanes), ir.Undefined)
    first = builder.insert_element(nothing, scalar, ir.Constant(ir.IntType(32), 0))
    return shuffled(builder, first, first, [0] * lanes)


def as_vector(context: Any, builder: Any, value: Any, kind: Type, wanted: Vector) -> Any:
    """The LLVM vector for an operand that is a vector already or a number."""
    if isinstance(kind, Vector):
        return value
    return splat(builder, context.cast(builder, value, kind, wanted.dtype), wanted.lanes)


def common(a: Type, b: Type) -> Vector | None:
    """The vector type in which an operation on a and b takes place; None where neither is a vector, or they differ."""
    if isinstance(a, Vector) and isinstance(b, Vector):
        return a if a == b else None
    if isinstance(a, Vector) and isinstance(b, Number) and a.dtype != boolean:
        return a
    if isinstance(b, Vector) and isinstance(a, Number) and b.dtype != boolean:
        return b
    return None


def _arithmetic(operation: Any, emit: Any) -> None:
    @infer_global(operation)
    class _Typed(AbstractTemplate):
        def generic(self, args: Any, kws: Any) -> Any:
            kind = common(*args) if len(args) == 2 else None
            return signature(kind, *args) if kind and isinstance(kind.dtype, Float) else None

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        a, b = (as_vector(context, builder, v, k, sig.return_type) for v, k in zip(args, sig.args, strict=True))
        return emit(builder, a, b)

    for pair in ((Vector, Vector), (Vector, Number), (Number, Vector)):
        lower_builtin(operation, *pair)(lower)


def _comparison(operation: Any, symbol: str) -> None:
    @infer_global(operation)
    class _Typed(AbstractTemplate):
        def generic(self, args: Any, kws: Any) -> Any:
            kind = common(*args) if len(args) == 2 else None
            return signature(Vector(boolean, kind.lanes), *args) if kind else None

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        kind: Any = common(*sig.args)
        a, b = (as_vector(context, builder, v, k, kind) for v, k in zip(args, sig.args, strict=True))
        if isinstance(kind.dtype, Integer):
            return builder.icmp_signed(symbol, a, b)
        return builder.fcmp_ordered(symbol, a, b)

    for pair in ((Vector, Vector), (Vector, Number), (Number, Vector)):
        lower_builtin(operation, *pair)(lower)


def _logic(operation: Any, emit: Any) -> None:
    @infer_global(operation)
    class _Typed(AbstractTemplate):
        def generic(self, args: Any, kws: Any) -> Any:
            masks = len(args) == 2 and args[0] == args[1] and isinstance(args[0], Vector) and args[0].dtype == boolean
            return signature(args[0], *args) if masks else None

    lower_builtin(operation, Vector, Vector)(lambda context, builder, sig, args: emit(builder, *args))


_arithmetic(operator.add, lambda builder, a, b: builder.fadd(a, b, flags=_CONTRACT))
_arithmetic(operator.sub, lambda builder, a, b: builder.fsub(a, b, flags=_CONTRACT))
_arithmetic(operator.mul, lambda builder, a, b: builder.fmul(a, b, flags=_CONTRACT))
_arithmetic(operator.truediv, lambda builder, a, b: builder.fdiv(a, b))
_comparison(operator.ge, ">=")
_comparison(operator.gt, ">")
_comparison(operator.eq, "==")
_logic(operator.and_, lambda builder, a, b: builder.and_(a, b))
