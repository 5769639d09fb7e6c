"""A model under judgement, whatever it is made from: what it makes of pictures, and what it was made for."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import torch
from jaxtyping import Float, Int64, UInt8
from numpy import ndarray
from torch import Tensor

from trainer.config import SceneConfig
from trainer.errors import CheckpointError, ConfigError
from trainer.evaluation.pictures import linear_batches
from trainer.evaluation.refinement import Inference, refined
from trainer.geometry.conventions import wrap_angle
from trainer.model.posterior import bin_centres, most_probable_light
from trainer.training.checkpoint import Checkpoint


class Prediction(NamedTuple):
    """What a model says about pictures, in its own canonical frame; angles in radians."""

    vertices: Float[Tensor, "N V 3"]
    azimuths: Float[Tensor, "N"]
    bins: Float[Tensor, "N"]
    """Centre of the most probable coarse bin of the azimuth."""
    probabilities: Float[Tensor, "N R"]
    """How probable each bin is."""
    light_azimuths: Float[Tensor, "N"] | None
    """How far the lights are turned; None of a model that knows one light only."""

    def of(self, numbers: Int64[Tensor, "M"]) -> "Prediction":
        """What it says about some of the pictures."""
        lights = None if self.light_azimuths is None else self.light_azimuths[numbers]
        return Prediction(
            self.vertices[numbers], self.azimuths[numbers], self.bins[numbers], self.probabilities[numbers], lights
        )


@dataclass(frozen=True)
class Subject:
    """All that the judge sees of a model."""

    infer: Callable[[Float[Tensor, "B 3 H W"]], Inference]
    decode: Callable[[Float[Tensor, "K Z"]], Float[Tensor, "K V 3"]]
    faces: Int64[Tensor, "F 3"]
    bin_centres: Float[Tensor, "R"]
    """The azimuths of the coarse bins, radians."""
    scene: SceneConfig
    """Camera, lights and size of the pictures that it expects."""
    category: str
    training: dict[str, object]
    """How long it was trained: step, seconds."""
    views_per_instance: int = 1
    """Pictures of an object that a step of its training pooled: how those of a test are, depends on it."""
    refinement: int = 0
    """Iterations at test time (`trainer.evaluation.refinement`); 0 takes the encoder's word."""


MOST_ITERATIONS = 100


def check_refinement(iterations: int) -> None:
    """Raises ConfigError where an option asks for a number of iterations that is none."""
    if not 0 <= iterations <= MOST_ITERATIONS:
        raise ConfigError(f"Expected --refine from 0 to {MOST_ITERATIONS}, found {iterations}.")


def from_checkpoint(checkpoint: Checkpoint) -> Subject:
    """The model of a checkpoint, run by torch."""
    model = checkpoint.model

    def infer(images: Float[Tensor, "B 3 H W"]) -> Inference:
        with torch.no_grad():
            posterior = model.encode(images)
        light = most_probable_light(posterior)
        return Inference(
            posterior.shape_mean,
            posterior.shape_deviation,
            posterior.azimuth_logits.softmax(1),
            posterior.azimuth_fine_mean,
            light,
        )

    def decode(codes: Float[Tensor, "K Z"]) -> Float[Tensor, "K V 3"]:
        with torch.no_grad():
            return model.decode(codes)

    training = {"step": checkpoint.step, "seconds": checkpoint.run["seconds"]}
    centres = bin_centres(checkpoint.config.model.azimuth_bins, torch.zeros(()))
    views = checkpoint.config.optimiser.views_per_instance
    return Subject(infer, decode, model.faces, centres, checkpoint.scene, checkpoint.category, training, views)


def answer(subject: Subject, images: Float[Tensor, "B 3 H W"], views: int) -> Prediction:
    """The mean of z decoded, and the most probable coarse azimuth plus the mean of the fine one, of pictures of which
    each `views` consecutive ones show one object: its shape is found from all of them."""
    inference = subject.infer(images)
    pooled = pooled_means(inference, views, subject.views_per_instance)
    if subject.refinement:
        inference, pooled = refined(
            inference, pooled, images, subject.bin_centres, subject.decode, subject.faces, subject.scene,
            subject.refinement,
        )  # fmt: skip
    bins = inference.probabilities.argmax(1)
    azimuths = wrap_angle(subject.bin_centres[bins] + inference.azimuth_fine_mean)
    vertices = subject.decode(pooled).repeat_interleave(views, 0)
    return Prediction(vertices, azimuths, subject.bin_centres[bins], inference.probabilities, inference.light_azimuths)


def pooled_means(inference: Inference, views: int, views_per_instance: int) -> Float[Tensor, "K Z"]:
    """The mean of z of objects that each `views` consecutive pictures show.

    Of a model whose training pooled `views_per_instance` pictures, number by number the largest, as there (section 4 of
    the paper, "Shape"). Of one that was trained on single ones, that of the geometric mean of their densities, in which
    the surer a picture is of a number, the more it counts.
    """
    means = inference.shape_mean.unflatten(0, (-1, views))
    if views_per_instance > 1 or views == 1:
        largest: Tensor = means.amax(1)
        return largest
    precisions = inference.shape_deviation.unflatten(0, (-1, views)) ** -2
    weighted: Tensor = (precisions * means).sum(1) / precisions.sum(1)
    return weighted


def predict(subject: Subject, codes: UInt8[ndarray, "N 3 H W"], views: int = 1) -> Prediction:
    """What the service would answer for each picture; or, where each `views` consecutive pictures show one object, what
    the model makes of these together.

    Raises CheckpointError where that is not a number.
    """
    answers = [answer(subject, batch, views) for batch in linear_batches(codes, views)]
    vertices, azimuths, bins, probabilities, lights = zip(*answers, strict=True)
    known = [light for light in lights if light is not None]
    prediction = Prediction(
        torch.cat(vertices),
        torch.cat(azimuths),
        torch.cat(bins),
        torch.cat(probabilities),
        torch.cat(known) if known else None,
    )
    if not all(torch.isfinite(part).all() for part in prediction if part is not None):
        raise CheckpointError(
            "Expected vertices and azimuths from the model, found numbers that are not finite. Train again, or judge "
            "an earlier checkpoint."
        )
    return prediction
