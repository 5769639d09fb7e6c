"""Holes in an object, such as between the slats of a chair: enclosed by it, but part of the background."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from imaging.backdrop import TOLERANCE, Lightness, distance_from
from imaging.neighbourhood import highest, lowest
from imaging.regions import regions_of, selected, sums_over

Mask = NDArray[np.bool_]

_LEAST_HOLE: Final = 4
"""Pixels; what is smaller may be noise."""
_LEAST_SHARP: Final = 0.6
"""Share of a hole's rim at which the picture steps."""
_STEP: Final = 2.5
"""How far from the background the picture is beyond such a rim, in tolerances."""
_STEEPNESS: Final = 0.35
"""Share of the distance six pixels away that is reached there within two."""
_MOST_MISMATCH: Final = 9.0
"""Squared distance of the mean colour of a hole's inner pixels from the background's, in variances of the noise."""


def holes_in(mask: Mask, lightness: Lightness, behind: Lightness, noise: NDArray[np.float32], grain: int = 1) -> Mask:
    """[h, w] where an object's `mask` has holes that show what is behind.

    Other than highlights they end at an edge, and other than parts of nearly the same colour they match what is behind
    but for noise: that of single pixels is `grain` times `noise`, that of means over a region `noise` at the most.
    """
    distance = distance_from(behind, lightness, grain * noise)
    candidates = regions_of(mask & (distance < TOLERANCE**2))
    large = candidates.areas >= _LEAST_HOLE
    if not large.any():
        return np.zeros_like(mask)
    inner = lowest(candidates.mask, 1)
    rim = candidates.mask & ~inner
    near = highest(distance, 2)
    sharp = rim & (near > (_STEP * TOLERANCE) ** 2) & (near > _STEEPNESS**2 * highest(distance, 6))
    ends, sharp_ends = (sums_over(candidates, values.astype(np.float32)) for values in (rim, sharp))
    # Holes so narrow that they have no inner pixels cannot be asked for their colour.
    area = np.maximum(sums_over(candidates, inner.astype(np.float32)), 1)
    off = [sums_over(candidates, inner * plane) / area for plane in lightness - behind]
    mismatch = np.square(np.stack(off) / noise[:, None]).sum(0)
    return selected(candidates, large & (sharp_ends > _LEAST_SHARP * ends) & (mismatch <= _MOST_MISMATCH))
