"""The Gaussian-pyramid likelihood of Eqs. 1, 2 and 4, for a residual r = I - x held in cache.

With noise ε/2^l at level l and ε = 1,

    log p = -1/2 Σ_l 4^l |r_l|²   (constants left out),   r_0 = r,  r_{l+1} = r_l * k_G at every second pixel.

k_G is the binomial kernel [1 4 6 4 1]/16 in rows and columns; the border is reflected (index -1 is index 1). A level
of n pixels reduces to ceil(n / 2); the last level has one pixel in its smaller dimension.

Reduction is linear, so r_l = K_l I - K_l x. The pyramid K_l x of the observed picture is made once for all hypotheses;
that of I is made only in the box outside which I and K_l I vanish. Boxes are (left, top, right, bottom), the last two
exclusive. Levels lie in flat arrays row by row (`level_table`), with zeros before and after each row.
"""

import numpy as np
from numba import njit

from rasteriser.coverage import LANES

CENTRE, NEXT, OUTER = np.float32(6 / 16), np.float32(4 / 16), np.float32(1 / 16)
ROWS, COLUMNS, STRIDE, START = 0, 1, 2, 3


@njit(cache=True, nogil=True)
def level_table(width, height):
    """[L, 4]: rows, columns, stride, and where the level starts in a flat array whose length is the last START."""
    count, smaller = 1, min(width, height)
    while smaller > 1:
        smaller = (smaller + 1) // 2
        count += 1
    table = np.zeros((count + 1, 4), np.int64)
    rows, columns, start = height, width, LANES
    for level in range(count):
        table[level, ROWS], table[level, COLUMNS] = rows, columns
        table[level, STRIDE], table[level, START] = columns + LANES, start
        start += rows * (columns + LANES)
        rows, columns = (rows + 1) // 2, (columns + 1) // 2
    table[count, START] = start
    return table


@njit(cache=True, nogil=True, _nrt=False)
def reflected(index, size):
    """Index with the border reflected, the border pixel itself not repeated."""
    if 0 <= index < size:
        return index
    if size == 1:
        return 0
    period = 2 * (size - 1)
    index = index % period
    return min(index, period - index)


@njit(cache=True, nogil=True, _nrt=False)
def reached(first, last, size):
    """Pixels of the next level, of `size` pixels, that depend on the pixels first..last - 1 of this one."""
    return max(0, (first - 1) // 2), min(size, (last + 1) // 2 + 1)


@njit(cache=True, nogil=True, _nrt=False)
def needed(first, last, size):
    """Pixels of this level, of `size` pixels, on which the pixels first..last - 1 of the next one depend."""
    return max(0, 2 * first - 2), min(size, 2 * last + 1)


@njit(cache=True, nogil=True, _nrt=False)
def box_above(box, rows, columns):
    """The box of the next level, of rows × columns pixels, outside which it vanishes if this one does outside `box`."""
    left, right = reached(box[0], box[2], columns)
    top, bottom = reached(box[1], box[3], rows)
    return left, top, right, bottom


@njit(cache=True, nogil=True, _nrt=False)
def clear_below(levels, base, table, level, above):
    """Writes zeros wherever `reduce_level` will look for the box `above` of the next level."""
    left, right = needed(above[0], above[2], table[level, COLUMNS])
    top, bottom = needed(above[1], above[3], table[level, ROWS])
    for row in range(top, bottom):
        start = base + row * table[level, STRIDE]
        levels[start + left : start + right] = 0.0


@njit(cache=True, nogil=True, _nrt=False, fastmath=True, error_model="numpy")
def reduce_level(fine, fine_base, coarse, coarse_base, table, level, above, half):
    """coarse = every second pixel of fine * k_G inside the box `above`; half [>= COLUMNS] is scratch."""
    rows, columns, stride = table[level, ROWS], table[level, COLUMNS], table[level, STRIDE]
    first, last = needed(above[0], above[2], columns)
    inner_first, inner_last = max(above[0], 1), min(above[2], max((columns - 1) // 2, 0))
    for j in range(above[1], above[3]):
        centre = fine[fine_base + 2 * j * stride :]
        over, under = (
            fine[fine_base + reflected(2 * j - 1, rows) * stride :],
            fine[fine_base + reflected(2 * j + 1, rows) * stride :],
        )
        far_over, far_under = (
            fine[fine_base + reflected(2 * j - 2, rows) * stride :],
            fine[fine_base + reflected(2 * j + 2, rows) * stride :],
        )
        for i in range(first, last):
            half[i] = CENTRE * centre[i] + NEXT * (over[i] + under[i]) + OUTER * (far_over[i] + far_under[i])
        out = coarse[coarse_base + j * table[level + 1, STRIDE] :]
        for i in range(inner_first, inner_last):
            out[i] = (
                CENTRE * half[2 * i]
                + NEXT * (half[2 * i - 1] + half[2 * i + 1])
                + OUTER * (half[2 * i - 2] + half[2 * i + 2])
            )
        for side in range(2):
            border_first, border_last = (
                (above[0], inner_first) if side == 0 else (max(inner_last, inner_first), above[2])
            )
            for i in range(border_first, border_last):
                near = half[reflected(2 * i - 1, columns)] + half[reflected(2 * i + 1, columns)]
                far = half[reflected(2 * i - 2, columns)] + half[reflected(2 * i + 2, columns)]
                out[i] = CENTRE * half[2 * i] + NEXT * near + OUTER * far


@njit(cache=True, nogil=True, _nrt=False, fastmath=True, error_model="numpy")
def expand_level(coarse, coarse_base, fine, fine_base, table, level, box, above, half):
    """fine += adjoint of `reduce_level` applied to coarse, inside `box`; half is scratch of the coarse level's rows,
    each as long as the fine level's."""
    rows, columns, stride = table[level, ROWS], table[level, COLUMNS], table[level, STRIDE]
    coarse_rows, coarse_columns = table[level + 1, ROWS], table[level + 1, COLUMNS]
    left, top, right, bottom = box
    for j in range(above[1], above[3]):
        row = coarse[coarse_base + j * table[level + 1, STRIDE] - 1 :]
        out = half[(j + 1) * stride : (j + 2) * stride]
        # As if nothing were reflected: an even pixel gathers from three coarse ones, an odd one from two. row[k + 1] is
        # the coarse pixel k; beside the level there are zeros.
        for k in range(left // 2, (right + 1) // 2):
            out[2 * k] = CENTRE * row[k + 1] + OUTER * (row[k] + row[k + 2])
            out[2 * k + 1] = NEXT * (row[k + 1] + row[k + 2])
        # Only the first and the last coarse pixel reach over the border.
        if above[0] == 0:
            out[reflected(-1, columns)] += NEXT * row[1]
            out[reflected(-2, columns)] += OUTER * row[1]
        if above[2] == coarse_columns:
            if 2 * coarse_columns - 1 >= columns:
                out[reflected(2 * coarse_columns - 1, columns)] += NEXT * row[coarse_columns]
            out[reflected(2 * coarse_columns, columns)] += OUTER * row[coarse_columns]
    if above[1] == 0:
        half[:stride] = 0.0
    if above[3] == coarse_rows:
        half[(coarse_rows + 1) * stride : (coarse_rows + 2) * stride] = 0.0
    for y in range(top, bottom):
        out = fine[fine_base + y * stride :]
        here, after = half[(y // 2 + 1) * stride :], half[(y // 2 + 2) * stride :]
        if y % 2 == 0:
            before = half[(y // 2) * stride :]
            for i in range(left, right):
                out[i] += CENTRE * here[i] + OUTER * (before[i] + after[i])
        else:
            for i in range(left, right):
                out[i] += NEXT * (here[i] + after[i])
    for side in range(2):
        j = 0 if side == 0 else coarse_rows - 1
        if not above[1] <= j < above[3]:
            continue
        row = half[(j + 1) * stride :]
        for tap in range(-2, 3):
            beyond = 2 * j + tap
            if (side == 0 and beyond < 0) or (side == 1 and beyond >= rows):
                y = reflected(beyond, rows)
                if top <= y < bottom:
                    weight = NEXT if abs(tap) == 1 else OUTER
                    out = fine[fine_base + y * stride :]
                    for i in range(left, right):
                        out[i] += weight * row[i]


@njit(cache=True, nogil=True, _nrt=False, fastmath=True, error_model="numpy")
def subtract_target(levels, base, target, target_base, stride, box):
    """levels -= target inside a box; returns the sums of squares of (the difference, the target) there."""
    left, top, right, bottom = box
    total, known = 0.0, 0.0
    for row in range(top, bottom):
        mine, other = levels[base + row * stride :], target[target_base + row * stride :]
        squares, known_squares = np.float32(0.0), np.float32(0.0)
        for i in range(left, right):
            difference = mine[i] - other[i]
            mine[i] = difference
            squares += difference * difference
            known_squares += other[i] * other[i]
        total += squares
        known += known_squares
    return total, known


@njit(cache=True, nogil=True, _nrt=False, fastmath=True, error_model="numpy")
def scale_box(levels, base, stride, box, factor):
    left, top, right, bottom = box
    for row in range(top, bottom):
        mine = levels[base + row * stride :]
        for i in range(left, right):
            mine[i] *= factor


@njit(cache=True, nogil=True, _nrt=False, fastmath=True, error_model="numpy")
def sum_of_squares(levels, table, level):
    total = 0.0
    for row in range(table[level, ROWS]):
        mine = levels[table[level, START] + row * table[level, STRIDE] :]
        squares = np.float32(0.0)
        for i in range(table[level, COLUMNS]):
            squares += mine[i] * mine[i]
        total += squares
    return total


@njit(cache=True, nogil=True, error_model="numpy", _nrt=False)
def picture_pyramid(picture, table, levels, half):
    """Writes the pyramid of one channel [H, W] into levels; returns Σ_l 4^l |K_l x|²."""
    rows, columns = picture.shape
    levels[:] = 0.0
    for row in range(rows):
        start = table[0, START] + row * table[0, STRIDE]
        for column in range(columns):
            levels[start + column] = picture[row, column]
    total, weight = 0.0, 1.0
    for level in range(len(table) - 1):
        if level > 0:
            above = (0, 0, table[level, COLUMNS], table[level, ROWS])
            reduce_level(levels, table[level - 1, START], levels, table[level, START], table, level - 1, above, half)
        total += weight * sum_of_squares(levels, table, level)
        weight *= 4.0
    return total


@njit(cache=True, nogil=True, error_model="numpy", _nrt=False)
def pyramid_log_likelihood(table, box, levels, target, target_total, boxes, half):
    """log p of one channel. The first of `levels` holds its drawn picture inside `box` and zeros around it.

    Leaves the pyramid of the residual in levels and each level's box in boxes [L, 4]. target is the observed picture's
    pyramid, target_total the weighed sum of its squares.
    """
    count = len(table) - 1
    total, weight = target_total, 1.0
    for level in range(count):
        boxes[level] = box
        if level + 1 < count:
            above = box_above(box, table[level + 1, ROWS], table[level + 1, COLUMNS])
            if level + 2 < count:
                beyond = box_above(above, table[level + 2, ROWS], table[level + 2, COLUMNS])
                clear_below(levels, table[level + 1, START], table, level + 1, beyond)
            reduce_level(levels, table[level, START], levels, table[level + 1, START], table, level, above, half)
            squares, known = subtract_target(
                levels, table[level, START], target, table[level, START], table[level, STRIDE], box
            )
            box = above
        else:
            squares, known = subtract_target(
                levels, table[level, START], target, table[level, START], table[level, STRIDE], box
            )
        total += weight * (squares - known)
        weight *= 4.0
    return -0.5 * total


@njit(cache=True, nogil=True, error_model="numpy", _nrt=False)
def pyramid_gradient(table, boxes, levels, half, scale):
    """Turns levels, as `pyramid_log_likelihood` left them, into scale · d log p / d residual, in the first of them."""
    count = len(table) - 1
    for level in range(count - 1, -1, -1):
        box = (boxes[level, 0], boxes[level, 1], boxes[level, 2], boxes[level, 3])
        scale_box(levels, table[level, START], table[level, STRIDE], box, np.float32(-scale * 4.0**level))
        if level + 1 < count:
            above = (boxes[level + 1, 0], boxes[level + 1, 1], boxes[level + 1, 2], boxes[level + 1, 3])
            expand_level(levels, table[level + 1, START], levels, table[level, START], table, level, box, above, half)
