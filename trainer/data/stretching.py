"""Objects of other proportions: real ones differ more in them than those of a class's generator do."""

import zlib
from typing import Final

import numpy as np

from trainer.data.shapes.solid import Mesh, normalise

STRETCHED_SHARE: Final = 0.5
"""Of the objects; all others stay as they are, so that none of a class's own proportions becomes rare."""

# Numpy pads seeds with zeros: without a number of its own, this would be the stream of an object's first azimuth.
_STREAM: Final = zlib.crc32(b"stretch")


def stretched(mesh: Mesh, instance: str, seed: int, spread: float) -> Mesh:
    """The mesh, or for STRETCHED_SHARE of the instances, by chance, the mesh stretched along each of its axes, by
    factors whose logarithms are normal with deviation `spread`; the same on every call, of unit bounding-box
    diagonal."""
    rng = np.random.default_rng([seed, zlib.crc32(instance.encode()), _STREAM])
    if not spread or rng.random() >= STRETCHED_SHARE:
        return mesh
    return normalise(mesh._replace(vertices=mesh.vertices * np.exp(spread * rng.standard_normal(3))))
