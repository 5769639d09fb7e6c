"""Analysis by synthesis: from a first guess at shape, pose and light to one whose drawing explains the pictures better.

What is minimised is the negative log posterior that training ends with, in units where ε = 1:

    E(z, θ, λ) = ½ Σ_l 4^l ‖K_l (I(z, θ, λ) − x)‖²  +  ½ β ‖z‖²,

summed over the pictures of an object, which share z. It is a sum of squares of about a dozen unknowns, so the steps
are those of Levenberg and Marquardt, whose Jacobian is had by drawing each unknown's neighbours: no derivative of a
renderer is needed, and whoever can draw can refine. The coarse pose that is followed downhill is the encoder's:
drawings of all of them do not tell better which is right.
"""

from collections.abc import Callable
from time import perf_counter
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from imaging.pyramid import pyramid

Array = NDArray[np.float32]
Floats = NDArray[np.float64]

Draw = Callable[[Floats, Floats, Floats | None], Array]
"""(shape codes [K, Z], azimuths [K], light azimuths [K] or None) → what is seen [K, 3, H, W]; angles in radians."""

PRIOR_WEIGHT: Final = 8.0
"""β for a picture of `FULL_PIXELS`; in proportion for others. The KL weight that the recipe ends with."""
FULL_PIXELS: Final = 128 * 96

CODE_STEP: Final = 0.5
"""How far a number of the shape code goes to see what it does; its prior's standard deviation is 1."""
ANGLE_STEP: Final = 0.1
"""Radians: about two pixels at the rim of a picture of 64 × 48."""
_FIRST_DAMPING: Final = 0.01
_ATTEMPTS: Final = 3
"""Steps tried from one place, each shorter than the one before."""
_ENOUGH: Final = 1e-3
"""A step that gains less than this share of E is the last."""


class Guess(NamedTuple):
    """One object as N pictures show it; angles in radians."""

    shape_code: Floats
    """[Z]"""
    azimuths: Floats
    """[N]"""
    light_azimuths: Floats | None
    """[N]; None where the light is fixed."""


class Refined(NamedTuple):
    """Where the descent ended, and what it gained."""

    guess: Guess
    energy_before: float
    energy_after: float
    iterations: int


def refine(draw: Draw, pictures: Array, guess: Guess, iterations: int, seconds: float | None = None) -> Refined:
    """The guess after at most so many iterations on pictures [N, 3, H, W], none of which begins after `seconds`.

    E never grows: the guess itself comes back where no step gains anything.
    """
    deadline = None if seconds is None else perf_counter() + seconds
    seen, prior = pyramid(pictures), PRIOR_WEIGHT * _share(pictures)
    place, damping, done = _flat(guess), _FIRST_DAMPING, 0
    before = energy = _energy(draw, seen, guess, prior)
    while done < iterations and (deadline is None or perf_counter() < deadline):
        curvature, downhill = _normal_equations(draw, seen, _unflat(place, guess), prior)
        done += 1
        for _ in range(_ATTEMPTS):
            damped = curvature + np.diag(damping * np.diag(curvature) + 1e-9)
            trial = place + np.linalg.solve(damped, downhill)
            found = _energy(draw, seen, _unflat(trial, guess), prior)
            if found < energy:
                break
            damping *= 10
        else:
            break
        gain, place, energy, damping = energy - found, trial, found, damping / 3
        if gain < _ENOUGH * energy:
            break
    return Refined(_unflat(place, guess), before, energy, done)


def _energy(draw: Draw, seen: Array, guess: Guess, prior: float) -> float:
    count = len(seen)
    codes = np.repeat(guess.shape_code[None], count, 0)
    drawn = pyramid(draw(codes, guess.azimuths, guess.light_azimuths))
    misfit = float(np.square(drawn - seen, dtype=np.float64).sum())
    length = float(np.square(guess.shape_code).sum())
    return 0.5 * misfit + 0.5 * prior * length


def _normal_equations(draw: Draw, seen: Array, guess: Guess, prior: float) -> tuple[Floats, Floats]:
    """(JᵀJ + prior [P, P], the negative gradient of E [P]) of the unknowns in the order of `_flat`."""
    count, latent = len(seen), len(guess.shape_code)
    angles = 1 if guess.light_azimuths is None else 2
    # Each picture's own unknowns: z, θ and, where it varies, λ.
    steps = np.concatenate((np.full(latent, CODE_STEP), np.full(angles, ANGLE_STEP)))
    moves = np.concatenate((np.zeros((1, len(steps))), np.diag(steps), -np.diag(steps)))
    shown = np.repeat(np.arange(count), len(moves))
    every = np.tile(moves, (count, 1))
    lights = None if guess.light_azimuths is None else guess.light_azimuths[shown] + every[:, latent + 1]
    drawn = pyramid(draw(guess.shape_code + every[:, :latent], guess.azimuths[shown] + every[:, latent], lights))
    drawn = drawn.reshape(count, len(moves), -1)
    curvature = np.diag(np.concatenate((np.full(latent, prior), np.zeros(angles * count))))
    downhill = np.concatenate((-prior * guess.shape_code, np.zeros(angles * count)))
    for number, views in enumerate(drawn):
        ahead, behind = views[1 : len(steps) + 1], views[len(steps) + 1 :]
        jacobian = (ahead - behind) / np.float32(2 * steps[:, None])
        own = np.concatenate((np.arange(latent), latent + number + count * np.arange(angles)))
        curvature[np.ix_(own, own)] += jacobian @ jacobian.T
        downhill[own] += jacobian @ (seen[number] - views[0])
    return curvature, downhill


def _flat(guess: Guess) -> Floats:
    angles = (guess.azimuths,) if guess.light_azimuths is None else (guess.azimuths, guess.light_azimuths)
    return np.concatenate((guess.shape_code, *angles))


def _unflat(place: Floats, like: Guess) -> Guess:
    latent, count = len(like.shape_code), len(like.azimuths)
    code, azimuths, lights = np.split(place, (latent, latent + count))
    return Guess(code, azimuths, None if like.light_azimuths is None else lights)


def _share(pictures: Array) -> float:
    height, width = pictures.shape[-2:]
    return float(height * width / FULL_PIXELS)
