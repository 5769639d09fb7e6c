"""The weights of the loss at a step, against their formulas written out."""

import math

import pytest

from trainer.config import LossConfig, OptimiserConfig
from trainer.training.schedule import falling, weights_at

CONFIG = LossConfig(
    kl_weight=3.0,
    kl_weight_start=50.0,
    kl_cooling_steps=200.0,
    laplacian_weight=7.0,
    laplacian_weight_start=900.0,
    temperature=20.0,
    temperature_start=240.0,
    temperature_cooling_steps=80.0,
    encoder_prior=0.8,
    encoder_prior_steps=500.0,
    prior_matching_weight=450.0,
    distillation_weight=60.0,
    independence_weight=40.0,
    inversion_weight=8.0,
    front_back_weight=9.0,
)


@pytest.mark.parametrize("step", [0, 1, 80, 500])
def test_weights_cool_exponentially(step: int) -> None:
    found = weights_at(CONFIG, step, 128, 96)
    assert found.kl == pytest.approx(3 + 47 * math.exp(-step / 200))
    assert found.laplacian == pytest.approx(7 + 893 * math.exp(-step / 200))
    assert found.temperature == pytest.approx(20 + 220 * math.exp(-step / 80))
    assert found.encoder_prior == pytest.approx(0.8 * (1 - math.exp(-step / 500)))
    assert (found.prior_matching, found.distillation, found.independence) == (450, 60, 40)
    assert (found.inversion, found.front_back) == (8, 9)


def test_they_begin_and_end_where_the_settings_say() -> None:
    first, last = weights_at(CONFIG, 0, 128, 96), weights_at(CONFIG, 10**6, 128, 96)
    assert (first.kl, first.laplacian, first.temperature, first.encoder_prior) == (50, 900, 240, 0)
    assert (last.kl, last.laplacian, last.temperature, last.encoder_prior) == (3, 7, 20, 0.8)


def test_poses_are_compared_at_the_fine_angle_once_bins_are_told_apart() -> None:
    config = LossConfig(e_step_centred_steps=300)
    assert [weights_at(config, step, 64, 48).e_step_fine for step in (0, 299, 300)] == [False, False, True]


def test_unlike_sides_weigh_once_what_they_tell_is_learnt() -> None:
    config = LossConfig(front_back_weight=8.0, front_back_after=400)
    assert [weights_at(config, step, 64, 48).front_back for step in (0, 399, 400)] == [0, 0, 2]


def test_what_weighs_sums_over_pixels_grows_with_their_number() -> None:
    """A quarter of the pixels makes a quarter of the log-likelihood. The encoder's ρ is a probability at any size."""
    whole, quarter = weights_at(CONFIG, 100, 128, 96), weights_at(CONFIG, 100, 64, 48)
    assert quarter.encoder_prior == whole.encoder_prior
    assert quarter == pytest.approx(
        [value / 4 for value in whole[:3]] + [whole[3]] + [value / 4 for value in whole[4:]]
    )


def test_learning_rates_fall_along_half_a_cosine_at_the_end() -> None:
    config = OptimiserConfig(steps=1000, falling_share=0.4)
    assert [falling(config, step) for step in (0, 600)] == [1, 1]
    assert falling(config, 700) == pytest.approx(0.5 * (1 + math.cos(math.pi / 4)))
    assert falling(config, 800) == pytest.approx(0.5)
    assert 0 < falling(config, 999) < 1e-4
    assert falling(OptimiserConfig(steps=1000), 999) == 1
    assert falling(OptimiserConfig(steps=1000, falling_share=1), 500) == pytest.approx(0.5)
