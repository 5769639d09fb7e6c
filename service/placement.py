"""Where an object belongs that was cut out of a picture: size and place are looked for with the pose and the shape.

Framing sets a cut-out object by a rule of thumb, and the encoder, which has seen objects where a camera has them, is
easily led astray by some percent. So the object is set elsewhere, looked at and drawn again as it was found there, and
stays where this explains it best: the most probable placement, with the re-render error's likelihood as it tells
categories apart, and the deviations from the rule that renderings have as the prior's.
"""

import math
from functools import cache
from typing import Final, NamedTuple

from imaging.framing import USUAL, Placement
from imaging.preparation import Prepared, placed
from service.explanation import SHARPNESS, unexplained
from service.inference import Engine, Posterior, decode, encode

DEFAULT_ROUNDS: Final = 2
MOST_ROUNDS: Final = 4
# Of renderings of thirteen classes, from the rule: see docs/decisions.md. The centre's is that of each coordinate.
_SIZE_DEVIATION: Final = 0.15
_CENTRE_DEVIATION: Final = 0.045
# A first round's; each further one's are half as large.
_SIZE_STEP: Final = 0.12
_CENTRE_STEP: Final = 0.05


class Placed(NamedTuple):
    """A picture whose object was looked for, and what it says."""

    prepared: Prepared
    posterior: Posterior


def place(engine: Engine, prepared: Prepared, rounds: int) -> Placed:
    """Sets a cut-out object where the model explains it best: in each round its height, its side and its size are
    tried a step to either side. A picture that was framed already, or no round, leaves all as it is.

    Raises:
        InferenceError: the graphs failed, or gave numbers that are not finite.
    """
    if prepared.cutout is None or rounds == 0:
        return Placed(prepared, encode(engine, prepared.picture))

    @cache
    def looked_at(placement: Placement) -> tuple[float, Placed]:
        candidate = placed(prepared, placement)
        posterior = encode(engine, candidate.picture)
        error = unexplained(engine, candidate, posterior, decode(engine, posterior.shape_mean))
        return _surprise(placement, error), Placed(candidate, posterior)

    best = USUAL
    for number in range(rounds):
        for way in _ways(1 / 2**number):
            neighbours = (_moved(best, away) for away in (Placement(1 / way.size, -way.right, -way.down), way))
            best = min((best, *neighbours), key=lambda placement: looked_at(placement)[0])
    return looked_at(best)[1]


def _ways(share: float) -> tuple[Placement, ...]:
    """The steps of a round, the first one's times `share`."""
    step = share * _CENTRE_STEP
    return Placement(down=step), Placement(right=step), Placement(size=1 + share * _SIZE_STEP)


def _moved(placement: Placement, way: Placement) -> Placement:
    return Placement(placement.size * way.size, placement.right + way.right, placement.down + way.down)


def _surprise(placement: Placement, error: float) -> float:
    """−log P of a placement, up to a constant."""
    size, right, down = math.log(placement.size) / _SIZE_DEVIATION, placement.right, placement.down
    centre = math.hypot(right, down) / _CENTRE_DEVIATION
    return SHARPNESS * math.log(max(error, 1e-9)) + 0.5 * (size**2 + centre**2)
