"""What a training refuses before it begins: settings that mean nothing, and pictures that they do not go with."""

import dataclasses
import re

from trainer.config import LossConfig, TrainConfig
from trainer.data.images import ImageSet
from trainer.errors import ConfigError, DataError
from trainer.training.intervals import Intervals

# What the bundle and the service accept as a class's name.
_CATEGORY = re.compile(r"[a-z0-9][a-z0-9_-]{0,63}")


def check_settings(config: TrainConfig) -> None:
    """Raises ConfigError for the first setting that is out of range; NaN is out of every range."""
    model, loss, optimiser = config.model, config.loss, config.optimiser
    channels = (min(model.encoder_channels), max(model.encoder_channels))
    ranges: list[tuple[str, float, float, float]] = [
        ("width", config.width, 16, 2048),
        ("height", config.height, 16, 2048),
        ("seed", config.seed, 0, 2**31 - 1),
        ("validation_share", config.validation_share, 0, 0.5),
        ("model.latent", model.latent, 1, 1024),
        ("model.hidden", model.hidden, 1, 4096),
        ("model.segments", model.segments, 1, 64),
        ("model.azimuth_bins", model.azimuth_bins, 1, 360),
        *(("model.encoder_channels", value, 1, 4096) for value in channels),
        ("optimiser.learning_rate", optimiser.learning_rate, 1e-12, 10),
        ("optimiser.gradient_clip", optimiser.gradient_clip, 1e-12, 1e12),
        ("optimiser.batch_size", optimiser.batch_size, 2, 65536),
        ("optimiser.steps", optimiser.steps, 1, 10**9),
        *_loss_ranges(loss),
    ]
    for name, value, low, high in ranges:
        if not low <= value <= high:
            raise ConfigError(
                f"Expected {name} from {low:g} to {high:g}, found {value}. Change the option or the preset."
            )


def _loss_ranges(loss: LossConfig) -> list[tuple[str, float, float, float]]:
    """Weights may be 0; what is divided by may not."""
    divisors = {
        "temperature",
        "temperature_start",
        "temperature_cooling_steps",
        "kl_cooling_steps",
        "encoder_prior_steps",
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
            "Name what the pictures show with --category."
        )


def check_pictures(config: TrainConfig, images: ImageSet, training: int) -> None:
    """Raises DataError where there are too few pictures to train on, or supervision is asked for without azimuths."""
    if training < 2:
        raise DataError(f"Expected at least 2 pictures to train on, found {training}. Add pictures to the folder.")
    if config.loss.pose_supervision == "azimuth" and images.azimuths is None:
        raise DataError(
            "Pose supervision needs the column azimuth_degrees in metadata.csv, and the folder has none. Add it, or "
            "train with --loss.pose-supervision none."
        )
