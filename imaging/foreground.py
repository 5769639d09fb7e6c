"""Which pixels of a photograph show the object: all but the background's, which is flooded from the border.

Soft shadows on the background are part of it, and so are holes that show it; highlights on the object are not.
"""

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from imaging.backdrop import (
    TOLERANCE,
    Backdrop,
    Lightness,
    Places,
    backdrop_lightness,
    border_backdrop,
    distance_from,
    places,
    refined_backdrop,
)
from imaging.errors import BackgroundError
from imaging.holes import holes_in
from imaging.neighbourhood import highest, lowest
from imaging.regions import flooded, regions_of, selected
from imaging.shadow import shadow_on

Mask = NDArray[np.bool_]
Plane = NDArray[np.float32]

_LEAST_SIDE: Final = 8
"""Height and width of a picture in which object and background can be told, pixels."""
_RINGING: Final = 0.15
"""How much of a step compression echoes around it."""
LEAST_SHARE: Final = 0.01
"""Less of the picture is no object."""
MOST_SHARE: Final = 0.9
"""More of the picture leaves no background."""
_MOST_BORDER: Final = 0.3
"""An object that touches more of the picture's border is cut off, or none."""
_MOST_FAINT: Final = 0.15
"""Share of the object's outline that may hardly differ from the background."""
_LEAST_PART: Final = 0.01
"""Parts of the foreground that are smaller than this share of the largest are dust."""
_LEAST_BORDER_PART: Final = 0.2
"""The same for parts that touch the border."""


class Foreground(NamedTuple):
    """An object in a picture, and what is behind it."""

    mask: Mask
    """[h, w] the object's pixels, the mixed ones at its edge included."""
    backdrop: Backdrop
    behind: Lightness
    """[3, h, w] the backdrop in this picture."""


def foreground_of(lightness: Lightness) -> Foreground:
    """The object in a picture [3, h, w].

    Raises BackgroundError where the background is not plain, or nearly all is object, or nearly nothing.
    """
    height, width = lightness.shape[1:]
    if min(height, width) < _LEAST_SIDE:
        raise BackgroundError("expected a picture with some background around an object, found a strip")
    at = places(height, width)
    backdrop = _backdrop(lightness, at)
    behind = backdrop_lightness(backdrop, at)
    distance = distance_from(behind, lightness, backdrop.noise)
    mask = ~flooded(_with_rim(distance < TOLERANCE**2))
    mask[[0, -1]] = mask[[1, -2]]
    mask[:, [0, -1]] = mask[:, [1, -2]]

    # All else happens where anything was found.
    window = _window(mask)
    near, background = distance[window], ~mask[window]
    background |= highest(background, 2) & (near < _RINGING**2 * highest(near, 3))
    seen = lightness[:, *window], behind[:, *window], backdrop.noise
    background |= shadow_on(background, *seen)
    mask[window] = _without_dust(~(background | holes_in(~background, *seen)))
    _check(mask, window, near)
    return Foreground(mask, backdrop, behind)


def _backdrop(lightness: Lightness, at: Places) -> Backdrop:
    """The background's model: from the border, then from all that is connected with it and fits."""
    coarse, at = lightness[:, ::2, ::2], (at[0][::2], at[1][::2])
    rough = border_backdrop(lightness)
    fitting = distance_from(backdrop_lightness(rough, at), coarse, rough.noise) < TOLERANCE**2
    pure = lowest(fitting, 1)
    return refined_backdrop(coarse, at, flooded(_with_rim(fitting)) & pure)


def _with_rim(mask: Mask) -> Mask:
    """The mask with its outermost pixels set, so that a thin line around a picture hides no background."""
    mask[[0, -1]] = True
    mask[:, [0, -1]] = True
    return mask


def _window(mask: Mask) -> tuple[slice, slice]:
    """Rows and columns around all that is set, and some more."""
    rows, columns = (np.flatnonzero(mask.any(axis)) for axis in (1, 0))
    if not len(rows):
        return slice(0, 0), slice(0, 0)
    return slice(max(0, rows[0] - 3), rows[-1] + 4), slice(max(0, columns[0] - 3), columns[-1] + 4)


def _without_dust(foreground: Mask) -> Mask:
    """The foreground without small parts, and without what comes in from the border beside something much larger."""
    parts = regions_of(foreground)
    least = np.where(parts.at_border, _LEAST_BORDER_PART, _LEAST_PART) * parts.areas.max(initial=0)
    return selected(parts, parts.areas >= least)


def _check(mask: Mask, window: tuple[slice, slice], distance: Plane) -> None:
    """Raises BackgroundError where a `mask` [h, w] is no object; `distance` is known within the window."""
    share = float(mask.mean())
    if share < LEAST_SHARE:
        raise BackgroundError(
            f"expected an object that stands out from its background, found one on {share:.1%} of the picture"
        )
    if share > MOST_SHARE:
        raise BackgroundError(f"expected a plain background around the object, found {1 - share:.0%} of the picture")
    border = np.concatenate((mask[0], mask[-1], mask[1:-1, 0], mask[1:-1, -1]))
    if border.mean() > _MOST_BORDER:
        raise BackgroundError(
            f"expected an object within the picture, found one that touches {border.mean():.0%} of its border"
        )
    outline = mask[window] & highest(~mask[window], 1)
    faint = float((highest(distance, 1)[outline] < (1.6 * TOLERANCE) ** 2).mean())
    if faint > _MOST_FAINT:
        raise BackgroundError(
            "expected an object that stands out from its background, found one of nearly the same colour along "
            f"{faint:.0%} of its outline"
        )
