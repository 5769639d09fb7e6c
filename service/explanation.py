"""How well a model explains a picture: what it found is drawn again, and compared.

The re-render error is the share of the picture's light that the drawing gets wrong: Σ (x − x̂)² / Σ x². Here x is the
picture as the encoder got it, and x̂ the mesh under the lights and the camera that were found; both are linear, and
averaged over the same squares, about twelve to the picture's height. 0 is the picture itself, 1 as far away as black.
Where x̂ explains a picture much better brighter or darker than it is drawn, it is taken to be so, at a price
(`imaging.exposure`).
"""

import math
from collections.abc import Mapping, Sequence
from typing import Final

from imaging.alignment import aligned
from imaging.exposure import unexplained_light
from imaging.preparation import Method, Prepared
from imaging.scaling import block_means
from service.inference import Engine, Posterior, Surface
from service.manifest import HeldOut
from service.rendering.picture import draw
from service.rendering.projection import project
from service.rendering.shading import shade

MOST_STRANGE: Final = 2.0
"""Out-of-class score above which there is no answer."""
_ROWS: Final = 12
"""Squares in the picture's height: where an edge lies, to a pixel, says little of the class."""
_SAMPLES: Final = 6
"""Points in a square's side, a pixel's width apart in pictures of 96 × 72: with four, thin legs came out up to a third
off."""
_SHARPNESS: Final = 5.0
"""Fitted on held-out pictures of four models: probabilities are then about as often right as they say."""


def unexplained(engine: Engine, prepared: Prepared, posterior: Posterior, surface: Surface) -> float:
    """The re-render error of a picture, given the pose and the light found in it and the mesh.

    Where the object was cut out and framed, its size and place in the picture are a guess; the picture is then brought
    to where the drawing has it.
    """
    manifest = engine.manifest
    camera, (width, height) = manifest.camera, (manifest.picture.width, manifest.picture.height)
    side = _square(width, height)
    columns, rows = width // side, height // side
    screen = project(surface.vertices, posterior.azimuth, camera, columns, rows)
    light_azimuth = 0.0 if posterior.light is None else posterior.light.azimuth
    colours = shade(surface.normals, posterior.azimuth, light_azimuth, manifest.lights, manifest.ambient)
    samples = max(1, round(_SAMPLES * _ROWS / rows))
    drawn = draw(screen, colours, engine.faces, columns, rows, samples).colour
    picture = prepared.picture if prepared.method == "framed" else aligned(prepared.picture, drawn)
    seen = block_means(picture, side)
    return unexplained_light(seen, drawn)


def out_of_class_score(held_out: HeldOut | None, method: Method, error: float) -> float | None:
    """How much worse a picture is explained than held-out pictures of the class: 0 as well as half of them or better, 1
    as badly as the worst one in twenty, and on in proportion. None where the bundle does not know."""
    errors = held_out and (held_out.framed if method == "framed" else held_out.fitted)
    if not errors:
        return None
    return max(0.0, (error - errors.median) / (errors.high - errors.median))


def category_probabilities(
    errors: Mapping[str, Sequence[float]], biases: Mapping[str, float] | None = None
) -> dict[str, float]:
    """How probable each category is, from the re-render errors of its model on the pictures, the most probable first.

    P ∝ e^bias Π error⁻⁵: the likelihood of ten independent numbers with normal noise of unknown size. The bias, 0 if
    absent, is that of the model's manifest.
    """
    evidence = {name: category_evidence(found) + (biases or {}).get(name, 0.0) for name, found in errors.items()}
    highest = max(evidence.values())
    weights = {name: math.exp(value - highest) for name, value in evidence.items()}
    total = sum(weights.values())
    return {name: weights[name] / total for name in sorted(weights, key=lambda name: (-weights[name], name))}


def category_evidence(errors: Sequence[float]) -> float:
    """Logarithm, up to a constant, of how probable pictures are that a model explains up to these errors."""
    return -_SHARPNESS * sum(math.log(max(error, 1e-9)) for error in errors)


def _square(width: int, height: int) -> int:
    """Side of the squares, pixels: the largest that fills the picture exactly."""
    return max(side for side in range(1, max(1, height // _ROWS) + 1) if width % side == height % side == 0)
