"""Test-time refinement of what an encoder says, with the training's own renderer (`imaging.refinement`)."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import torch
from jaxtyping import Float, Int64
from torch import Tensor

from imaging.refinement import Draw, Guess, search
from trainer.config import SceneConfig
from trainer.evaluation.gallery import render


class Inference(NamedTuple):
    """What is said about pictures, one by one; angles in radians."""

    shape_mean: Float[Tensor, "B Z"]
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

    The coarse pose is decided by the drawings of all of them; then shape, pose and light follow their pictures.
    """
    draw = drawing(decode, faces, scene)
    views, centres = len(images) // len(codes), bin_centres.double().numpy()
    found = []
    for number, code in enumerate(codes.double().numpy()):
        mine = slice(number * views, (number + 1) * views)
        pictures = images[mine].numpy()
        fine = inference.azimuth_fine_mean[mine].double().numpy()
        light = None if inference.light_azimuths is None else inference.light_azimuths[mine].double().numpy()
        told = inference.probabilities[mine].double().numpy()
        after, probabilities, bins = search(draw, pictures, Guess(code, fine, light), centres, told, iterations)
        found.append((after.guess, probabilities, after.guess.azimuths - centres[bins]))
    lights = [guess.light_azimuths for guess, _, _ in found if guess.light_azimuths is not None]
    better = Inference(
        inference.shape_mean,
        _joined([probabilities for _, probabilities, _ in found]),
        _joined([fine for _, _, fine in found]),
        _joined(lights) if lights else None,
    )
    return better, _joined([guess.shape_code[None] for guess, _, _ in found])


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
