"""How the weights of the loss, and the learning rates, change with the step."""

import math

from trainer.config import LossConfig, OptimiserConfig
from trainer.model.loss import PAPER_PIXELS, LossWeights


def cooled(start: float, end: float, time_constant: float, step: int) -> float:
    """Exponential approach from `start` to `end`; `time_constant` in steps."""
    return end + (start - end) * math.exp(-step / time_constant)


def weights_at(config: LossConfig, step: int, width: int, height: int) -> LossWeights:
    """The weights at a step, scaled to the number of pixels."""
    share = width * height / PAPER_PIXELS
    return LossWeights(
        kl=share * cooled(config.kl_weight_start, config.kl_weight, config.kl_cooling_steps, step),
        prior_matching=share * config.prior_matching_weight,
        temperature=share
        * cooled(config.temperature_start, config.temperature, config.temperature_cooling_steps, step),
        encoder_prior=cooled(0.0, config.encoder_prior, config.encoder_prior_steps, step),
        distillation=share * config.distillation_weight,
        laplacian=share * cooled(config.laplacian_weight_start, config.laplacian_weight, config.kl_cooling_steps, step),
        independence=share * config.independence_weight,
        moved=step < config.moved_steps,
        e_step_fine=step >= config.e_step_centred_steps,
        neighbours=config.neighbour_weight if step >= config.e_step_centred_steps else 0.0,
        inversion=share * config.inversion_weight,
        front_back=share * config.front_back_weight if step >= config.front_back_after else 0.0,
    )


def falling(config: OptimiserConfig, step: int) -> float:
    """What share of its learning rate a step has: 1, and half a cosine down to 0 over the last `falling_share`."""
    last = config.falling_share * config.steps
    left = config.steps - step
    return 1.0 if left >= last else 0.5 * (1 - math.cos(math.pi * left / last))
