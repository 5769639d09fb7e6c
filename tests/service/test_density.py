"""The density that samples are drawn from: as the trainer fits it, and refused where it makes no sense."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from service.density import AggregatePosterior, Gaussian, seeded_share
from service.errors import BundleError
from service.generation import sampled_code
from service.inference import Engine, sample_shape_code
from service.manifest import decode_manifest, encode_manifest
from trainer.model import aggregate_posterior as trained

GAUSSIANS = (
    Gaussian(weight=0.25, mean=(3.0, -1.0), factor=((0.5,), (0.2, 0.1))),
    Gaussian(weight=0.75, mean=(-3.0, 1.0), factor=((0.1,), (-0.2, 0.3))),
)
DENSITY = AggregatePosterior(numbers=(1, 2), gaussians=GAUSSIANS, pictures=60)


def test_codes_are_those_of_the_trainer() -> None:
    factors = np.array([[[0.5, 0], [0.2, 0.1]], [[0.1, 0], [-0.2, 0.3]]])
    other = trained.AggregatePosterior((1, 2), np.array([0.25, 0.75]), np.array([[3, -1], [-3, 1.0]]), factors, 60)
    random = np.random.default_rng(0)
    noise, shares = random.standard_normal((50, 4)), random.random(50)
    expected = other.codes(noise, shares, 0.7)
    found = [DENSITY.code(row, share, 0.7) for row, share in zip(noise, shares, strict=True)]
    np.testing.assert_allclose(found, expected, atol=1e-12)
    # The first Gaussian has a quarter of the shares, and the others nothing of its numbers.
    assert [np.sign(code[1]) for code in found] == [1 if share < 0.25 else -1 for share in shares]
    np.testing.assert_array_equal(np.array(found)[:, [0, 3]], 0.7 * noise[:, [0, 3]])


def test_seeds_are_drawn_from_it_where_a_bundle_has_one(engine: Engine) -> None:
    latent = engine.manifest.latent
    manifest = replace(engine.manifest, aggregate_posterior=DENSITY, parsimony=None)
    codes = np.array([sampled_code(manifest, seed, 1.0) for seed in range(400)])
    assert (codes[:, 1] > 0).mean() == pytest.approx(0.25, abs=0.06)
    np.testing.assert_allclose(np.abs(codes[:, 1]).mean(), 3, atol=0.1)
    assert (sampled_code(manifest, 7, 1.0) == codes[7]).all()
    np.testing.assert_allclose(codes[7, 3:], sample_shape_code(7, latent)[3:], atol=1e-6)
    coldest = {tuple(sampled_code(manifest, seed, 0.0)[1:3]) for seed in range(50)}
    assert coldest == {(3, -1), (-3, 1)}
    without = replace(manifest, aggregate_posterior=None)
    np.testing.assert_array_equal(sampled_code(without, 7, 0.5), 0.5 * sample_shape_code(7, latent))


def test_what_chooses_the_gaussian_tells_nothing_of_the_noise() -> None:
    shares = np.array([seeded_share(seed) for seed in range(2000)])
    noise = np.array([sample_shape_code(seed, 3) for seed in range(2000)])
    assert shares.mean() == pytest.approx(0.5, abs=0.03)
    assert np.abs(np.corrcoef(np.c_[shares, noise].T)[0, 1:]).max() < 0.08


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"numbers": (2, 1)}, "expected ascending numbers below"),
        ({"numbers": (1, 9999)}, "expected ascending numbers below"),
        ({"numbers": (1,)}, "expected Gaussians of 1 numbers"),
        ({"gaussians": GAUSSIANS[:1]}, "expected weights of Gaussians that add up to 1"),
        (
            {"gaussians": (replace(GAUSSIANS[0], weight=1.0, factor=((0.5, 0.0), (0.2, 0.1))),)},
            "expected Gaussians of 2 numbers",
        ),
    ],
)
def test_what_contradicts_itself_is_refused(engine: Engine, change: dict[str, Any], sentence: str) -> None:
    manifest = replace(engine.manifest, aggregate_posterior=replace(DENSITY, **change))
    with pytest.raises(BundleError, match=f"car: aggregate_posterior: {sentence}.*; export the bundle again"):
        decode_manifest(encode_manifest(manifest), "car")
    whole = replace(engine.manifest, aggregate_posterior=DENSITY)
    assert decode_manifest(encode_manifest(whole), "car") == whole
