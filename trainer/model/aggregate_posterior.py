"""Where the shape codes of a class lie: a mixture of Gaussians in place of the prior, for inventing shapes.

Training asks each picture's posterior Q(z | x) to be near the prior N(0, I), not their mean over all pictures, the
aggregate posterior q(z) (Makhzani et al., 2015). Where q has little and the prior much, the decoder has learnt nothing,
and what is drawn from there is crumpled. So a density is fitted to q after the training, and shapes are drawn from
that (Ghosh et al., "From variational to deterministic autoencoders", 2020). Of the shapes of pictures, too, some are
crumpled where these do not show them; whoever knows which are doubtful leaves those out.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from trainer.errors import DataError

LEAST_PICTURES: Final = 40
MOST_PICTURES: Final = 1000
"""Of more pictures, so many at most, evenly chosen, tell where codes lie."""
ACTIVE_VARIANCE: Final = 0.01
"""Numbers whose posterior mean varies by less between pictures are as the prior has them (Burda et al., 2016)."""
COMPONENTS: Final = (1, 2, 3, 4, 6, 8, 12)
TRUSTED: Final = 0.75
"""Of all draws, where it is known how doubtful each is (docs/decisions.md)."""
_PICTURES_A_COMPONENT: Final = 10
_DRAWS, _FOLDS = 1600, 5
"""At least so many draws from all posteriors together."""
_LEAST_VARIANCE: Final = 1e-3


@dataclass(frozen=True)
class AggregatePosterior:
    """A mixture of K Gaussians over A of a shape code's numbers; the others have the prior."""

    numbers: tuple[int, ...]
    """Which numbers of the shape code, counted from 0, in order [A]."""
    weights: Float[ndarray, "K"]
    means: Float[ndarray, "K A"]
    factors: Float[ndarray, "K A A"]
    """Lower triangles: covariances are factor @ factor.T."""
    pictures: int
    """How many it was fitted to."""

    def codes(
        self, noise: Float[ndarray, "N Z"], shares: Float[ndarray, "N"], temperature: float = 1.0
    ) -> Float[ndarray, "N Z"]:
        """Shape codes from standard normal noise, and from numbers between 0 and 1 that choose the Gaussians; standard
        deviations are multiplied by `temperature`."""
        chosen = np.minimum(np.searchsorted(np.cumsum(self.weights), shares, "right"), len(self.weights) - 1)
        own = list(self.numbers)
        found = temperature * noise
        found[:, own] = self.means[chosen] + np.einsum("nab,nb->na", self.factors[chosen], found[:, own])
        return found


def fit_aggregate_posterior(
    means: Float[ndarray, "N Z"],
    deviations: Float[ndarray, "N Z"],
    doubts: Callable[[Float[ndarray, "M Z"]], Float[ndarray, "M"]] | None = None,
    seed: int = 0,
) -> AggregatePosterior:
    """The mixture that best tells the posteriors of pictures that it was not fitted to (five folds).

    Args:
        means, deviations: of the posteriors of N pictures.
        doubts: how doubtful the shapes of codes are; it is fitted to the TRUSTED share of all draws, those of which
            they are least so. Without it to all.
        seed: of the draws from them, and of the fit.

    Raises DataError for fewer than LEAST_PICTURES pictures.
    """
    # Takes as long to import as all else together, and few commands need it.
    from sklearn.mixture import GaussianMixture  # noqa: PLC0415
    from sklearn.model_selection import GridSearchCV, GroupKFold  # noqa: PLC0415

    pictures = len(means)
    if pictures < LEAST_PICTURES:
        raise DataError(
            f"Expected {LEAST_PICTURES} pictures at least to learn where shape codes lie, found {pictures}. Name a "
            "folder of more, or leave the option away: shapes are then drawn from the prior."
        )
    numbers = np.flatnonzero(means.var(0) > ACTIVE_VARIANCE)
    if not len(numbers):
        return AggregatePosterior((), np.ones(1), np.zeros((1, 0)), np.zeros((1, 0, 0)), pictures)
    draws = math.ceil(_DRAWS / pictures)
    noise = np.random.default_rng(seed).standard_normal((draws, pictures, means.shape[1]))
    codes = (means + deviations * noise).reshape(-1, means.shape[1])
    shown = np.tile(np.arange(pictures), draws)
    if doubts is not None:
        doubt = doubts(codes)
        trusted = doubt <= np.quantile(doubt, TRUSTED)
        codes, shown = codes[trusted], shown[trusted]
    drawn = codes[:, numbers]
    mixture = GaussianMixture(reg_covar=_LEAST_VARIANCE, max_iter=500, random_state=seed)
    most = max(1, pictures // _PICTURES_A_COMPONENT)
    choice = {"n_components": [count for count in COMPONENTS if count <= most]}
    search = GridSearchCV(mixture, choice, cv=GroupKFold(_FOLDS), error_score="raise")
    best = search.fit(drawn, groups=shown).best_estimator_
    chosen = tuple(int(number) for number in numbers)
    return AggregatePosterior(chosen, best.weights_, best.means_, np.linalg.cholesky(best.covariances_), pictures)
