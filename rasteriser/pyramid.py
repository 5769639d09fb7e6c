"""The Gaussian-pyramid likelihood of Eqs. 1, 2 and 4, for a residual r = I - x held in cache.

With noise ε/2^l at level l and ε = 1,

    log p = -1/2 Σ_l 4^l |r_l|²   (constants left out),   r_0 = r,  r_{l+1} = r_l * k_G at every second pixel.

k_G is the binomial kernel [1 4 6 4 1]/16 in rows and columns; the border is reflected (index -1 is index 1). A level
of n pixels reduces to ceil(n / 2); the last level has one pixel in its smaller dimension.

Reduction is linear, so r_l = K_l I - K_l x. The pyramid K_l x of the observed picture is made once for all hypotheses;
that of I is made only in the box outside which I and K_l I vanish. Boxes are (left, top, right, bottom), the last two
exclusive. Levels lie in flat arrays row by row (`level_table`), with WIDE zeros before and after each row.
"""

import numpy as np

from rasteriser.compilation import kernel
from rasteriser.levels import COLUMNS, ROWS, START, STRIDE, box_above, clear_below, needed, reflected
from rasteriser.vectors import (
    WIDE,
    evens,
    first_lanes,
    load_wide,
    odds,
    select,
    store,
    total,
    zeros_wide,
    zipped_high,
    zipped_low,
)

CENTRE, NEXT, OUTER = np.float32(6 / 16), np.float32(4 / 16), np.float32(1 / 16)


@kernel(_nrt=False, error_model="numpy")
def reduce_level(fine, fine_base, coarse, coarse_base, table, level, above, half):
    """coarse = every second pixel of fine * k_G inside the box `above`; half is scratch."""
    # Two rows take turns: each is summed up after the next one is smoothed, or it would be read while it is written.
    length = table[level + 1, COLUMNS] + 2 * WIDE
    for j in range(above[1], above[3] + 1):
        if j < above[3]:
            even, odd = half[j % 2 * length :], half[(2 + j % 2) * length :]
            smooth_row(fine, fine_base, table, level, above, j, even, odd)
        if j > above[1]:
            even, odd = half[(j - 1) % 2 * length :], half[(2 + (j - 1) % 2) * length :]
            out = coarse[coarse_base + (j - 1) * table[level + 1, STRIDE] :]
            for i in range(above[0], above[2], WIDE):
                near, far = load_wide(odd, i) + load_wide(odd, i + 1), load_wide(even, i) + load_wide(even, i + 2)
                value = load_wide(even, i + 1) * CENTRE + near * NEXT + far * OUTER
                store(out, i, select(first_lanes(above[2] - i), value, 0.0))


@kernel(_nrt=False, error_model="numpy", inline="always")
def smooth_row(fine, fine_base, table, level, above, j, even, odd):
    """k_G along y, of row 2j: even[k + 1] is its pixel 2k, odd[k + 1] its pixel 2k + 1, from k = -1 on."""
    rows, columns, stride = table[level, ROWS], table[level, COLUMNS], table[level, STRIDE]
    first, last = needed(above[0], above[2], columns)
    centre = fine[fine_base + 2 * j * stride :]
    over, under = (
        fine[fine_base + reflected(2 * j - 1, rows) * stride :],
        fine[fine_base + reflected(2 * j + 1, rows) * stride :],
    )
    far_over, far_under = (
        fine[fine_base + reflected(2 * j - 2, rows) * stride :],
        fine[fine_base + reflected(2 * j + 2, rows) * stride :],
    )
    for k in range(first // 2, (last + 1) // 2, WIDE):
        left = smoothed(far_over, over, centre, under, far_under, 2 * k)
        right = smoothed(far_over, over, centre, under, far_under, 2 * k + WIDE)
        store(even, k + 1, evens(left, right))
        store(odd, k + 1, odds(left, right))
    if above[0] == 0:
        even[0], odd[0] = smoothed_pixel(even, odd, -2, columns), smoothed_pixel(even, odd, -1, columns)
    coarse_columns = table[level + 1, COLUMNS]
    if above[2] == coarse_columns:
        if 2 * coarse_columns > columns:
            odd[coarse_columns] = smoothed_pixel(even, odd, 2 * coarse_columns - 1, columns)
        even[coarse_columns + 1] = smoothed_pixel(even, odd, 2 * coarse_columns, columns)


@kernel(_nrt=False, error_model="numpy", inline="always")
def smoothed(far_over, over, centre, under, far_under, start):
    """k_G along y, of WIDE pixels from `start` on."""
    near = load_wide(over, start) + load_wide(under, start)
    return (
        load_wide(centre, start) * CENTRE
        + near * NEXT
        + (load_wide(far_over, start) + load_wide(far_under, start)) * OUTER
    )


@kernel(_nrt=False, error_model="numpy", inline="always")
def smoothed_pixel(even, odd, index, columns):
    """Of a row that `reduce_level` has smoothed, the pixel of an index beyond the border, reflected."""
    inside = reflected(index, columns)
    return even[inside // 2 + 1] if inside % 2 == 0 else odd[inside // 2 + 1]


@kernel(_nrt=False, error_model="numpy")
def expand_level(coarse, coarse_base, fine, fine_base, table, level, box, above, half):
    """fine += adjoint of `reduce_level` applied to coarse, inside `box`; half is scratch of the coarse level's rows,
    each as long as the fine level's."""
    rows, columns, stride = table[level, ROWS], table[level, COLUMNS], table[level, STRIDE]
    coarse_rows, coarse_columns = table[level + 1, ROWS], table[level + 1, COLUMNS]
    left, top, right, bottom = box
    for j in range(above[1], above[3]):
        row = coarse[coarse_base + j * table[level + 1, STRIDE] - 1 :]
        out = half[(j + 1) * stride :]
        # As if nothing were reflected: an even pixel gathers from three coarse ones, an odd one from two. row[k + 1] is
        # the coarse pixel k; beside the level there are zeros.
        for k in range(left // 2, (right + 1) // 2, WIDE):
            here, after = load_wide(row, k + 1), load_wide(row, k + 2)
            even, odd = here * CENTRE + (load_wide(row, k) + after) * OUTER, (here + after) * NEXT
            store(out, 2 * k, zipped_low(even, odd))
            store(out, 2 * k + WIDE, zipped_high(even, odd))
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
        before = half[(y // 2) * stride :]
        for i in range(left, right, WIDE):
            if y % 2 == 0:
                change = load_wide(here, i) * CENTRE + (load_wide(before, i) + load_wide(after, i)) * OUTER
            else:
                change = (load_wide(here, i) + load_wide(after, i)) * NEXT
            store(out, i, load_wide(out, i) + select(first_lanes(right - i), change, 0.0))
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


@kernel(_nrt=False, error_model="numpy")
def subtract_target(levels, base, target, target_base, stride, box, factor):
    """levels = factor · (levels - target) inside a box, unless factor is 0; returns the sums of squares of the
    difference and of the target there, one less the other."""
    left, top, right, bottom = box
    squares = 0.0
    for row in range(top, bottom):
        mine, other = levels[base + row * stride :], target[target_base + row * stride :]
        # |a - b|² - |b|² = (a - 2b) a
        change = zeros_wide()
        for i in range(left, right, WIDE):
            inside, value, known = first_lanes(right - i), load_wide(mine, i), load_wide(other, i)
            change = change + select(inside, (value - known - known) * value, 0.0)
            if factor != 0.0:
                store(mine, i, select(inside, (value - known) * factor, value))
        squares += total(change)
    return squares


@kernel(_nrt=False, error_model="numpy")
def sum_of_squares(levels, table, level):
    """Of a level; beside it there are zeros."""
    squares = 0.0
    for row in range(table[level, ROWS]):
        mine = levels[table[level, START] + row * table[level, STRIDE] :]
        in_row = zeros_wide()
        for i in range(0, table[level, COLUMNS], WIDE):
            value = load_wide(mine, i)
            in_row = in_row + value * value
        squares += total(in_row)
    return squares


@kernel(error_model="numpy", _nrt=False)
def picture_pyramid(picture, table, levels, half):
    """Writes the pyramid of one channel [H, W] into levels, where zeros lie beside all rows; returns Σ_l 4^l |K_l x|².
    That is not finite if the picture is not."""
    squares, weight = copied(picture, levels[table[0, START] :], table[0, STRIDE]), 4.0
    for level in range(1, len(table) - 1):
        above = (0, 0, table[level, COLUMNS], table[level, ROWS])
        reduce_level(levels, table[level - 1, START], levels, table[level, START], table, level - 1, above, half)
        squares += weight * sum_of_squares(levels, table, level)
        weight *= 4.0
    return squares


@kernel(error_model="numpy", _nrt=False)
def copied(picture, level, stride):
    """Writes a picture [H, W] into rows of a level that lie `stride` apart; returns the sum of its squares."""
    rows, columns = picture.shape
    whole, squares = columns // WIDE * WIDE, 0.0
    for row in range(rows):
        source, into, in_row = picture[row], level[row * stride :], zeros_wide()
        for column in range(0, whole, WIDE):
            value = load_wide(source, column)
            store(into, column, value)
            in_row = in_row + value * value
        squares += total(in_row)
        for column in range(whole, columns):
            into[column] = source[column]
            squares += source[column] * source[column]
    return squares


@kernel(error_model="numpy", _nrt=False)
def pyramid_log_likelihood(table, box, levels, target, target_total, scale, boxes, half):
    """log p of one channel. The first of `levels` holds its drawn picture inside `box` and zeros around it.

    target is the observed picture's pyramid, target_total the weighed sum of its squares. Unless scale is 0, leaves
    scale · d log p / d level in levels, each level's own share, and each level's box in boxes [L, 4], for
    `pyramid_gradient`.
    """
    count = len(table) - 1
    squares, weight = target_total, 1.0
    for level in range(count):
        boxes[level] = box
        above = box
        if level + 1 < count:
            above = box_above(box, table[level + 1, ROWS], table[level + 1, COLUMNS])
            if level + 2 < count:
                beyond = box_above(above, table[level + 2, ROWS], table[level + 2, COLUMNS])
                clear_below(levels, table[level + 1, START], table, level + 1, beyond)
            reduce_level(levels, table[level, START], levels, table[level + 1, START], table, level, above, half)
        start, stride = table[level, START], table[level, STRIDE]
        squares += weight * subtract_target(levels, start, target, start, stride, box, np.float32(-scale * weight))
        box, weight = above, 4.0 * weight
    return -0.5 * squares


@kernel(error_model="numpy", _nrt=False)
def pyramid_gradient(table, boxes, levels, half):
    """Gathers what `pyramid_log_likelihood` left of all levels in the first of them."""
    for level in range(len(table) - 3, -1, -1):
        box = (boxes[level, 0], boxes[level, 1], boxes[level, 2], boxes[level, 3])
        above = (boxes[level + 1, 0], boxes[level + 1, 1], boxes[level + 1, 2], boxes[level + 1, 3])
        expand_level(levels, table[level + 1, START], levels, table[level, START], table, level, box, above, half)
