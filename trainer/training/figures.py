"""What the journal keeps of a step."""

import torch
from jaxtyping import Float
from torch import Tensor

from trainer import processes
from trainer.model.posterior import shape_divergence
from trainer.training.step import StepResult


def figures_of(result: StepResult, gradient_norm: float) -> dict[str, float]:
    """Loss terms, and what tells a healthy training from a collapsed one.

    Entropies are in nats; `active_dimensions` counts those of the shape code above 0.1 nats. All are those of the whole
    batch where processes train together.
    """
    with torch.no_grad():
        rho = processes.whole(result.posterior.azimuth_logits).softmax(1)
        by_dimension = processes.mean(shape_divergence(result.posterior).mean(0))
        terms = processes.mean(torch.stack([value.detach() for value in result.terms]))
        figures = dict(zip(result.terms._fields, terms.tolist(), strict=True))
        light = result.posterior.light
        if light is not None:
            bins = processes.whole(light.logits).softmax(1)
            figures["light_entropy"] = float(_entropy(bins).mean())
            figures["aggregate_light_entropy"] = float(_entropy(bins.mean(0)))
        return figures | {
            "loss": float(terms.sum()),
            "gradient_norm": gradient_norm,
            "expected_log_likelihood": float(processes.mean(result.expected_log_likelihood.mean())),
            "shape_nats": float(by_dimension.sum()),
            "active_dimensions": float((by_dimension > 0.1).sum()),
            "azimuth_entropy": float(_entropy(rho).mean()),
            "aggregate_azimuth_entropy": float(_entropy(rho.mean(0))),
        }


def _entropy(probabilities: Float[Tensor, "*B R"]) -> Float[Tensor, "*B"]:
    entropy: Tensor = torch.special.entr(probabilities).sum(-1)
    return entropy
