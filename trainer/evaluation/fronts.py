"""Which shapes stand back to front: those that are more like the others when they are turned round.

That is a synchronisation over the group of two elements: a sign for each shape, such that pairs of one sign are more
alike as they stand, and pairs of two when one is turned; the leading eigenvector of what turning costs each pair tells
it (Singer, Angular synchronization by eigenvectors and semidefinite programming, 2011).
"""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
from jaxtyping import Bool, Float, Integer
from numpy import ndarray

from trainer.evaluation.pictures import threads
from trainer.evaluation.voxels import RESOLUTION, occupy

MOST_REFERENCES = 400
"""So many shapes, evenly chosen, settle among themselves how they stand; all others join them."""

_MOST_SHIFT = RESOLUTION // 4
_ROUNDS = 20
_BATCH = 400


def back_to_front(shapes: Float[ndarray, "N V 3"], faces: Integer[ndarray, "F 3"]) -> Bool[ndarray, "N"]:
    """The shapes that are to be turned by half a turn about +Y; less than half of those that settle it.

    The shapes' plane of symmetry is x = 0: they may be shifted along z, up to a quarter of the grid, for the middle of
    a bounding box is no part of an object. How alike two are is the cosine of their occupancies at 32³.
    """
    references = np.linspace(0, len(shapes) - 1, min(MOST_REFERENCES, len(shapes))).round().astype(np.int64)
    solids = unit_occupancies(shapes[references], faces)
    cost = _cost_of_turning(solids, solids)
    np.fill_diagonal(cost, 0)
    signs = _settled((cost + cost.T) / 2)
    turned = np.empty(len(shapes), np.bool_)
    for start in range(0, len(shapes), _BATCH):
        batch = slice(start, start + _BATCH)
        turned[batch] = _cost_of_turning(unit_occupancies(shapes[batch], faces), solids) @ signs < 0
    turned[references] = signs < 0
    return turned


def unit_occupancies(shapes: Float[ndarray, "N V 3"], faces: Integer[ndarray, "F 3"]) -> Float[ndarray, "N R R R"]:
    """Occupancies, of unit length as vectors."""
    with ThreadPoolExecutor(threads()) as pool:
        full = np.stack(list(pool.map(lambda vertices: occupy(vertices, faces).full, shapes))).astype(np.float32)
    full /= np.sqrt(np.maximum(full.sum((1, 2, 3), keepdims=True), 1))
    return full


def _cost_of_turning(solids: Float[ndarray, "N R R R"], others: Float[ndarray, "M R R R"]) -> Float[ndarray, "N M"]:
    """How much less alike each pair is where one of it is turned, each at the best shift."""
    cost: Float[ndarray, "N M"] = _likeness(solids, others) - _likeness(solids, others[:, ::-1, :, ::-1])
    return cost


def _likeness(solids: Float[ndarray, "N R R R"], others: Float[ndarray, "M R R R"]) -> Float[ndarray, "N M"]:
    padded = np.pad(others, ((0, 0), (0, 0), (0, 0), (_MOST_SHIFT, _MOST_SHIFT)))
    flat, size = solids.reshape(len(solids), -1), others.shape[-1]
    best = np.full((len(solids), len(others)), -np.inf, np.float32)
    for shift in range(2 * _MOST_SHIFT + 1):
        shifted = padded[..., shift : shift + size].reshape(len(others), -1)
        np.maximum(best, flat @ shifted.T, out=best)
    return best


def _settled(cost: Float[ndarray, "M M"]) -> Float[ndarray, "M"]:
    """1 for those that stay and -1 for those that are turned, of which there are fewer."""
    _, vectors = np.linalg.eigh(cost)
    signs = np.where(vectors[:, -1] < 0, -1.0, 1.0)
    for _ in range(_ROUNDS):
        signs = np.where(cost @ signs < 0, -1.0, 1.0)
    return signs if signs.sum() >= 0 else -signs
