"""The Gaussian-pyramid likelihood of Eqs. 1, 2 and 4, for a residual r = I - x held in cache.

Reduction is linear, so the pyramid of the residual is all that is needed. With noise ε/2^l at level l and ε = 1,

    log p = -1/2 Σ_l 4^l |r_l|²   (constants left out),   r_0 = r,  r_{l+1} = r_l * k_G at every second pixel.

k_G is the binomial kernel [1 4 6 4 1]/16 in rows and columns; the border is reflected (index -1 is index 1). A level
of n pixels reduces to ceil(n / 2); the last level has one pixel in its smaller dimension.
"""

import numpy as np
from numba import njit

CENTRE, NEXT, OUTER = np.float32(6 / 16), np.float32(4 / 16), np.float32(1 / 16)


@njit(cache=True, nogil=True)
def level_count(width, height):
    """Levels until the smaller dimension is one pixel."""
    levels, smaller = 1, min(width, height)
    while smaller > 1:
        smaller = (smaller + 1) // 2
        levels += 1
    return levels


@njit(cache=True, nogil=True)
def reflected(index, size):
    """Index with the border reflected, the border pixel itself not repeated."""
    if size == 1:
        return 0
    period = 2 * (size - 1)
    index = index % period
    return min(index, period - index)


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def reduce_level(fine, rows, columns, coarse, half):
    """coarse = every second pixel of fine * k_G; both flat, row by row. half is scratch of the fine level's size."""
    coarse_rows, coarse_columns = (rows + 1) // 2, (columns + 1) // 2
    for j in range(coarse_rows):
        centre = fine[2 * j * columns : (2 * j + 1) * columns]
        above = fine[reflected(2 * j - 1, rows) * columns :]
        below = fine[reflected(2 * j + 1, rows) * columns :]
        far_above = fine[reflected(2 * j - 2, rows) * columns :]
        far_below = fine[reflected(2 * j + 2, rows) * columns :]
        out = half[j * columns : (j + 1) * columns]
        for i in range(columns):
            out[i] = CENTRE * centre[i] + NEXT * (above[i] + below[i]) + OUTER * (far_above[i] + far_below[i])
    for j in range(coarse_rows):
        row = half[j * columns : (j + 1) * columns]
        out = coarse[j * coarse_columns : (j + 1) * coarse_columns]
        for i in range(coarse_columns):
            if i > 0 and 2 * i + 2 < columns:
                out[i] = (
                    CENTRE * row[2 * i]
                    + NEXT * (row[2 * i - 1] + row[2 * i + 1])
                    + OUTER * (row[2 * i - 2] + row[2 * i + 2])
                )
            else:
                near = row[reflected(2 * i - 1, columns)] + row[reflected(2 * i + 1, columns)]
                far = row[reflected(2 * i - 2, columns)] + row[reflected(2 * i + 2, columns)]
                out[i] = CENTRE * row[2 * i] + NEXT * near + OUTER * far


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def expand_adjoint(coarse, rows, columns, fine, half):
    """fine += adjoint of `reduce_level` applied to coarse; rows and columns are those of the fine level."""
    coarse_rows, coarse_columns = (rows + 1) // 2, (columns + 1) // 2
    for j in range(coarse_rows):
        row = coarse[j * coarse_columns : (j + 1) * coarse_columns]
        out = half[j * columns : (j + 1) * columns]
        # As if nothing were reflected: an even pixel gathers from three coarse ones, an odd one from two.
        last = coarse_columns - 1
        for i in range(1, last):
            out[2 * i] = CENTRE * row[i] + OUTER * (row[i - 1] + row[i + 1])
        for i in range(last):
            out[2 * i + 1] = NEXT * (row[i] + row[i + 1])
        out[0] = CENTRE * row[0]
        if last > 0:
            out[0] += OUTER * row[1]
            out[2 * last] = CENTRE * row[last] + OUTER * row[last - 1]
        if 2 * last + 1 < columns:
            out[2 * last + 1] = NEXT * row[last]
        # Only the first and the last coarse pixel reach over the border.
        out[reflected(-1, columns)] += NEXT * row[0]
        out[reflected(-2, columns)] += OUTER * row[0]
        if 2 * last + 1 >= columns:
            out[reflected(2 * last + 1, columns)] += NEXT * row[last]
        out[reflected(2 * last + 2, columns)] += OUTER * row[last]
    for j in range(coarse_rows):
        row = half[j * columns : (j + 1) * columns]
        for tap in range(-2, 3):
            weight = CENTRE if tap == 0 else (NEXT if abs(tap) == 1 else OUTER)
            target = reflected(2 * j + tap, rows) * columns
            out = fine[target : target + columns]
            for i in range(columns):
                out[i] += weight * row[i]


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def sum_of_squares(values):
    total = np.float32(0.0)
    for i in range(len(values)):
        total += values[i] * values[i]
    return np.float64(total)


@njit(cache=True, nogil=True, error_model="numpy")
def pyramid_log_likelihood(rows, columns, levels, half):
    """log p of one channel. levels[0 : rows·columns] holds its residual and is followed by room for the pyramid."""
    total, weight, start = 0.0, 1.0, 0
    for _ in range(level_count(columns, rows) - 1):
        size = rows * columns
        total += weight * sum_of_squares(levels[start : start + size])
        coarse = levels[start + size : start + size + ((rows + 1) // 2) * ((columns + 1) // 2)]
        reduce_level(levels[start : start + size], rows, columns, coarse, half)
        rows, columns, start, weight = (rows + 1) // 2, (columns + 1) // 2, start + size, weight * 4.0
    return -0.5 * (total + weight * sum_of_squares(levels[start : start + rows * columns]))


@njit(cache=True, nogil=True, error_model="numpy")
def pyramid_gradient(rows, columns, levels, half, scale):
    """Turns levels, as `pyramid_log_likelihood` left them, into scale · d log p / d residual, in place at the front."""
    count = level_count(columns, rows)
    all_rows, all_columns = np.empty(count, np.int64), np.empty(count, np.int64)
    starts = np.zeros(count, np.int64)
    for level in range(count):
        all_rows[level], all_columns[level] = rows, columns
        if level + 1 < count:
            starts[level + 1] = starts[level] + rows * columns
        rows, columns = (rows + 1) // 2, (columns + 1) // 2
    for level in range(count - 1, -1, -1):
        start, size = starts[level], all_rows[level] * all_columns[level]
        here = levels[start : start + size]
        factor = np.float32(-scale * 4.0**level)
        for i in range(size):
            here[i] *= factor
        if level + 1 < count:
            coarse = levels[start + size : start + size + all_rows[level + 1] * all_columns[level + 1]]
            expand_adjoint(coarse, all_rows[level], all_columns[level], here, half)
