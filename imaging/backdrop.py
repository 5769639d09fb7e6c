"""The plain background of a photograph: one colour, a gradient or a vignette, found from the picture's border.

Colours are compared by lightness, about the square root of linear light, channel by channel: there noise and
compression are about as strong in dark as in bright places, and steps look about alike.
"""

import math
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from imaging.errors import BackgroundError

Lightness = NDArray[np.float32]
Points = tuple[NDArray[np.intp], NDArray[np.intp]]
Places = tuple[NDArray[np.float64], NDArray[np.float64]]
"""y of each row and x of each column, from -1 to 1 over the picture."""

TOLERANCE: Final = 5.0
"""Up to this distance, in standard deviations of the background's noise, a pixel has the background's colour."""

# The root's slope is without bounds at black, where it would magnify noise.
_TOE: Final = np.float32(0.004)
_ROOT: Final = np.sqrt(_TOE)
_STRETCH: Final = 1 / (np.sqrt(1 + _TOE) - _ROOT)

_LEAST_NOISE: Final = 0.005
"""About 1.3 sRGB codes: rounding and the mildest compression."""
_MOST_NOISE: Final = 0.02
"""About 5 sRGB codes in a reduced picture; what varies more is a texture."""
_LEAST_BORDER: Final = 0.7
"""Share of the border that has to fit."""
_GOOD_SPREAD: Final = (3 * _LEAST_NOISE) ** 2
"""Spread of a fit beside which no better is looked for."""
_ROUNDS: Final = 3
_BORDER_POINTS: Final = 200
_INNER_POINTS: Final = 400


class Backdrop(NamedTuple):
    """A smooth background: polynomials in the places of a picture."""

    coefficients: NDArray[np.float64]
    """[degree + 1, degree + 1, 3] of y^i x^j, y and x from -1 to 1 over the picture."""
    noise: NDArray[np.float32]
    """[3] standard deviation of the picture's channels from them."""


def lightness_of(linear: NDArray[np.float32]) -> Lightness:
    """Lightness from linear intensity, both 0..1."""
    lightness: Lightness = (np.sqrt(linear + _TOE) - _ROOT) * _STRETCH
    return lightness


def linear_of(lightness: Lightness) -> NDArray[np.float32]:
    """Linear intensity from lightness."""
    linear: NDArray[np.float32] = np.square(lightness / _STRETCH + _ROOT) - _TOE
    return linear


def border_backdrop(lightness: Lightness) -> Backdrop:
    """The backdrop that most of the border of a picture [3, h, w] fits, even where an object touches it.

    Raises BackgroundError where too little of the border fits any, or the border is textured.
    """
    points = _border_points(*lightness.shape[1:])
    values = lightness[:, *points].T.astype(np.float64)
    terms = _terms(places(*lightness.shape[1:]), points, 2)
    fits = [_trimmed_fit(terms, values, np.ones(len(values), bool))]
    if fits[0].spread > _GOOD_SPREAD:
        # An object at one side drags the fit; one of the fits that begin without that side is free of it.
        y, x = points
        sides = (y < y.max() / 2, y > y.max() / 2, x < x.max() / 2, x > x.max() / 2)
        fits += [_trimmed_fit(terms, values, side) for side in sides]
    coefficients, _ = min(fits, key=lambda fit: fit.spread)
    residuals = values - terms @ coefficients
    noise = _noise(residuals)
    share = float((np.square(residuals / noise).sum(1) < TOLERANCE**2).mean())
    if noise.max() > _MOST_NOISE or share < _LEAST_BORDER:
        raise BackgroundError("expected a plain background, found many colours or a texture along the border")
    return Backdrop(_square(coefficients, 2), noise)


def refined_backdrop(lightness: Lightness, at: Places, background: NDArray[np.bool_]) -> Backdrop:
    """The backdrop of a higher degree that fits the pixels known as `background` [h, w].

    Raises BackgroundError where there are none.
    """
    known = np.flatnonzero(background)
    if not len(known):
        raise BackgroundError("expected a plain background, found none that is connected with the border")
    # Evenly spread, by a stride that does not meet the same columns in every row.
    chosen = known[:: max(1, len(known) // _INNER_POINTS) | 1]
    points = np.divmod(chosen, background.shape[1])
    values = lightness[:, *points].T.astype(np.float64)
    terms = _terms(at, points, 4)
    coefficients = _fit(terms, values)
    return Backdrop(_square(coefficients, 4), _noise(values - terms @ coefficients))


def places(height: int, width: int) -> Places:
    """The places of all pixels of a picture."""
    return np.linspace(-1, 1, height), np.linspace(-1, 1, width)


def backdrop_lightness(backdrop: Backdrop, at: Places) -> Lightness:
    """[3, h, w] at these places."""
    degree = len(backdrop.coefficients) - 1
    rows, columns = (np.vander(values, degree + 1, increasing=True) for values in at)
    planes: Lightness = (rows @ backdrop.coefficients.transpose(2, 0, 1) @ columns.T).astype(np.float32)
    return planes


def distance_from(behind: Lightness, lightness: Lightness, noise: NDArray[np.float32]) -> NDArray[np.float32]:
    """[h, w] squared distance of each pixel from what is behind it, in variances of the noise."""
    difference = (lightness - behind) / noise[:, None, None]
    squared: NDArray[np.float32] = np.einsum("chw,chw->hw", difference, difference)
    return squared


def _border_points(height: int, width: int) -> Points:
    """Rows and columns of pixels along the border, in turns at two distances from it."""
    edges = [np.linspace(0, size - 1, _BORDER_POINTS // 4).astype(np.intp) for size in (height, width)]
    inset = np.where(np.arange(_BORDER_POINTS // 4) % 2, 1, max(2, min(height, width) // 40))
    y = np.concatenate((edges[0], edges[0], inset, height - 1 - inset))
    x = np.concatenate((inset, width - 1 - inset, edges[1], edges[1]))
    return y.clip(0, height - 1), x.clip(0, width - 1)


def _terms(at: Places, points: Points, degree: int) -> NDArray[np.float64]:
    """[N, terms] the powers y^i x^j, i + j up to the degree, the lowest first."""
    y, x = (np.vander(values[indices], degree + 1, increasing=True) for values, indices in zip(at, points, strict=True))
    i, j = _powers(degree)
    return y[:, i] * x[:, j]


def _powers(degree: int) -> Points:
    """i and j of the terms."""
    i, j = np.divmod(np.arange((degree + 1) ** 2), degree + 1)
    order = np.argsort(i + j, kind="stable")[: (degree + 1) * (degree + 2) // 2]
    return i[order], j[order]


def _square(coefficients: NDArray[np.float64], degree: int) -> NDArray[np.float64]:
    square = np.zeros((degree + 1, degree + 1, 3))
    square[_powers(degree)] = coefficients
    return square


def _fit(terms: NDArray[np.float64], values: NDArray[np.float64]) -> NDArray[np.float64]:
    # A little weight keeps what the points leave open near zero; the six terms up to the second degree are sure.
    stiffness = np.where(np.arange(terms.shape[1]) < 6, 1e-6, 1e-3)
    normal = terms.T @ terms + len(terms) * np.diag(stiffness)
    return np.linalg.solve(normal, terms.T @ values).astype(np.float64, copy=False)


class _Fit(NamedTuple):
    coefficients: NDArray[np.float64]
    spread: float
    """Squared distance within which 70 % of the points are."""


def _trimmed_fit(terms: NDArray[np.float64], values: NDArray[np.float64], kept: NDArray[np.bool_]) -> _Fit:
    """A fit to the 70 % of the points that agree best, beginning with those `kept`: least trimmed squares."""
    count, spread = int(0.7 * len(values)), math.inf
    for _ in range(_ROUNDS):
        coefficients = _fit(terms[kept], values[kept])
        distances = np.square(values - terms @ coefficients).sum(1)
        spread = float(np.partition(distances, count)[count])
        kept = distances <= spread
    return _Fit(coefficients, spread)


def _noise(residuals: NDArray[np.float64]) -> NDArray[np.float32]:
    """[3] standard deviations that some strangers hardly change."""
    return np.maximum(1.4826 * np.median(np.abs(residuals), axis=0), _LEAST_NOISE).astype(np.float32)
