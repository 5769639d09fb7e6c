"""What a training refuses before it begins: settings that mean nothing, and pictures that they do not go with."""

import dataclasses
import re

import numpy as np
from jaxtyping import Int64
from torch import Tensor

from trainer.config import LossConfig, ModelConfig, OptimiserConfig, TrainConfig
from trainer.data.images import ImageSet
from trainer.data.lens import MOST_ZOOM
from trainer.errors import ConfigError, DataError
from trainer.training.intervals import Intervals

MOST_SEGMENTS = 64

# What the bundle and the service accept as a class's name.
_CATEGORY = re.compile(r"[a-z0-9][a-z0-9_-]{0,63}")


def check_settings(config: TrainConfig) -> None:
    """Raises ConfigError for the first setting that is out of range, and for settings that do not go together; NaN is
    out of every range."""
    model, loss, optimiser = config.model, config.loss, config.optimiser
    channels = (min(model.encoder_channels), max(model.encoder_channels))
    ranges: list[tuple[str, float, float, float]] = [
        ("width", config.width, 16, 2048),
        ("height", config.height, 16, 2048),
        ("zoom", config.zoom or 1.0, 1, MOST_ZOOM),
        ("seed", config.seed, 0, 2**31 - 1),
        ("validation_share", config.validation_share, 0, 0.5),
        ("model.latent", model.latent, 1, 1024),
        ("model.hidden", model.hidden, 1, 4096),
        ("model.segments", model.segments, 1, MOST_SEGMENTS),
        *(("model.proportions", times, 1, MOST_SEGMENTS) for times in model.proportions),
        ("model.blocks", model.blocks, 0, 1024),
        ("model.azimuth_bins", model.azimuth_bins, 1, 360),
        ("model.light_bins", model.light_bins, 1, 180),
        *(("model.encoder_channels", value, 1, 4096) for value in channels),
        ("optimiser.learning_rate", optimiser.learning_rate, 1e-12, 10),
        ("optimiser.decoder_factor", optimiser.decoder_factor, 1e-6, 1e6),
        ("optimiser.falling_share", optimiser.falling_share, 0, 1),
        ("optimiser.rotation_learning_rate", optimiser.rotation_learning_rate, 1e-12, 10),
        ("optimiser.gradient_clip", optimiser.gradient_clip, 1e-12, 1e12),
        ("optimiser.batch_size", optimiser.batch_size, 2, 65536),
        ("optimiser.views_per_instance", optimiser.views_per_instance, 1, 64),
        ("optimiser.steps", optimiser.steps, 1, 10**9),
        *_loss_ranges(loss),
    ]
    for name, value, low, high in ranges:
        if not low <= value <= high:
            raise ConfigError(
                f"Expected {name} from {low:g} to {high:g}, found {value}. Change the option or the preset."
            )
    _check_mesh(config.model)
    _check_together(config)


def check_processes(optimiser: OptimiserConfig, count: int) -> None:
    """Raises ConfigError where so many processes cannot share a batch evenly."""
    if optimiser.batch_size % (count * optimiser.views_per_instance):
        raise ConfigError(
            f"Expected optimiser.batch_size to be a multiple of {count * optimiser.views_per_instance}, found "
            f"{optimiser.batch_size}: {count} processes share a batch, and an object's pictures stay together. Change "
            "it, or the number of processes."
        )


def _check_mesh(model: ModelConfig) -> None:
    """Raises ConfigError for what a parameterisation or a base mesh has no use for."""
    usual = ModelConfig()
    if model.parameterisation == "subdivision" and model.blocks:
        raise ConfigError(
            f"Expected model.blocks of 0 with model.parameterisation subdivision, found {model.blocks}. Leave it away, "
            "or train ortho-block or full-block."
        )
    if model.parameterisation != "subdivision" and model.segments != usual.segments:
        raise ConfigError(
            f"Expected model.segments left at {usual.segments} with model.parameterisation {model.parameterisation}, "
            f"found {model.segments}: blocks have none. Train with --model.segments {usual.segments}, which the preset "
            "may have changed, or train subdivision."
        )
    if model.parameterisation != "subdivision" and model.base != usual.base:
        raise ConfigError(
            f"Expected model.base left at {usual.base} with model.parameterisation {model.parameterisation}, found "
            f"{model.base}: blocks are cuboids. Leave it away, or train subdivision."
        )
    if model.proportions != usual.proportions and (mesh := _other_than_cube(model)):
        raise ConfigError(
            f"Expected model.proportions left at 1 1 1 with {mesh}, found {' '.join(map(str, model.proportions))}: "
            "only a cube's edges are cut unevenly. Leave it away, or train subdivision with --model.base cube."
        )
    if model.segments * max(model.proportions) > MOST_SEGMENTS:
        raise ConfigError(
            f"Expected at most {MOST_SEGMENTS} segments along an edge, found model.segments {model.segments} times "
            f"model.proportions {max(model.proportions)}. Lower one."
        )


def _other_than_cube(model: ModelConfig) -> str:
    """What a model has instead of a displaced cube; nothing for one that has it."""
    if model.parameterisation != "subdivision":
        return model.parameterisation
    return "" if model.base == "cube" else f"model.base {model.base}"


def _check_together(config: TrainConfig) -> None:
    """Raises ConfigError for settings that contradict each other."""
    model, loss, optimiser = config.model, config.loss, config.optimiser
    usual = ModelConfig()
    if model.light == "fixed" and model.light_bins != usual.light_bins:
        raise ConfigError(
            f"Expected model.light_bins left at {usual.light_bins} with model.light fixed, found {model.light_bins}: "
            "a known light has none. Leave it away, or train with --model.light varying."
        )
    if loss.neighbour_weight and loss.objective == "paper":
        raise ConfigError(
            f"Expected loss.neighbour_weight of 0 with loss.objective paper, found {loss.neighbour_weight:g}: the "
            "paper asks no neighbours. Leave it away, or train with --loss.objective exact."
        )
    if loss.inversion_weight and (mesh := _other_than_cube(model)):
        raise ConfigError(
            f"Expected loss.inversion_weight of 0 with {mesh}, found {loss.inversion_weight:g}: only the inside of a "
            "displaced cube is known. Train with --loss.inversion-weight 0, or subdivision with --model.base cube."
        )
    if loss.inner_points == "learnt" and not loss.inversion_weight:
        raise ConfigError(
            "Expected loss.inner_points carried with loss.inversion_weight of 0, found learnt: nothing asks where "
            "inner points lie. Leave it away, or train with --loss.inversion-weight 100000."
        )
    if loss.front_back_weight and (model.parameterisation != "subdivision" or model.symmetry == "two-mirrors"):
        mesh = model.parameterisation if model.parameterisation != "subdivision" else f"model.symmetry {model.symmetry}"
        raise ConfigError(
            f"Expected loss.front_back_weight of 0 with {mesh}, found {loss.front_back_weight:g}: it weighs how "
            "unlike front and back of a displaced mesh are, which two mirrors make alike anyway. Leave it away, or "
            "train subdivision with --model.symmetry mirror."
        )
    for name in ("front_back_knee", "front_back_after"):
        if (value := getattr(loss, name)) and not loss.front_back_weight:
            raise ConfigError(
                f"Expected loss.{name} of 0 with loss.front_back_weight of 0, found {value:g}: nothing weighs how "
                "unlike front and back are. Leave it away, or train with --loss.front-back-weight 20."
            )
    if loss.kind == "silhouette" and model.light == "varying":
        raise ConfigError(
            "Expected model.light fixed with loss.kind silhouette, found varying: silhouettes say nothing about the "
            "light. Train with --model.light fixed, or with --loss.kind shading."
        )
    if optimiser.batch_size % optimiser.views_per_instance or optimiser.batch_size < 2 * optimiser.views_per_instance:
        raise ConfigError(
            f"Expected optimiser.batch_size to be a multiple of optimiser.views_per_instance "
            f"({optimiser.views_per_instance}) and of two objects at least, found {optimiser.batch_size}. Change one."
        )


def _loss_ranges(loss: LossConfig) -> list[tuple[str, float, float, float]]:
    """Weights may be 0; what is divided by may not."""
    divisors = {
        "temperature",
        "temperature_start",
        "temperature_cooling_steps",
        "kl_cooling_steps",
        "encoder_prior_steps",
        "eta",
    }
    numbers = {name: value for name, value in dataclasses.asdict(loss).items() if isinstance(value, int | float)}
    return [(f"loss.{name}", value, 1e-9 if name in divisors else 0, 1e9) for name, value in numbers.items()]


def check_intervals(intervals: Intervals) -> None:
    """Raises ConfigError for an interval of no steps."""
    for name, value in dataclasses.asdict(intervals).items():
        if value < 1:
            raise ConfigError(f"Expected --intervals.{name} of 1 step or more, found {value}.")


def check_category(category: str) -> None:
    """Raises ConfigError for a name that the service could not serve the model under."""
    if not _CATEGORY.fullmatch(category):
        raise ConfigError(
            f"Expected a category of small letters, digits, - and _, at most 64 of them, found {category!r}. "
            "Name what the pictures show with --class."
        )


def check_pictures(config: TrainConfig, images: ImageSet, training: Int64[Tensor, "T"]) -> None:
    """Raises DataError where there are too few pictures to train on, or too few of an object; where supervision is
    asked for without azimuths; and where lights are turned that the model takes to be fixed."""
    if len(training) < 2:
        raise DataError(f"Expected at least 2 pictures to train on, found {len(training)}. Add pictures to the folder.")
    views = config.optimiser.views_per_instance
    names, counts = np.unique(images.instances[training.numpy()], return_counts=True)
    if counts.min() < views:
        lacking = images.instance_names[names[counts.argmin()]]
        raise DataError(
            f"Expected {views} pictures or more of each object, found {counts.min()} of {lacking}. Name the objects in "
            "the column instance of metadata.csv, render more views, or train with --optimiser.views-per-instance 1."
        )
    lights = images.light_azimuths
    if config.model.light == "fixed" and config.loss.kind == "shading" and lights is not None and lights.any():
        raise DataError(
            "Expected lights that stand still (light_azimuth_degrees of 0 in metadata.csv) for a model of fixed light, "
            "found lights that are turned. Train with --model.light varying."
        )
    if config.loss.pose_supervision == "azimuth" and images.azimuths is None:
        raise DataError(
            "Pose supervision needs the column azimuth_degrees in metadata.csv, and the folder has none. Add it, "
            "name a training that has found the poses (--poses-of RUN), or train with --loss.pose-supervision none."
        )
