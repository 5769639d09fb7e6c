"""The descent on pictures whose best explanation is known."""

from time import perf_counter

import numpy as np
import pytest

from imaging.refinement import FULL_PIXELS, PRIOR_WEIGHT, Guess, refine

HEIGHT, WIDTH, LATENT = 24, 32, 2
PRIOR = PRIOR_WEIGHT * HEIGHT * WIDTH / FULL_PIXELS


def blobs(codes: np.ndarray, azimuths: np.ndarray, lights: np.ndarray | None) -> np.ndarray:
    """A soft spot whose size is the code's first number and whose brightness is its second; the azimuth moves it along,
    and a dimmer one on the other side tells 180° apart. The light is its redness."""
    row, column = np.mgrid[:HEIGHT, :WIDTH] + 0.5
    pictures = np.zeros((len(codes), 3, HEIGHT, WIDTH))
    turned = np.zeros(len(codes)) if lights is None else lights
    for number, ((size, bright), azimuth, light) in enumerate(zip(codes, azimuths, turned, strict=True)):
        for sign, strength in ((1, 1.0), (-1, 0.4)):
            x = WIDTH / 2 + sign * 8 * np.sin(azimuth)
            y = HEIGHT / 2 + sign * 4 * np.cos(azimuth)
            distance = ((column - x) ** 2 + (row - y) ** 2) / (2 * (3 + size) ** 2)
            pictures[number] += strength * (0.6 + 0.2 * bright) * np.exp(-distance)
        pictures[number, 0] *= 1 + 0.5 * np.sin(light)
    return pictures.astype(np.float32)


def seen(code: tuple[float, float], azimuths: list[float], lights: list[float] | None = None) -> np.ndarray:
    return blobs(np.array([code] * len(azimuths)), np.array(azimuths), lights and np.array(lights))


def start(views: int = 1) -> Guess:
    return Guess(np.zeros(LATENT), np.zeros(views), None)


def test_shape_pose_and_light_are_found() -> None:
    pictures = seen((0.8, -0.5), [0.2], [0.3])
    found = refine(blobs, pictures, start()._replace(light_azimuths=np.zeros(1)), 20)
    assert found.energy_after < 0.05 * found.energy_before
    assert found.guess.azimuths == pytest.approx([0.2], abs=0.01)
    assert found.guess.light_azimuths == pytest.approx([0.3], abs=0.05)
    # The prior pulls the code towards 0, a little.
    assert found.guess.shape_code == pytest.approx([0.8, -0.5], abs=0.1)


def test_where_it_ends_nothing_near_is_better() -> None:
    pictures = seen((0.8, -0.5), [0.2])
    end = refine(blobs, pictures, start(), 30)

    def energy(guess: Guess) -> float:
        return refine(blobs, pictures, guess, 0).energy_before

    assert energy(end.guess) == end.energy_after
    for number in range(LATENT):
        for sign in (-1, 1):
            moved = end.guess.shape_code + sign * 0.1 * np.eye(LATENT)[number]
            assert energy(end.guess._replace(shape_code=moved)) > end.energy_after
    for sign in (-1, 1):
        assert energy(end.guess._replace(azimuths=end.guess.azimuths + sign * 0.02)) > end.energy_after


def test_the_prior_counts_as_in_training() -> None:
    """A picture that the prior's mean explains exactly: the energy elsewhere is β/2 ‖z‖² and what the drawing adds."""
    pictures = seen((0.0, 0.0), [0.0])
    assert refine(blobs, pictures, start(), 0).energy_before == pytest.approx(0, abs=1e-6)
    moved = Guess(np.array([1.0, 2.0]), np.zeros(1), None)

    def unmoved(codes: np.ndarray, azimuths: np.ndarray, lights: np.ndarray | None) -> np.ndarray:
        return blobs(0 * codes, azimuths, lights)

    assert refine(unmoved, pictures, moved, 0).energy_before == pytest.approx(PRIOR / 2 * 5, rel=1e-6)
    assert refine(unmoved, pictures, moved, 3).guess.shape_code == pytest.approx([0, 0], abs=0.05)


def test_several_pictures_share_their_shape() -> None:
    pictures = seen((0.6, 0.4), [0.2, -0.15, 0.1])
    found = refine(blobs, pictures, start(3), 20)
    assert found.guess.azimuths == pytest.approx([0.2, -0.15, 0.1], abs=0.01)
    assert found.guess.shape_code == pytest.approx([0.6, 0.4], abs=0.06)
    # A picture that says something else moves the one shape for all.
    other = np.concatenate((pictures, seen((-0.9, 0.4), [0.0])))
    assert refine(blobs, other, start(4), 20).guess.shape_code[0] < found.guess.shape_code[0] - 0.1


def test_no_time_and_no_iterations_leave_the_guess() -> None:
    pictures = seen((0.8, -0.5), [0.2])
    for iterations, seconds in ((0, None), (10, 0.0)):
        found = refine(blobs, pictures, start(), iterations, seconds)
        assert found.iterations == 0
        assert found.energy_after == found.energy_before
        np.testing.assert_array_equal(found.guess.shape_code, np.zeros(LATENT))


def test_it_ends_soon_after_its_time() -> None:
    began = perf_counter()
    found = refine(blobs, seen((0.8, -0.5), [0.2]), start(), 10**6, 0.05)
    assert found.iterations >= 1
    assert perf_counter() - began < 5


def test_the_energy_never_grows() -> None:
    random = np.random.default_rng(0)
    for _ in range(10):
        pictures = random.uniform(0, 1, (1, 3, HEIGHT, WIDTH)).astype(np.float32)
        guess = Guess(random.normal(size=LATENT), random.uniform(-3, 3, 1), None)
        found = refine(blobs, pictures, guess, 5)
        assert found.energy_after <= found.energy_before
