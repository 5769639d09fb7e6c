"""From the encoder's word to what explains pictures better: the descent of `imaging.refinement`, drawn by the service.

The same picture gives the same answer as long as the time suffices.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Final, NamedTuple

import numpy as np

from imaging.alignment import aligned
from imaging.exposure import exposure
from imaging.preparation import Prepared
from imaging.refinement import Draw, Guess, refine
from service.inference import Array, Engine, Posterior, decode_all
from service.rendering.picture import draw_all
from service.rendering.projection import project
from service.rendering.shading import shade

_SAMPLES: Final = 2
"""Points in a pixel's side: a drawing has to change when something moves by a fraction of a pixel."""


class Effort(NamedTuple):
    """How much an answer may be refined."""

    iterations: int = 0
    seconds: float = math.inf
    """No iteration begins later than so many seconds after the first."""


AS_ENCODED: Final = Effort()
"""What the encoder says."""


class Improved(NamedTuple):
    """What replaces the encoder's answer."""

    posteriors: tuple[Posterior, ...]
    shape_code: Array
    iterations: int


def improve(
    engine: Engine,
    pictures: Sequence[Prepared],
    posteriors: Sequence[Posterior],
    shape_code: Array,
    effort: Effort,
) -> Improved:
    """Poses, lights and the shape code that explain the pictures better, together.

    How probable the coarse poses are stays the encoder's word. Pictures of cut-out objects, whose size and place are a
    guess, are brought to where its answer is drawn; those that another exposure explains, to how bright it is drawn.
    Raises InferenceError as the graphs do.
    """
    draw = _drawing(engine)
    lights = [posterior.light.azimuth for posterior in posteriors if posterior.light is not None]
    turned = np.array([posterior.azimuth for posterior in posteriors])
    first = draw(np.stack([shape_code] * len(pictures)), turned, np.array(lights) if lights else None)
    seen = np.stack([_as_drawn(prepared, drawn) for prepared, drawn in zip(pictures, first, strict=True)])
    guess = Guess(shape_code.astype(np.float64), turned, np.array(lights) if lights else None)
    after = refine(draw, seen, guess, *effort)
    improved = []
    for number, posterior in enumerate(posteriors):
        azimuth = float(after.guess.azimuths[number])
        light = posterior.light
        if light is not None and after.guess.light_azimuths is not None:
            light = replace(light, azimuth=float(after.guess.light_azimuths[number]))
        improved.append(
            replace(
                posterior,
                azimuth_fine_mean=posterior.azimuth_fine_mean + azimuth - posterior.azimuth,
                azimuth=(azimuth + math.pi) % (2 * math.pi) - math.pi,
                light=light,
            )
        )
    return Improved(tuple(improved), after.guess.shape_code.astype(np.float32), after.iterations)


def _as_drawn(prepared: Prepared, drawn: Array) -> Array:
    """A picture where its drawing is, and as bright."""
    picture = prepared.picture if prepared.method == "framed" else aligned(prepared.picture, drawn)
    as_bright: Array = np.minimum(picture / np.float32(exposure(picture, drawn)), 1)
    return as_bright


def _drawing(engine: Engine) -> Draw:
    """Shapes as the manifest's camera sees them in its light."""
    manifest = engine.manifest
    width, height = manifest.picture.width, manifest.picture.height

    def draw(codes: np.ndarray, azimuths: np.ndarray, lights: np.ndarray | None) -> Array:
        surface = decode_all(engine, codes.astype(np.float32))
        screens = project(surface.vertices, azimuths, manifest.camera, width, height)
        turned = np.zeros(len(codes)) if lights is None else lights
        colours = shade(surface.normals, azimuths, turned, manifest.lights, manifest.ambient)
        return draw_all(screens, colours, engine.faces, width, height, _SAMPLES).colour.astype(np.float32)

    return draw
