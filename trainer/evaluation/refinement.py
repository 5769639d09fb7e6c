"""Test-time refinement of what an encoder says, with the training's own renderer (`imaging.refinement`)."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import torch
from jaxtyping import Float, Int64
from torch import Tensor

from imaging.refinement import Draw, Guess, refine
from trainer.config import SceneConfig
from trainer.evaluation.gallery import render


class Inference(NamedTuple):
    """What is said about pictures, one by one; angles in radians."""

    shape_mean: Float[Tensor, "B Z"]
    shape_deviation: Float[Tensor, "B Z"]
    probabilities: Float[Tensor, "B R"]
    """Of the azimuth's coarse bins."""
    azimuth_fine_mean: Float[Tensor, "B"]
    light_azimuths: Float[Tensor, "B"] | None
    """How far the lights are turned; None of a model that knows one light only."""


def refined(
    inference: Inference,
    codes: Float[Tensor, "K Z"],
    images: Float[Tensor, "B 3 H W"],
    bin_centres: Float[Tensor, "R"],
    decode: Callable[[Float[Tensor, "K Z"]], Float[Tensor, "K V 3"]],
    faces: Int64[Tensor, "F 3"],
    scene: SceneConfig,
    iterations: int,
) -> tuple[Inference, Float[Tensor, "K Z"]]:
    """The same with better poses and lights, and better shape codes, of K objects in B / K consecutive pictures each.

    From the most probable coarse pose and the mean of the fine one, shape, pose and light follow their pictures.
    """
    draw = drawing(decode, faces, scene)
    views = len(images) // len(codes)
    azimuths = (bin_centres[inference.probabilities.argmax(1)] + inference.azimuth_fine_mean).double().numpy()
    found = []
    for number, code in enumerate(codes.double().numpy()):
        mine = slice(number * views, (number + 1) * views)
        light = None if inference.light_azimuths is None else inference.light_azimuths[mine].double().numpy()
        guess = Guess(code, azimuths[mine], light)
        found.append(refine(draw, images[mine].numpy(), guess, iterations).guess)
    moved = _joined([guess.azimuths for guess in found]) - _joined([azimuths])
    lights = [guess.light_azimuths for guess in found if guess.light_azimuths is not None]
    better = inference._replace(
        azimuth_fine_mean=inference.azimuth_fine_mean + moved, light_azimuths=_joined(lights) if lights else None
    )
    return better, _joined([guess.shape_code[None] for guess in found])


def drawing(
    decode: Callable[[Float[Tensor, "K Z"]], Float[Tensor, "K V 3"]], faces: Int64[Tensor, "F 3"], scene: SceneConfig
) -> Draw:
    """How `imaging.refinement` has shapes drawn: decoded by the model, under the scene's camera and lights."""

    def draw(codes: np.ndarray, azimuths: np.ndarray, light_azimuths: np.ndarray | None) -> np.ndarray:
        vertices = decode(torch.as_tensor(codes, dtype=torch.float32))
        lights = None if light_azimuths is None else torch.as_tensor(light_azimuths, dtype=torch.float32)
        turned = torch.as_tensor(azimuths, dtype=torch.float32)
        pictures: np.ndarray = render(faces, scene, vertices, turned, lights).numpy()
        return pictures

    return draw


def _joined(parts: list[np.ndarray]) -> Tensor:
    return torch.as_tensor(np.concatenate(parts), dtype=torch.float32)
