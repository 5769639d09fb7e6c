"""What an answer says beside the mesh: the same words in a GLB's extras, in JSON and in headers.

Azimuths and lights are relative to the picture's camera: an azimuth of 0 shows the object's front, a light at azimuth 0
stands on the camera's side. Angles are degrees, colours linear RGB.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from service.inference import Posterior
from service.manifest import Manifest


@dataclass(frozen=True)
class CameraReport:
    """A perspective camera that looks at the origin; distance in diagonals of the object's bounding box."""

    elevation_degrees: float
    distance: float
    field_of_view_degrees: float
    aspect_ratio: float


@dataclass(frozen=True)
class LightReport:
    """A directional light; its azimuth is relative to the camera."""

    azimuth_degrees: float
    elevation_degrees: float
    colour: tuple[float, float, float]


@dataclass(frozen=True)
class BinReport:
    """A coarse bin of the azimuth."""

    azimuth_degrees: float
    probability: float


@dataclass(frozen=True)
class PosteriorReport:
    """What is known beyond the best guess: a coarse bin of the azimuth, a normal distribution around its centre, and
    how sure the shape code is."""

    azimuth_confidence: float
    """Probability of the most probable bin."""
    azimuth_bins: tuple[BinReport, ...]
    azimuth_entropy_nats: float
    """Entropy of the bins: 0 is certain, the logarithm of their number is no idea."""
    azimuth_fine_mean_degrees: float
    azimuth_fine_deviation_degrees: float
    shape_deviation: tuple[float, ...]
    """Standard deviation of each number of the shape code."""


@dataclass(frozen=True)
class Report:
    """What was found in a picture, or drawn from a seed."""

    category: str
    model: str
    """The model's identity: sha256 of its graphs."""
    azimuth_degrees: float
    """The object's turn about +Y in the picture, -180 to 180; the GLB's camera stands accordingly."""
    camera: CameraReport
    lights: tuple[LightReport, ...]
    ambient: tuple[float, float, float]
    shape_code: tuple[float, ...]
    posterior: PosteriorReport | None
    """For a picture only."""
    seed: int | None
    """For a sample only."""


def report_reconstruction(manifest: Manifest, posterior: Posterior) -> Report:
    """The report on a picture."""
    probabilities = posterior.azimuth_probabilities.astype(np.float64)
    positive = probabilities[probabilities > 0]
    bins = zip(manifest.azimuth_bin_centres_degrees, _numbers(probabilities), strict=True)
    evidence = PosteriorReport(
        azimuth_confidence=round(float(probabilities.max()), 7),
        azimuth_bins=tuple(BinReport(centre, probability) for centre, probability in bins),
        azimuth_entropy_nats=abs(round(float((positive * np.log(positive)).sum()), 6)),
        azimuth_fine_mean_degrees=round(math.degrees(posterior.azimuth_fine_mean), 4),
        azimuth_fine_deviation_degrees=round(math.degrees(posterior.azimuth_fine_deviation), 4),
        shape_deviation=_numbers(posterior.shape_deviation),
    )
    return _report(manifest, posterior.azimuth, posterior.shape_mean, evidence, None)


def report_sample(manifest: Manifest, seed: int, shape_code: NDArray[np.float32]) -> Report:
    """The report on a sample, which stands with its front to the camera."""
    return _report(manifest, 0.0, shape_code, None, seed)


def _report(
    manifest: Manifest,
    azimuth: float,
    shape_code: NDArray[np.float32],
    posterior: PosteriorReport | None,
    seed: int | None,
) -> Report:
    return Report(
        category=manifest.category,
        model=manifest.identity,
        azimuth_degrees=round(math.degrees(azimuth), 4),
        camera=CameraReport(
            elevation_degrees=manifest.camera.elevation_degrees,
            distance=manifest.camera.distance,
            field_of_view_degrees=manifest.camera.field_of_view_degrees,
            aspect_ratio=manifest.picture.width / manifest.picture.height,
        ),
        lights=tuple(
            LightReport(light.azimuth_degrees, light.elevation_degrees, light.colour) for light in manifest.lights
        ),
        ambient=manifest.ambient,
        shape_code=_numbers(shape_code),
        posterior=posterior,
        seed=seed,
    )


def _numbers(values: NDArray[np.floating]) -> tuple[float, ...]:
    return tuple(round(value, 7) for value in values.astype(np.float64).tolist())
