"""The levels of a picture's Gaussian pyramid in memory, and which of their pixels depend on which.

A level of n pixels reduces to ceil(n / 2); the last one has one pixel in its smaller dimension. The border is reflected
(index -1 is index 1). Levels lie in flat arrays row by row, with WIDE zeros before and after each row. Boxes are (left,
top, right, bottom), the last two exclusive.
"""

import numpy as np

from rasteriser.compilation import kernel
from rasteriser.vectors import WIDE

ROWS, COLUMNS, STRIDE, START = 0, 1, 2, 3


@kernel()
def level_table(width, height):
    """[L, 4]: rows, columns, stride, and where the level starts in a flat array whose length is the last START."""
    count, smaller = 1, min(width, height)
    while smaller > 1:
        smaller = (smaller + 1) // 2
        count += 1
    table = np.zeros((count + 1, 4), np.int64)
    rows, columns, start = height, width, WIDE
    for level in range(count):
        table[level, ROWS], table[level, COLUMNS] = rows, columns
        table[level, STRIDE], table[level, START] = columns + WIDE, start
        start += rows * (columns + WIDE)
        rows, columns = (rows + 1) // 2, (columns + 1) // 2
    # Whole vectors are read where the last row ends; and arrays side by side all start where a vector does.
    table[count, START] = (start + 3 * WIDE - 1) // WIDE * WIDE
    return table


@kernel()
def level_arrays(count, size):
    """[count, size] zeros for the levels of so many channels; all start where a vector in memory does, so that none of
    those that are read together lies in two lines of the cache. size: a multiple of WIDE."""
    numbers = np.zeros(count * size + WIDE, np.float32)
    first = -numbers.ctypes.data // numbers.itemsize % WIDE
    return numbers[first : first + count * size].reshape(count, size)


@kernel(_nrt=False)
def reflected(index, size):
    """Index with the border reflected, the border pixel itself not repeated."""
    if 0 <= index < size:
        return index
    if size == 1:
        return 0
    period = 2 * (size - 1)
    index = index % period
    return min(index, period - index)


@kernel(_nrt=False)
def reached(first, last, size):
    """Pixels of the next level, of `size` pixels, that depend on the pixels first..last - 1 of this one."""
    return max(0, (first - 1) // 2), min(size, (last + 1) // 2 + 1)


@kernel(_nrt=False)
def needed(first, last, size):
    """Pixels of this level, of `size` pixels, on which the pixels first..last - 1 of the next one depend."""
    return max(0, 2 * first - 2), min(size, 2 * last + 1)


@kernel(_nrt=False)
def box_above(box, rows, columns):
    """The box of the next level, of rows × columns pixels, outside which it vanishes if this one does outside `box`."""
    left, right = reached(box[0], box[2], columns)
    top, bottom = reached(box[1], box[3], rows)
    return left, top, right, bottom


@kernel(_nrt=False)
def clear_below(levels, base, table, level, above):
    """Writes zeros wherever `reduce_level` will look for the box `above` of the next level."""
    left, right = needed(above[0], above[2], table[level, COLUMNS])
    top, bottom = needed(above[1], above[3], table[level, ROWS])
    for row in range(top, bottom):
        start = base + row * table[level, STRIDE]
        levels[start + left : start + right] = 0.0
