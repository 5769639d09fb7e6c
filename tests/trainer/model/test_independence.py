"""What shape codes tell of poses, against its formula, on codes that do and do not, and its gradient."""

import math

import numpy as np
import pytest
import torch

from trainer.model.loss import balanced_posterior, pose_in_code

BATCH, BINS, LATENT = 7, 12, 5


def responsibility() -> torch.Tensor:
    """The E-step's posterior of a batch, by likelihoods that random numbers make up."""
    evidence = torch.tensor(np.random.default_rng(2).uniform(-90, -10, size=(BATCH, BINS)))
    return balanced_posterior(evidence / 4, 3)


@pytest.mark.parametrize("told", [0.0, 5.0])
def test_what_codes_tell_of_poses_is_the_mean_over_pairs_of_pictures(told: float) -> None:
    q = responsibility()
    angles = 2 * math.pi / BINS * np.arange(BINS) - math.pi
    code = np.random.default_rng(9).normal(size=(BATCH, LATENT)) + told * (q.numpy() @ np.cos(angles))[:, None]
    pairs = 0.0
    for harmonic in (np.cos(angles), np.sin(angles), np.cos(2 * angles), np.sin(2 * angles)):
        moments = code * (q.numpy() @ harmonic)[:, None]
        pairs += sum(moments[i] @ moments[j] for i in range(BATCH) for j in range(BATCH) if i != j)
    expected = max(0.0, pairs / (BATCH * (BATCH - 1)))
    assert (expected > 0) == (told > 0)
    assert pose_in_code(torch.tensor(code), q).item() == pytest.approx(expected, rel=1e-10)


def test_codes_that_tell_of_poses_are_found_out_and_others_are_not() -> None:
    random = np.random.default_rng(7)
    bins = random.integers(BINS, size=4000)
    known = torch.eye(BINS, dtype=torch.float64)[bins]
    free = torch.tensor(random.normal(size=(4000, 2)))
    side = torch.tensor(np.cos(2 * 2 * math.pi / BINS * bins))[:, None]
    assert abs(pose_in_code(free, known).item()) < 2e-3
    # E[cos² 2θ]² = 1/4.
    assert pose_in_code(free + side * torch.tensor([0.0, 1.0]), known).item() == pytest.approx(0.25, abs=0.03)
    # Of few pictures, squares of covariances are mostly chance, 2 dimensions · 4 harmonics · ½ / 8: most of it is taken
    # off, and never more than there is.
    few = [pose_in_code(free[i : i + 8], known[i : i + 8]).item() for i in range(0, 4000, 8)]
    assert min(few) == 0
    assert np.mean(few) < 0.4 * 2 * 4 * 0.5 / 8
    assert pose_in_code(free[:1], known[:1]).item() == 0


def test_its_gradient_is_that_of_central_differences() -> None:
    q = responsibility()
    angles = 2 * math.pi / BINS * torch.arange(BINS, dtype=torch.float64) - math.pi
    telling = torch.tensor(np.random.default_rng(9).normal(size=(BATCH, LATENT))) + 5 * (q @ angles.cos())[:, None]
    assert pose_in_code(telling, q).item() > 0
    assert torch.autograd.gradcheck(pose_in_code, (telling.requires_grad_(), q))
