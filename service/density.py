"""Where a model's shape codes lie, from which the service draws what no picture shows."""

from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import Field
from pydantic.dataclasses import dataclass

from service.fields import STRICT, Count, Index, Share

Number = Annotated[float, Field(ge=-1000, le=1000)]
Row = Annotated[tuple[Number, ...], Field(max_length=65536)]


@dataclass(frozen=True, config=STRICT)
class Gaussian:
    """One of a mixture, over A numbers of the shape code."""

    weight: Share
    mean: Row
    """[A]"""
    factor: Annotated[tuple[Row, ...], Field(max_length=65536)]
    """Lower triangle, row i of i + 1 numbers; the covariance is factor · factorᵀ."""


@dataclass(frozen=True, config=STRICT)
class AggregatePosterior:
    """A mixture of Gaussians for the shape codes of pictures of the class, fitted by the exporter; numbers of the code
    that are not in it have the prior, N(0, 1)."""

    numbers: Annotated[tuple[Index, ...], Field(max_length=65536)]
    """Which numbers of the shape code, counted from 0, in order [A]."""
    gaussians: Annotated[tuple[Gaussian, ...], Field(min_length=1, max_length=1024)]
    pictures: Count
    """How many it was fitted to."""

    def contradiction(self, latent: int) -> str | None:
        """What does not go together, in a bundle whose shape codes have `latent` numbers."""
        if sorted(set(self.numbers)) != list(self.numbers) or (self.numbers and self.numbers[-1] >= latent):
            return f"expected ascending numbers below {latent}, found {str(list(self.numbers))[:60]}"
        if abs(sum(one.weight for one in self.gaussians) - 1) > 1e-3:
            return "expected weights of Gaussians that add up to 1, found others"
        count = len(self.numbers)
        for one in self.gaussians:
            if len(one.mean) != count or [len(row) for row in one.factor] != list(range(1, count + 1)):
                return f"expected Gaussians of {count} numbers, found others"
        return None

    def code(self, noise: NDArray[np.float64], share: float, temperature: float) -> NDArray[np.float64]:
        """A shape code [Z] from standard normal noise [Z], and from a number between 0 and 1 that chooses the Gaussian;
        standard deviations are multiplied by `temperature`."""
        reached = np.cumsum([one.weight for one in self.gaussians])
        chosen = self.gaussians[min(int(np.searchsorted(reached, share, "right")), len(self.gaussians) - 1)]
        found = temperature * noise
        own = found[list(self.numbers)]
        for number, mean, row in zip(self.numbers, chosen.mean, chosen.factor, strict=True):
            found[number] = mean + np.dot(row, own[: len(row)])
        return found


def seeded_share(seed: int) -> float:
    """The number from 0 to 1 of a seed, which tells nothing of its noise (`inference.sample_shape_code`)."""
    return float(np.random.RandomState([seed, 1]).random_sample())
