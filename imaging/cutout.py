"""The object alone: cut out of its picture, with its share of each pixel, and its own colour there, on black."""

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from imaging.backdrop import backdrop_lightness, lightness_of, linear_of, places
from imaging.decoding import Picture, part_of
from imaging.foreground import foreground_of
from imaging.holes import holes_in
from imaging.neighbourhood import highest, total
from imaging.scaling import block_means

Mask = NDArray[np.bool_]
Planes = NDArray[np.float32]

_OVERVIEW_PIXELS: Final = 20_000
"""About as many pixels suffice to tell object and background."""
_GRAINY_PIXELS: Final = 8_000
"""A picture with more is never looked at pixel by pixel of its file."""
_REACH: Final = 2
"""How far from the edge the colours on both sides are looked for, pixels of the overview."""
_LEAST_CONTRAST: Final = 0.02
"""Linear distance of object and background below which a mixture of them cannot be told."""
_LEAST_OPACITY: Final = 0.05
"""What covers less of a pixel is taken for noise."""
_LEAST_WEIGHT: Final = np.float32(1e-9)


def cut_out(picture: Picture) -> Picture:
    """The part of a picture with a plain background that holds the object, with its opacity, on black.

    Raises BackgroundError where the object cannot be told from what is around it.
    """
    pixels = picture.colour[0].size
    factor = max(1, round(math.sqrt(pixels / _OVERVIEW_PIXELS)))
    if factor * picture.factor == 1 and pixels > _GRAINY_PIXELS:
        # Noise and compression are strongest in single pixels of the file.
        factor = 2
    overview = block_means(picture.colour, factor)
    mask, backdrop, behind = foreground_of(lightness_of(overview))
    rows, columns = _extent(mask, 1), _extent(mask, 0)
    y, x = places(*mask.shape)
    mask, overview, behind = mask[rows, columns], overview[:, rows, columns], behind[:, rows, columns]

    fine_rows, fine_columns = _enlarged(rows, factor), _enlarged(columns, factor)
    part = part_of(picture, fine_rows, fine_columns)
    height, width = part.colour.shape[1:]
    at = _between(y, factor)[fine_rows][:height], _between(x, factor)[fine_columns][:width]
    fine_behind = backdrop_lightness(backdrop, at)
    solid = mask.repeat(factor, 0).repeat(factor, 1)[:height, :width]
    solid &= ~holes_in(solid, lightness_of(part.colour), fine_behind, backdrop.noise, factor)
    colour, opacity = _unmixed(part.colour, solid, overview, linear_of(behind), factor)
    return part._replace(colour=colour, opacity=opacity)


def _extent(mask: Mask, axis: int) -> slice:
    """The columns (axis 0) or rows (1) of the foreground, and some more for what is mixed and what is near."""
    at = np.flatnonzero(mask.any(axis))
    return slice(max(0, int(at[0]) - _REACH - 1), min(mask.shape[1 - axis], int(at[-1]) + _REACH + 2))


def _enlarged(extent: slice, factor: int) -> slice:
    return slice(extent.start * factor, extent.stop * factor)


def _between(values: NDArray[np.float64], factor: int) -> NDArray[np.float64]:
    """Evenly spaced values for `factor` times as many pixels."""
    step = values[-1] - values[-2] if len(values) > 1 else 0.0
    offsets = (np.arange(factor) + 0.5) / factor - 0.5
    return (values[:, None] + step * offsets).ravel()


def _unmixed(colour: Planes, solid: Mask, overview: Planes, behind: Planes, factor: int) -> tuple[Planes, Planes]:
    """The foreground of a linear picture [3, h, w] on black, and its opacity [h, w].

    At the edge of what is `solid` a pixel is a mixture in linear light, I = αF + (1 - α)B: F is the mean of the
    object's colour near by, B that of the background, both from the `overview`, the picture reduced by `factor`, or
    from what is `behind` there if none is near. What remains is I - (1 - α)B: no halo of the old background stays.
    """
    covered = block_means(solid.astype(np.float32), factor)
    near, known = _mean_near(overview, (~highest(covered > 0, 1)).astype(np.float32))
    near = np.where(known, near, behind)
    # Where a part is so thin that none of its pixels is unmixed, those that differ most stand for it.
    contrast = np.square(overview - near).sum(0) * (covered > 0)
    own, _ = _mean_near(overview, ~highest(covered < 1, 1) + np.float32(1e-3) * contrast)

    y, x = np.nonzero(highest(solid, factor) & highest(~solid, factor))
    coarse = y // factor * near.shape[2] + x // factor
    near, own = near.reshape(3, -1).take(coarse, 1), own.reshape(3, -1).take(coarse, 1)
    span = own - near
    length = np.square(span).sum(0)
    mixed, hard = colour[:, y, x], solid[y, x]
    share = ((mixed - near) * span).sum(0) / np.maximum(length, _LEAST_CONTRAST**2)
    share = np.where(length > _LEAST_CONTRAST**2, share.clip(0, 1), hard).astype(np.float32)
    share[share < _LEAST_OPACITY] = 0

    opacity = solid.astype(np.float32)
    alone = colour * opacity
    opacity[y, x] = share
    alone[:, y, x] = (mixed - (1 - share) * near).clip(0, share)
    return alone, opacity


def _mean_near(planes: Planes, weight: NDArray[np.float32]) -> tuple[Planes, Mask]:
    """[3, h, w] the weighted mean within reach, and where there is one; 0 elsewhere."""
    sums = total(np.concatenate((planes * weight, weight[None])), _REACH)
    known = sums[3] > _LEAST_WEIGHT
    return sums[:3] / np.maximum(sums[3], _LEAST_WEIGHT), known
