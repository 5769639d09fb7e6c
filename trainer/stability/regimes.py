"""Trainings under adverse conditions: what differs from the usual one, in the settings or in the pictures."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Int
from numpy import ndarray
from numpy.random import Generator

from trainer.config import TrainConfig
from trainer.data.images import ImageSet


class Stock(NamedTuple):
    """Pictures that trainings choose from, one of each object."""

    cars: ImageSet
    chairs: ImageSet


@dataclass(frozen=True)
class Regime:
    """One kind of training."""

    name: str
    title: str
    settings: Callable[[TrainConfig], TrainConfig]
    pictures: Callable[[Stock, Generator], ImageSet]


def _batch(size: int) -> Callable[[TrainConfig], TrainConfig]:
    return lambda config: replace(config, optimiser=replace(config.optimiser, batch_size=size))


def _rate(factor: float) -> Callable[[TrainConfig], TrainConfig]:
    return lambda config: replace(
        config, optimiser=replace(config.optimiser, learning_rate=factor * config.optimiser.learning_rate)
    )


def _bfloat16(config: TrainConfig) -> TrainConfig:
    return replace(config, precision="bfloat16")


def _as_usual(config: TrainConfig) -> TrainConfig:
    return config


def _all(stock: Stock, rng: Generator) -> ImageSet:
    return stock.cars


def _few(count: int) -> Callable[[Stock, Generator], ImageSet]:
    return lambda stock, rng: chosen(stock.cars, rng.permutation(len(stock.cars))[:count])


def _copied(stock: Stock, rng: Generator) -> ImageSet:
    """As many pictures as usual, but one in twenty, twenty times; nothing tells that they show the same objects."""
    originals = rng.permutation(len(stock.cars))[: max(2, len(stock.cars) // 20)]
    return chosen(stock.cars, np.resize(originals, len(stock.cars)))


def _quarter(stock: Stock, rng: Generator) -> ImageSet:
    """Only those that look into the camera's quarter of the circle."""
    return chosen(stock.cars, np.flatnonzero(np.abs(_azimuths(stock.cars)) <= np.pi / 4))


def _leaning(stock: Stock, rng: Generator) -> ImageSet:
    """Azimuths from a von Mises distribution about the front with concentration 1: a front is 7 times as frequent as
    a back."""
    kept = rng.uniform(size=len(stock.cars)) < np.exp(np.cos(_azimuths(stock.cars)) - 1)
    return chosen(stock.cars, np.flatnonzero(kept))


def _mixed(stock: Stock, rng: Generator) -> ImageSet:
    """As many cars as chairs."""
    cars = chosen(stock.cars, np.arange(len(stock.chairs)))
    parts = cars, stock.chairs
    return replace(
        cars,
        pictures=np.concatenate([part.pictures for part in parts]),
        names=tuple(f"{number:06d}.png" for number in range(2 * len(cars))),
        instances=np.arange(2 * len(cars)),
        instance_names=tuple(f"{number:06d}" for number in range(2 * len(cars))),
        azimuths=np.concatenate([_azimuths(part) for part in parts]),
        light_azimuths=None,
    )


REGIMES = (
    Regime("usual", "as usual", _as_usual, _all),
    Regime("batch-8", "batches of 8", _batch(8), _all),
    Regime("batch-4", "batches of 4", _batch(4), _all),
    Regime("poses-lean", "fronts 7 times as frequent as backs", _as_usual, _leaning),
    Regime("poses-quarter", "azimuths within 45° of the front", _as_usual, _quarter),
    Regime("pictures-200", "200 pictures", _as_usual, _few(200)),
    Regime("pictures-50", "50 pictures", _as_usual, _few(50)),
    Regime("copies", "every picture 20 times", _as_usual, _copied),
    Regime("mixed", "as many chairs among the cars", _as_usual, _mixed),
    Regime("rate-tenth", "a tenth of the learning rate", _rate(0.1), _all),
    Regime("rate-10", "10 times the learning rate", _rate(10), _all),
    Regime("rate-100", "100 times the learning rate", _rate(100), _all),
    Regime("bfloat16", "convolutions in bfloat16", _bfloat16, _all),
)


def chosen(images: ImageSet, numbers: Int[ndarray, "M"]) -> ImageSet:
    """Some pictures of a set, each as one of an object of its own."""
    names = tuple(f"{place:06d}" for place in range(len(numbers)))
    return replace(
        images,
        pictures=images.pictures[numbers],
        names=tuple(f"{name}.png" for name in names),
        instances=np.arange(len(numbers)),
        instance_names=names,
        azimuths=_azimuths(images)[numbers],
        light_azimuths=None,
    )


def _azimuths(images: ImageSet) -> ndarray:
    assert images.azimuths is not None
    return images.azimuths
