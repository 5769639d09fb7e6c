"""Each regime changes what it says of a training, and nothing else."""

from dataclasses import replace

import numpy as np
import pytest

from trainer.config import SceneConfig, TrainConfig
from trainer.data.images import ImageSet
from trainer.stability.regimes import REGIMES, Regime, Stock
from trainer.training.checks import check_settings

COUNT = 400


def stock_of(seed: int, count: int) -> ImageSet:
    rng = np.random.default_rng(seed)
    return ImageSet(
        pictures=rng.integers(0, 256, (count, 3, 2, 2), np.uint8),
        names=tuple(f"{number}.png" for number in range(count)),
        instances=np.arange(count),
        instance_names=tuple(map(str, range(count))),
        azimuths=rng.uniform(-np.pi, np.pi, count),
        light_azimuths=np.zeros(count),
        scene=SceneConfig(2, 2),
        skipped=(),
    )


@pytest.fixture(scope="module")
def stock() -> Stock:
    return Stock(stock_of(0, COUNT), stock_of(1, COUNT // 2))


@pytest.mark.parametrize("regime", REGIMES, ids=lambda regime: regime.name)
def test_settings_and_pictures_are_sound(regime: Regime, stock: Stock) -> None:
    check_settings(regime.settings(TrainConfig()))
    images = regime.pictures(stock, np.random.default_rng(0))
    assert len(images) == len(images.pictures) == len(set(images.names)) >= 2
    assert len(set(images.instances)) == len(images.instance_names) == len(images)


def test_only_one_thing_changes() -> None:
    usual = TrainConfig()
    changed = {regime.name: regime.settings(usual) for regime in REGIMES}
    optimisers = {name: replace(config.optimiser, steps=1) for name, config in changed.items()}
    assert optimisers["batch-4"] == replace(optimisers["usual"], batch_size=4)
    assert optimisers["rate-100"].learning_rate == pytest.approx(100 * usual.optimiser.learning_rate)
    assert replace(changed["bfloat16"], precision="auto") == usual
    for name in ("usual", "poses-lean", "poses-quarter", "pictures-50", "copies", "mixed"):
        assert changed[name] == usual


def test_pictures_are_chosen_as_named(stock: Stock) -> None:
    chosen = {regime.name: regime.pictures(stock, np.random.default_rng(0)) for regime in REGIMES}
    assert len(chosen["pictures-50"]) == 50
    assert np.abs(chosen["poses-quarter"].azimuths).max() <= np.pi / 4
    assert len(chosen["poses-quarter"]) == pytest.approx(COUNT / 4, rel=0.3)
    lean = np.cos(chosen["poses-lean"].azimuths)
    assert (lean > 0.7).sum() > 3 * (lean < -0.7).sum() > 0
    assert len(np.unique(chosen["copies"].pictures, axis=0)) == COUNT // 20
    assert len(chosen["copies"]) == COUNT
    mixed = chosen["mixed"]
    assert np.array_equal(mixed.pictures[: COUNT // 2], stock.cars.pictures[: COUNT // 2])
    assert np.array_equal(mixed.pictures[COUNT // 2 :], stock.chairs.pictures)
