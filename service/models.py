"""What the service says of its models."""

from dataclasses import dataclass

import numpy as np
from pydantic import JsonValue

from service.inference import Engine
from service.manifest import Camera, Conventions, HeldOut, Light, Picture


@dataclass(frozen=True)
class ModelReport:
    """A model that is served."""

    category: str
    model: str
    """Its identity: sha256 of its graphs."""
    parameterisation: str
    """What its meshes are made of: `subdivision` is a cube that is pulled into shape, blocks are blocks."""
    conventions: Conventions
    picture: Picture
    """The picture that the model sees; others are brought there."""
    camera: Camera
    lights: tuple[Light, ...]
    ambient: tuple[float, float, float]
    light_varies: bool
    """Whether the lights' turn about +Y is found in the picture, or known."""
    vertices: int
    faces: int
    blocks: tuple[str, ...]
    azimuth_bins: int
    latent: int
    """How many numbers a shape code has."""
    latent_order: tuple[int, ...]
    """The numbers of a shape code, counted from 0, the one that changes shapes most first."""
    latent_activity: tuple[float, ...]
    """How far each number of the shape code moves vertices as it goes from −1 to 1: root mean square, diagonals."""
    held_out: HeldOut | None
    """Re-render errors of held-out pictures, from which out-of-class scores are made; null where there were none."""
    metrics: dict[str, JsonValue]
    """The judge's figures, as python -m trainer evaluate wrote them."""
    training_step: int | None


@dataclass(frozen=True)
class Models:
    """All models that are served, by category."""

    categories: tuple[ModelReport, ...]


def report_model(engine: Engine) -> ModelReport:
    """What a model is."""
    manifest = engine.manifest
    step = manifest.training.get("step")
    order = np.argsort(-np.array(engine.latent_activity), kind="stable")
    return ModelReport(
        category=manifest.category,
        model=manifest.identity,
        parameterisation=_parameterisation(manifest.training),
        conventions=manifest.conventions,
        picture=manifest.picture,
        camera=manifest.camera,
        lights=manifest.lights,
        ambient=manifest.ambient,
        light_varies=bool(manifest.light_bin_centres_degrees),
        vertices=manifest.vertices,
        faces=len(manifest.faces),
        blocks=tuple(block.name for block in manifest.blocks),
        azimuth_bins=len(manifest.azimuth_bin_centres_degrees),
        latent=manifest.latent,
        latent_order=tuple(order.tolist()),
        latent_activity=tuple(round(value, 6) for value in engine.latent_activity),
        held_out=manifest.held_out,
        metrics=manifest.metrics,
        training_step=step if isinstance(step, int) else None,
    )


def _parameterisation(training: dict[str, JsonValue]) -> str:
    """Where it is not told, the model is from when there was only one."""
    config = training.get("config")
    model = config.get("model") if isinstance(config, dict) else None
    told = model.get("parameterisation") if isinstance(model, dict) else None
    return told if isinstance(told, str) else "subdivision"
