"""Curves through points: cubics piece by piece, as scipy's interpolators make them, number for number.

Shapes bend a handful of points at a time. For so few scipy takes ten times as long, and a quarter of a second to load.
"""

import numpy as np
from jaxtyping import Float64
from numpy import ndarray


def monotone(
    x: Float64[ndarray, "N"], y: Float64[ndarray, "N D"], at: Float64[ndarray, "M"]
) -> Float64[ndarray, "M D"]:
    """The curve through three points or more that does not overshoot between them (`PchipInterpolator`; Fritsch and
    Butland 1984), at positions within the rising `x`."""
    steps = np.diff(x)[:, None]
    slopes = np.diff(y, axis=0) / steps
    before, after = slopes[:-1], slopes[1:]
    first, second = 2 * steps[1:] + steps[:-1], steps[1:] + 2 * steps[:-1]
    turning = before * after <= 0
    tangents = np.empty_like(y)
    # The weighted harmonic mean of both sides, but level where the curve turns.
    with np.errstate(divide="ignore", invalid="ignore"):
        mean = (first / before + second / after) / (first + second)
        tangents[1:-1] = np.where(turning, 0.0, 1.0 / mean)
    tangents[0] = _end_tangents(steps[0, 0], steps[1, 0], slopes[0], slopes[1])
    tangents[-1] = _end_tangents(steps[-1, 0], steps[-2, 0], slopes[-1], slopes[-2])
    return _hermite(x, y, tangents, at)


def _end_tangents(
    near: float, far: float, slopes: Float64[ndarray, "D"], next_slopes: Float64[ndarray, "D"]
) -> list[float]:
    """Those of a parabola, held back where it would overshoot."""
    found = []
    for slope, following in zip(slopes.tolist(), next_slopes.tolist(), strict=True):
        tangent = ((2 * near + far) * slope - near * following) / (near + far)
        if np.sign(tangent) != np.sign(slope):
            tangent = 0.0
        elif np.sign(slope) != np.sign(following) and abs(tangent) > 3.0 * abs(slope):
            tangent = 3.0 * slope
        found.append(tangent)
    return found


def smooth(x: Float64[ndarray, "N"], y: Float64[ndarray, "N D"], at: Float64[ndarray, "M"]) -> Float64[ndarray, "M D"]:
    """The curve through four points or more whose second derivatives have no jumps, nor the third ones at the second
    and the last but one (`CubicSpline`), at positions within the rising `x`."""
    steps = np.diff(x)
    slopes = np.diff(y, axis=0) / steps[:, None]
    # A tridiagonal system for the tangents.
    lower, diagonal, upper = np.append(steps[1:], 0.0), np.empty(len(x)), np.insert(steps[:-1], 0, 0.0)
    diagonal[1:-1] = 2 * (steps[:-1] + steps[1:])
    right = np.empty_like(y)
    right[1:-1] = 3 * (steps[1:, None] * slopes[:-1] + steps[:-1, None] * slopes[1:])
    start, end = x[2] - x[0], x[-1] - x[-3]
    diagonal[0], upper[0], lower[-1], diagonal[-1] = steps[1], start, end, steps[-2]
    right[0] = ((steps[0] + 2 * start) * steps[1] * slopes[0] + steps[0] * steps[0] * slopes[1]) / start
    right[-1] = (steps[-1] * steps[-1] * slopes[-2] + (2 * end + steps[-1]) * steps[-2] * slopes[-1]) / end
    return _hermite(x, y, _solved(lower.tolist(), diagonal.tolist(), upper.tolist(), right), at)


def _solved(
    lower: list[float], diagonal: list[float], upper: list[float], right: Float64[ndarray, "N D"]
) -> Float64[ndarray, "N D"]:
    """A tridiagonal system, row by row (LAPACK's dgtsv)."""
    last = len(diagonal) - 1
    # What stands right of the upper diagonal, where two rows change places.
    beyond = [0.0] * last
    for row in range(last):
        if abs(diagonal[row]) >= abs(lower[row]):
            share = lower[row] / diagonal[row]
            diagonal[row + 1] -= share * upper[row]
        else:
            share = diagonal[row] / lower[row]
            diagonal[row], upper[row], diagonal[row + 1] = (
                lower[row], diagonal[row + 1], upper[row] - share * diagonal[row + 1],
            )  # fmt: skip
            if row + 1 < last:
                beyond[row] = upper[row + 1]
                upper[row + 1] = -share * beyond[row]
            right[[row, row + 1]] = right[[row + 1, row]]
        right[row + 1] -= share * right[row]
    right[last] /= diagonal[last]
    right[last - 1] = (right[last - 1] - upper[last - 1] * right[last]) / diagonal[last - 1]
    for row in range(last - 2, -1, -1):
        right[row] = (right[row] - upper[row] * right[row + 1] - beyond[row] * right[row + 2]) / diagonal[row]
    return right


def _hermite(
    x: Float64[ndarray, "N"],
    y: Float64[ndarray, "N D"],
    tangents: Float64[ndarray, "N D"],
    at: Float64[ndarray, "M"],
) -> Float64[ndarray, "M D"]:
    steps = np.diff(x)[:, None]
    slopes = np.diff(y, axis=0) / steps
    bend = (tangents[:-1] + tangents[1:] - 2 * slopes) / steps
    piece = np.searchsorted(x, at, "right").clip(1, len(x) - 1) - 1
    t = (at - x[piece])[:, None]
    cubic, square = (bend / steps)[piece], ((slopes - tangents[:-1]) / steps - bend)[piece]
    curve: Float64[ndarray, "M D"] = y[piece] + tangents[piece] * t + square * (t * t) + cubic * (t * t * t)
    return curve
