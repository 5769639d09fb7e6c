"""How well a model explains a picture, as the service tells it: the re-render error, and the out-of-class score.

The re-render error is the share of the picture's light that the reconstruction gets wrong, Σ (x − x̂)² / Σ x², both
linear and averaged over the same squares, about twelve to the picture's height: 0 is the picture itself, 1 as far away
as black; where another exposure explains it much better, see `imaging.exposure`. The score sets it beside the errors of
held-out pictures of the class. The service refuses a picture above MOST_STRANGE. Its own code, which this package must
not know, computes the same (a test holds both together).
"""

from typing import NamedTuple

import numpy as np
import torch
from jaxtyping import Bool, Float, UInt8
from numpy import ndarray
from torch import Tensor

from imaging.alignment import aligned
from imaging.exposure import unexplained_light
from trainer.errors import DataError
from trainer.evaluation.pictures import linear_batches
from trainer.evaluation.subject import Prediction, Subject
from trainer.geometry.normals import vertex_normals
from trainer.rendering import renderer
from trainer.rendering.camera import project
from trainer.rendering.cpu import topology_of
from trainer.rendering.lighting import shade, shade_by_light

MOST_STRANGE = 2.0
"""Out-of-class score above which the service does not answer."""
_ROWS = 12


class Errors(NamedTuple):
    """Re-render errors of held-out pictures."""

    median: float
    high: float
    """What one in twenty exceeds."""


class Yardstick(NamedTuple):
    """What pictures of the class cost a model that was not trained on them."""

    framed: Errors
    """Of pictures in the model's own frame."""
    fitted: Errors
    """Of objects that were cut out and brought there."""


def errors_of(found: Float[ndarray, "N"]) -> Errors:
    """Raises DataError for errors that are all alike: no other could then be told from them."""
    median, high = np.quantile(found, (0.5, 0.95))
    if not median < high:
        raise DataError(
            f"Expected held-out pictures that are explained unequally well, found {len(found)} with an error of "
            f"{median:g} each. Take more of them, or another model."
        )
    return Errors(float(median), float(high))


def out_of_class_scores(errors: Float[ndarray, "N"], held_out: Errors) -> Float[ndarray, "N"]:
    """0 as well explained as half of the held-out pictures or better, 1 as badly as the worst one in twenty, and on in
    proportion."""
    return np.maximum(0.0, (errors - held_out.median) / (held_out.high - held_out.median))


def rerender_errors(
    subject: Subject,
    prediction: Prediction,
    codes: UInt8[ndarray, "N 3 H W"],
    fitted: Bool[ndarray, "N"] | None = None,
) -> Float[ndarray, "N"]:
    """The re-render error of each picture.

    Where the object was cut out and `fitted` into the frame, its size and place are a guess, and the picture is brought
    to where the drawing has it.
    """
    scene = subject.scene
    side = _square(scene.width, scene.height)
    moved = np.zeros(len(codes), bool) if fitted is None else fitted
    errors, start = list[float](), 0
    for images in linear_batches(codes):
        numbers = torch.arange(start, start + len(images))
        drawn = _drawn(subject, prediction.of(numbers))
        brought = [
            torch.from_numpy(aligned(image.numpy(), again.numpy())) if moved[number] else image
            for number, image, again in zip(numbers, images, drawn, strict=True)
        ]
        seen, again = (torch.nn.functional.avg_pool2d(pictures, side) for pictures in (torch.stack(brought), drawn))
        errors += [unexplained_light(one, other) for one, other in zip(seen.numpy(), again.numpy(), strict=True)]
        start += len(images)
    return np.array(errors)


def _drawn(subject: Subject, told: Prediction) -> Float[Tensor, "N 3 H W"]:
    scene = subject.scene
    screen = project(told.vertices, told.azimuths, scene.camera, scene.width, scene.height)
    normals = vertex_normals(told.vertices, subject.faces)
    if told.light_azimuths is None:
        colours = shade(normals, told.azimuths, scene)
    else:
        colours = shade_by_light(normals, told.azimuths, told.light_azimuths[:, None], scene).squeeze(2)
    topology = topology_of(subject.faces)
    return renderer.draw(screen, colours, topology, scene.width, scene.height, crease=float("inf"))[:, :-1]


def _square(width: int, height: int) -> int:
    """Side of the squares, pixels: the largest that fills the picture exactly."""
    return max(side for side in range(1, max(1, height // _ROWS) + 1) if width % side == height % side == 0)
