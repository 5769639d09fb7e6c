"""Does reported confidence foretell errors? Risk-coverage curves (Geifman & El-Yaniv, "Selective classification for
deep neural networks", NeurIPS 2017).

Answers are sorted by how far they are to be trusted. Coverage is the share that is given, the most trusted first; risk
is the mean loss of these. The area under the curve (AURC) lies between that of the ideal order, which knows the losses,
and that of a random one, which is the mean loss of all.
"""

from itertools import pairwise
from typing import Any

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from trainer.stability.answers import Answers

_COVERAGES = np.linspace(0.02, 1, 50)
CONFIDENCE_RANGES = (0.0, 0.5, 0.7, 0.8, 0.9, 0.95, 0.99, 1.0)


def trust_orders(told: Answers) -> dict[str, Float[ndarray, "N"]]:
    """How far each answer is to be trusted, by what is told of it; only the order counts.

    Combined, confidence is divided by 1 + the out-of-class score: where a picture is explained as badly as the worst
    one in twenty of the class, half of it is left.
    """
    return {
        "confidence": told.confidences,
        "score": -told.rerender_errors,
        "combined": told.confidences / (1 + told.scores),
    }


def risk_of(told: Answers, seed: int = 0) -> dict[str, Any]:
    """Curves and areas for both losses: azimuths wrong by more than 30°, and 1 − IoU."""
    losses = {"wrong_azimuth": told.wrong.astype(float), "one_minus_iou": 1 - told.overlaps}
    return {
        "pictures": len(told.errors),
        "coverage": [round(float(value), 4) for value in _COVERAGES],
        **{name: _risks(loss, told, seed) for name, loss in losses.items()},
    }


def _risks(loss: Float[ndarray, "N"], told: Answers, seed: int) -> dict[str, Any]:
    ideal, random = area(risks(loss, -loss, seed)), float(loss.mean())
    found: dict[str, Any] = {"aurc_ideal": round(ideal, 4), "aurc_random": round(random, 4)}
    for name, trust in trust_orders(told).items():
        by_count = risks(loss, trust, seed)
        found[f"aurc_{name}"] = round(area(by_count), 4)
        # Of the way from a random order to the ideal one.
        gained = (random - area(by_count)) / (random - ideal) if random > ideal else None
        found[f"gained_{name}"] = None if gained is None else round(gained, 4)
        found[f"risk_{name}"] = at_coverages(by_count)
    found["risk_ideal"] = at_coverages(risks(loss, -loss, seed))
    return found


def risks(loss: Float[ndarray, "N"], trust: Float[ndarray, "N"], seed: int) -> Float[ndarray, "N"]:
    """The mean loss of the 1, 2, … N most trusted answers; equally trusted ones come in a random order."""
    order = np.lexsort((np.random.default_rng(seed).permutation(len(loss)), -trust))
    return np.asarray(np.cumsum(loss[order]) / np.arange(1, len(loss) + 1))


def area(by_count: Float[ndarray, "N"]) -> float:
    """AURC of `risks`."""
    return float(by_count.mean())


def at_coverages(by_count: Float[ndarray, "N"]) -> list[float]:
    """The risk at each coverage that is reported."""
    counts = np.maximum(1, np.rint(_COVERAGES * len(by_count)).astype(int))
    return [round(float(value), 4) for value in by_count[counts - 1]]


def reliability_of(told: Answers) -> list[dict[str, Any]]:
    """How often answers of each range of confidence are right, and how many of the wrong ones would be refused."""
    edges, rows = CONFIDENCE_RANGES, []
    for low, high in pairwise(edges):
        within = (told.confidences >= low) & ((told.confidences < high) | (high == edges[-1]))
        part = told.of(within)
        if len(part.errors):
            rows.append(
                {
                    "confidence": [low, high],
                    "pictures": len(part.errors),
                    "mean_confidence": round(float(part.confidences.mean()), 4),
                    "right": round(float(1 - part.wrong.mean()), 4),
                    "wrong_and_refused": round(float((part.wrong & part.refused).mean()), 4),
                }
            )
    return rows
