"""Every term of Eq. loss against a plain numpy transcription, and the E-step's guarantees."""

import math

import numpy as np
import pytest
import torch

from trainer.model.loss import (
    LossWeights,
    balanced_posterior,
    distillation,
    nearest_bin,
    prior_matching,
    training_loss,
)
from trainer.model.posterior import (
    LightPosterior,
    Posterior,
    azimuth_fine_divergence,
    bin_centres,
    divergence_between,
    light_bin_centres,
    light_fine_divergence,
    most_probable_azimuth,
    most_probable_light,
    pooled_over_views,
    shape_divergence,
)

BATCH, BINS, LIGHT_BINS, LATENT, VERTICES = 7, 12, 3, 5, 9
WEIGHTS = LossWeights(
    kl=1.3,
    prior_matching=17.0,
    temperature=4.0,
    encoder_prior=0.0,
    distillation=2.5,
    laplacian=3.0,
    independence=7.0,
    neighbours=0.6,
    inversion=5.0,
    front_back=4.0,
)


@pytest.fixture
def posterior() -> Posterior:
    rng = np.random.default_rng(1)
    return Posterior(
        torch.tensor(rng.normal(size=(BATCH, LATENT))),
        torch.tensor(rng.uniform(0.1, 2, size=(BATCH, LATENT))),
        torch.tensor(rng.normal(size=(BATCH, BINS))),
        torch.tensor(rng.uniform(-math.pi / BINS, math.pi / BINS, size=BATCH)),
        torch.tensor(rng.uniform(0.01, 0.3, size=BATCH)),
    )


@pytest.fixture
def varying(posterior: Posterior) -> Posterior:
    """The same, and a light that varies."""
    rng, half = np.random.default_rng(7), math.pi / (2 * LIGHT_BINS)
    light = LightPosterior(
        torch.tensor(rng.normal(size=(BATCH, LIGHT_BINS))),
        torch.tensor(rng.uniform(-half, half, size=BATCH)),
        torch.tensor(rng.uniform(0.01, 0.6, size=BATCH)),
    )
    return posterior._replace(light=light)


@pytest.fixture
def log_likelihood() -> torch.Tensor:
    return torch.tensor(np.random.default_rng(2).uniform(-90, -10, size=(BATCH, BINS)))


@pytest.fixture
def laplacian() -> torch.Tensor:
    return torch.tensor(np.random.default_rng(3).normal(size=(BATCH, VERTICES, 3)))


def _softmax(logits: np.ndarray) -> np.ndarray:
    exponential = np.exp(logits - logits.max(1, keepdims=True))
    return exponential / exponential.sum(1, keepdims=True)


def _normal_divergence(mean: np.ndarray, deviation: np.ndarray, prior: float) -> np.ndarray:
    return np.log(prior / deviation) + (deviation**2 + mean**2) / (2 * prior**2) - 0.5


def test_the_paper_s_loss_is_the_sum_that_the_paper_writes(
    posterior: Posterior, log_likelihood: torch.Tensor, laplacian: torch.Tensor
) -> None:
    weighed = (log_likelihood * posterior.azimuth_logits.softmax(1)).sum(1)
    terms = training_loss(WEIGHTS, weighed, posterior, laplacian, None)
    rho = _softmax(posterior.azimuth_logits.numpy())
    expected = 0.0
    for r in range(BINS):
        expected -= np.mean([log_likelihood[i, r].item() * rho[i, r] for i in range(BATCH)])
        expected += WEIGHTS.prior_matching * abs(np.mean(rho[:, r]) - 1 / BINS)
    shape = _normal_divergence(posterior.shape_mean.numpy(), posterior.shape_deviation.numpy(), 1.0)
    fine = _normal_divergence(
        posterior.azimuth_fine_mean.numpy(), posterior.azimuth_fine_deviation.numpy(), math.pi / BINS
    )
    expected += WEIGHTS.kl * np.mean(shape.sum(1) + fine)
    expected += WEIGHTS.laplacian * np.mean((laplacian.numpy() ** 2).sum((1, 2)))
    assert terms.total().item() == pytest.approx(expected, rel=1e-12)
    assert terms.distillation.item() == 0
    assert min(terms.prior_matching.item(), terms.kl.item(), terms.laplacian.item()) > 0


def test_the_exact_objective_teaches_the_encoder_the_balanced_posterior(
    posterior: Posterior, log_likelihood: torch.Tensor, laplacian: torch.Tensor
) -> None:
    responsibility = balanced_posterior(log_likelihood / WEIGHTS.temperature, 3)
    q = _softmax(log_likelihood.numpy() / WEIGHTS.temperature)
    for _ in range(3):
        q = q / q.sum(0, keepdims=True)
        q = q / q.sum(1, keepdims=True)
    np.testing.assert_allclose(responsibility, q, rtol=1e-10)
    terms = training_loss(WEIGHTS, (log_likelihood * responsibility).sum(1), posterior, laplacian, responsibility)
    assert terms.reconstruction.item() == pytest.approx(-(q * log_likelihood.numpy()).sum(1).mean(), rel=1e-10)
    cross_entropy = -(q * np.log(_softmax(posterior.azimuth_logits.numpy()))).sum(1).mean()
    assert terms.distillation.item() == pytest.approx(WEIGHTS.distillation * cross_entropy, rel=1e-10)
    assert terms.prior_matching.item() == 0


def test_what_neighbours_explain_is_weighed_and_added(
    posterior: Posterior, log_likelihood: torch.Tensor, laplacian: torch.Tensor
) -> None:
    asked = posterior, laplacian, None, None
    alone = training_loss(WEIGHTS, log_likelihood[:, 0], *asked)
    terms = training_loss(WEIGHTS, log_likelihood[:, 0], *asked, log_likelihood[:, 1])
    assert alone.neighbours.item() == 0
    assert terms.neighbours.item() == pytest.approx(-0.6 * np.mean(log_likelihood.numpy()[:, 1]))
    assert terms.total().item() == pytest.approx(alone.total().item() + terms.neighbours.item())


def test_what_is_inside_out_is_weighed_and_added(
    posterior: Posterior, log_likelihood: torch.Tensor, laplacian: torch.Tensor
) -> None:
    asked = posterior, laplacian, None, None, None
    alone = training_loss(WEIGHTS, log_likelihood[:, 0], *asked)
    terms = training_loss(WEIGHTS, log_likelihood[:, 0], *asked, torch.tensor([0.1, 0.0, 0.5]))
    assert alone.inversion.item() == 0
    assert terms.inversion.item() == pytest.approx(5 * 0.2)
    assert terms.total().item() == pytest.approx(alone.total().item() + 1.0)


def test_how_unlike_front_and_back_are_is_weighed_and_added(
    posterior: Posterior, log_likelihood: torch.Tensor, laplacian: torch.Tensor
) -> None:
    asked = posterior, laplacian, None, None, None, None
    alone = training_loss(WEIGHTS, log_likelihood[:, 0], *asked)
    terms = training_loss(WEIGHTS, log_likelihood[:, 0], *asked, torch.tensor([0.1, 0.0, 0.5]))
    assert alone.front_back.item() == 0
    assert terms.front_back.item() == pytest.approx(4 * 0.2)
    assert terms.total().item() == pytest.approx(alone.total().item() + 0.8)


def test_varying_light_adds_its_own_terms_as_the_paper_writes_them(
    varying: Posterior, log_likelihood: torch.Tensor, laplacian: torch.Tensor
) -> None:
    light = varying.light
    assert light is not None
    fixed = training_loss(WEIGHTS, log_likelihood[:, 0], varying._replace(light=None), laplacian, None)
    terms = training_loss(WEIGHTS, log_likelihood[:, 0], varying, laplacian, None)
    rho = _softmax(light.logits.numpy())
    matching = sum(abs(np.mean(rho[:, r]) - 1 / LIGHT_BINS) for r in range(LIGHT_BINS))
    assert (terms.prior_matching - fixed.prior_matching).item() == pytest.approx(WEIGHTS.prior_matching * matching)
    half = math.pi / (2 * LIGHT_BINS)
    fine = _normal_divergence(light.fine_mean.numpy(), light.fine_deviation.numpy(), half).mean()
    assert (terms.kl - fixed.kl).item() == pytest.approx(WEIGHTS.kl * fine)
    assert (terms.reconstruction, terms.laplacian, terms.distillation.item()) == (
        fixed.reconstruction,
        fixed.laplacian,
        0,
    )


def test_the_e_step_over_pairs_of_bins_balances_both_angles_and_teaches_each(
    varying: Posterior, laplacian: torch.Tensor
) -> None:
    light = varying.light
    assert light is not None
    values = np.random.default_rng(8).uniform(-90, -10, size=(BATCH, BINS, LIGHT_BINS))
    joint = balanced_posterior(torch.tensor(values / 9.0), 4)
    q = np.exp(values / 9.0)
    q /= q.sum((1, 2), keepdims=True)
    for _ in range(4):
        for others in ((0, 2), (0, 1)):
            q /= q.sum(others, keepdims=True)
            q /= q.sum((1, 2), keepdims=True)
    np.testing.assert_allclose(joint, q, rtol=1e-9)
    terms = training_loss(
        WEIGHTS, (joint * torch.tensor(values)).sum((1, 2)), varying, laplacian, joint.sum(2), joint.sum(1)
    )
    entropies = [
        -(q.sum(axis) * np.log(_softmax(logits.numpy()))).sum(1).mean()
        for axis, logits in ((2, varying.azimuth_logits), (1, light.logits))
    ]
    assert terms.distillation.item() == pytest.approx(WEIGHTS.distillation * sum(entropies), rel=1e-10)
    assert terms.prior_matching.item() == 0
    even = balanced_posterior(torch.tensor(np.random.default_rng(9).normal(size=(300, BINS, LIGHT_BINS)) * 3), 60)
    np.testing.assert_allclose(even.sum(2).mean(0), 1 / BINS, atol=1e-3)
    np.testing.assert_allclose(even.sum(1).mean(0), 1 / LIGHT_BINS, atol=1e-3)


def test_a_known_azimuth_leaves_the_light_to_be_matched(
    varying: Posterior, log_likelihood: torch.Tensor, laplacian: torch.Tensor
) -> None:
    known = nearest_bin(torch.zeros(BATCH, dtype=torch.float64), BINS)
    terms = training_loss(WEIGHTS, log_likelihood[:, 0], varying, laplacian, known)
    assert min(terms.distillation.item(), terms.prior_matching.item()) > 0


def test_blocks_have_no_laplacian_term(posterior: Posterior, log_likelihood: torch.Tensor) -> None:
    assert training_loss(WEIGHTS, log_likelihood[:, 0], posterior, None, None).laplacian.item() == 0


def test_several_views_have_the_largest_mean_and_deviation_in_common(varying: Posterior) -> None:
    six = Posterior(*(part[:6] for part in varying[:5]))
    pooled = pooled_over_views(six, 3)
    for found, each in ((pooled.shape_mean, six.shape_mean), (pooled.shape_deviation, six.shape_deviation)):
        largest = each.numpy().reshape(2, 3, LATENT).max(1)
        np.testing.assert_array_equal(found, np.repeat(largest, 3, 0))
    assert pooled[2:] == six[2:]
    assert pooled_over_views(six, 1) is six


def test_bins_of_the_light_cover_half_a_turn_evenly(varying: Posterior) -> None:
    light = varying.light
    assert light is not None
    centres = light_bin_centres(LIGHT_BINS, torch.zeros(1, dtype=torch.float64))
    np.testing.assert_allclose(np.degrees(centres.numpy()), [30, 90, 150])
    found = most_probable_light(varying)
    assert found is not None
    np.testing.assert_allclose(found, centres[light.logits.argmax(1)] + light.fine_mean)
    assert ((found >= 0) & (found <= math.pi)).all()
    assert most_probable_light(varying._replace(light=None)) is None
    prior = LightPosterior(torch.zeros(1, 3), torch.zeros(1), torch.full((1,), math.pi / 6))
    assert light_fine_divergence(prior).item() == pytest.approx(0, abs=1e-6)


def test_a_known_azimuth_selects_the_nearest_bin() -> None:
    azimuth = torch.tensor(np.random.default_rng(4).uniform(-math.pi, math.pi, size=200))
    index = np.round((azimuth.numpy() + math.pi) / (2 * math.pi / BINS)).astype(int) % BINS
    np.testing.assert_array_equal(nearest_bin(azimuth, BINS), np.eye(BINS)[index])


def test_gradients_of_the_loss_are_those_of_central_differences(
    posterior: Posterior, log_likelihood: torch.Tensor, laplacian: torch.Tensor
) -> None:
    def total(*parts: torch.Tensor) -> torch.Tensor:
        return training_loss(WEIGHTS, parts[5], Posterior(*parts[:5]), parts[6], None).total()

    inputs = [part.clone().requires_grad_() for part in (*posterior[:5], log_likelihood[:, 0], laplacian)]
    assert torch.autograd.gradcheck(total, inputs)


def test_the_e_step_is_a_distribution_that_uses_all_bins_alike() -> None:
    values = torch.tensor(np.random.default_rng(5).normal(size=(400, BINS)) * 3)
    values[:, 4] += 10  # a bin that would win nearly every picture
    q = balanced_posterior(values, 60)
    np.testing.assert_allclose(q.sum(1), 1, atol=1e-12)
    np.testing.assert_allclose(q.mean(0), 1 / BINS, atol=1e-3)
    np.testing.assert_allclose(balanced_posterior(values, 0), values.softmax(1))


def test_the_e_step_survives_any_temperature() -> None:
    values = torch.tensor([[-1e5, -2e5], [-3e5, -1e5]])
    for temperature in (1e-3, 1.0, 1e9):
        assert torch.isfinite(balanced_posterior(values / temperature, 5)).all()


def test_teaching_is_least_where_the_encoder_agrees() -> None:
    q = torch.tensor(np.random.default_rng(6).dirichlet(np.ones(BINS), size=BATCH))
    logits = q.log().requires_grad_()
    distillation(logits, q).backward()
    assert logits.grad is not None
    np.testing.assert_allclose(logits.grad, 0, atol=1e-12)


def test_prior_matching_is_zero_for_an_even_batch_and_largest_for_one_pose() -> None:
    assert prior_matching(torch.eye(BINS)).item() == pytest.approx(0, abs=1e-6)
    assert prior_matching(torch.eye(BINS)[:1]).item() == pytest.approx(2 * (1 - 1 / BINS))


def test_divergences_vanish_at_the_prior_and_match_a_monte_carlo_estimate(posterior: Posterior) -> None:
    half = math.pi / BINS
    prior = Posterior(torch.zeros(2, 3), torch.ones(2, 3), torch.zeros(2, BINS), torch.zeros(2), torch.full((2,), half))
    assert shape_divergence(prior).abs().max() < 1e-6
    assert azimuth_fine_divergence(prior).abs().max() < 1e-6
    q = torch.distributions.Normal(posterior.shape_mean[0], posterior.shape_deviation[0])
    samples = q.sample((200_000,))
    estimate = (q.log_prob(samples) - torch.distributions.Normal(0.0, 1.0).log_prob(samples)).mean(0)
    np.testing.assert_allclose(shape_divergence(posterior)[0], estimate, atol=0.02)


def test_the_divergence_between_posteriors_is_that_of_their_distributions(varying: Posterior) -> None:
    def others(parts: tuple[torch.Tensor, ...]) -> list[torch.Tensor]:
        return [part.roll(1, 0) for part in parts]

    light = varying.light
    assert light is not None
    learnt = Posterior(*others(varying[:5]), LightPosterior(*others(light)))
    between, normal = torch.distributions.kl_divergence, torch.distributions.Normal
    expected = between(normal(*varying[:2]), normal(*learnt[:2])).sum(1)
    for logits, mean, deviation in (varying[2:5], light):
        one, other = (torch.distributions.Categorical(logits=part) for part in (logits, logits.roll(1, 0)))
        expected += between(one, other) + between(normal(mean, deviation), normal(*others((mean, deviation))))
    np.testing.assert_allclose(divergence_between(varying, learnt), expected, rtol=1e-9)
    assert divergence_between(varying, varying).abs().max() < 1e-12
    assert (divergence_between(varying._replace(light=None), learnt._replace(light=None)) < expected).all()


def test_bins_cover_the_circle_as_equation_8_says(posterior: Posterior) -> None:
    centres = bin_centres(BINS, torch.zeros(1, dtype=torch.float64))
    np.testing.assert_allclose(centres, [-math.pi + r * 2 * math.pi / BINS for r in range(BINS)])
    azimuth = most_probable_azimuth(posterior)
    best = posterior.azimuth_logits.argmax(1)
    np.testing.assert_allclose(torch.cos(azimuth - centres[best] - posterior.azimuth_fine_mean), 1, atol=1e-12)
    assert (azimuth >= -math.pi).all()
    assert (azimuth < math.pi).all()
