"""Soft shadows that an object casts on a plain background."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from imaging.backdrop import TOLERANCE, Lightness
from imaging.neighbourhood import highest, lowest
from imaging.regions import flooded, regions_of, selected

Mask = NDArray[np.bool_]

_DARKEST: Final = 0.5
"""Lightness of a shadow relative to the background's: a quarter of the light."""
_LEAST_SHADOW: Final = 0.01
"""Share of the background; a smaller shadow is not worth looking for."""
_LEAST_SOLID: Final = 10
"""Pixels of a part of the object; what is smaller may be noise."""


def shadow_on(background: Mask, lightness: Lightness, behind: Lightness, noise: NDArray[np.float32]) -> Mask:
    """[h, w] the shadowed background beside that which is known: darker but of its hue, fading into it without an edge.

    An object of the background's hue looks like that too, but for its edges. Where they are faint the flood might leak
    into it: so nothing above a part of the object counts, as a shadow lies on the ground.
    """
    scaled, expected = lightness / noise[:, None, None], behind / noise[:, None, None]
    brightness = np.einsum("chw,chw->hw", expected, expected)
    ratio = np.einsum("chw,chw->hw", scaled, expected) / np.maximum(brightness, 1)
    scaled -= ratio * expected
    same_hue = np.einsum("chw,chw->hw", scaled, scaled) < TOLERANCE**2
    shaded = same_hue & (ratio > _DARKEST) & (ratio < 1)
    if (shaded & ~background).sum() < _LEAST_SHADOW * background.sum():
        return np.zeros_like(shaded)
    shaded &= ~_edges(lightness.mean(0), float(noise.mean()))
    solid = regions_of(~(shaded | background))
    object_below = np.logical_or.accumulate(selected(solid, solid.areas >= _LEAST_SOLID)[::-1])[::-1]
    shaded &= ~object_below
    # Only through passages of three pixels: an edge may be faint for one.
    passable = shaded | background
    grown: Mask = highest(flooded(lowest(passable, 1)), 2) & passable
    return grown


def _edges(plane: NDArray[np.float32], noise: float) -> Mask:
    """[h, w] where the plane steps within two pixels, other than in a slope that goes on beyond them."""
    found = np.zeros(plane.shape, bool)
    for values, edges in ((plane, found), (plane.T, found.T)):
        near, far = np.abs(values[4:-2] - values[2:-4]), np.abs(values[6:] - values[:-6])
        edges[3:-3] |= (near > 3 * noise) & (near > 0.6 * far)
    return found
