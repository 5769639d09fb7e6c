"""How much of a picture's light a drawing of it gets wrong, where nobody knows how the picture was exposed."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

_LEAST_LIGHT: Final = 1e-6
_MOST: Final = 16.0
"""Times that a picture is brighter or darker than it is drawn, at the most."""
_PRICE: Final = 2.0
"""How many times better another exposure has to explain a picture to be believed, and what the error then is times: for
less, what is too bright or too dark tells what the picture shows."""


def unexplained_light(seen: NDArray[np.floating], drawn: NDArray[np.floating]) -> float:
    """Σ (x − x̂)² / Σ x² of a linear picture x and a drawing x̂ [3, h, w], where x̂ is as bright as it is drawn, or twice
    that error as bright as explains x best, if that is less."""
    gain = exposure(seen, drawn)
    return _error(seen, gain * drawn) * (_PRICE if gain != 1 else 1.0)


def exposure(seen: NDArray[np.floating], drawn: NDArray[np.floating]) -> float:
    """How many times brighter than its drawing a picture is; 1 unless that explains it much better."""
    light = float(np.square(drawn).sum())
    gain = float((seen * drawn).sum()) / light if light > _LEAST_LIGHT else 1.0
    gain = min(_MOST, max(1 / _MOST, gain))
    return gain if _PRICE * _error(seen, gain * drawn) < _error(seen, drawn) else 1.0


def _error(seen: NDArray[np.floating], drawn: NDArray[np.floating]) -> float:
    return float(np.square(seen - drawn).sum() / max(float(np.square(seen).sum()), _LEAST_LIGHT))
