"""From what the graphs returned to the report that says it."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from service.inference import LightPosterior, Posterior
from service.manifest import Manifest
from service.report import (
    BinReport,
    CameraReport,
    HypothesisReport,
    InterpolationReport,
    LightPosteriorReport,
    LightReport,
    PosteriorReport,
    RefinementReport,
    Report,
    ViewReport,
)
from service.symmetry import symmetry_order


@dataclass(frozen=True)
class View:
    """What was found in one picture; the score is None where the bundle knows no held-out pictures."""

    posterior: Posterior
    out_of_class_score: float | None = None


@dataclass(frozen=True)
class Origin:
    """Where a shape that no picture shows comes from; nothing of it for one that the request spelled out."""

    seed: int | None = None
    temperature: float | None = None
    interpolation: InterpolationReport | None = None


def report_reconstruction(
    manifest: Manifest,
    views: Sequence[View],
    shape_code: NDArray[np.float32],
    shape_deviation: NDArray[np.float32],
    hypotheses: int = 3,
    category_probabilities: dict[str, float] | None = None,
    refinement: RefinementReport | None = None,
) -> Report:
    """The report on pictures of one object with its pooled shape code, and the `hypotheses` most probable turns."""
    first, light = views[0].posterior, views[0].posterior.light
    probabilities = first.azimuth_probabilities
    evidence = PosteriorReport(
        azimuth_confidence=round(float(probabilities.max()), 7),
        azimuth_bins=_bins(manifest.azimuth_bin_centres_degrees, probabilities),
        azimuth_entropy_nats=_entropy(probabilities),
        azimuth_symmetry=symmetry_order(probabilities),
        azimuth_fine_mean_degrees=round(math.degrees(first.azimuth_fine_mean), 4),
        azimuth_fine_deviation_degrees=round(math.degrees(first.azimuth_fine_deviation), 4),
        shape_deviation=_numbers(shape_deviation),
        light=None if light is None else _light_evidence(manifest, light),
    )
    told = tuple(_view(manifest, view, hypotheses) for view in views)
    scores = [view.out_of_class_score for view in views if view.out_of_class_score is not None]
    return Report(
        category=manifest.category,
        model=manifest.identity,
        azimuth_degrees=told[0].azimuth_degrees,
        camera=_camera(manifest),
        light_azimuth_degrees=told[0].light_azimuth_degrees,
        lights=_lights(manifest, _light_azimuth(first)),
        ambient=manifest.ambient,
        shape_code=_numbers(shape_code),
        posterior=evidence,
        hypotheses=told[0].hypotheses,
        out_of_class_score=round(sum(scores) / len(scores), 4) if scores else None,
        category_probabilities=category_probabilities
        and {name: round(probability, 7) for name, probability in category_probabilities.items()},
        views=told,
        refinement=refinement,
        seed=None,
        temperature=None,
        interpolation=None,
    )


def report_shape(manifest: Manifest, shape_code: NDArray[np.float32], azimuth: float, origin: Origin) -> Report:
    """The report on a shape that no picture shows, turned by `azimuth` radians."""
    return Report(
        category=manifest.category,
        model=manifest.identity,
        azimuth_degrees=_wrapped(math.degrees(azimuth)),
        camera=_camera(manifest),
        light_azimuth_degrees=0.0,
        lights=_lights(manifest, 0.0),
        ambient=manifest.ambient,
        shape_code=_numbers(shape_code),
        posterior=None,
        hypotheses=None,
        out_of_class_score=None,
        category_probabilities=None,
        views=None,
        refinement=None,
        seed=origin.seed,
        temperature=origin.temperature,
        interpolation=origin.interpolation,
    )


def _view(manifest: Manifest, view: View, hypotheses: int) -> ViewReport:
    posterior = view.posterior
    probabilities = posterior.azimuth_probabilities
    score = view.out_of_class_score
    return ViewReport(
        azimuth_degrees=round(math.degrees(posterior.azimuth), 4),
        azimuth_confidence=round(float(probabilities.max()), 7),
        azimuth_entropy_nats=_entropy(probabilities),
        azimuth_symmetry=symmetry_order(probabilities),
        hypotheses=_hypotheses(manifest, posterior, hypotheses),
        light_azimuth_degrees=round(math.degrees(_light_azimuth(posterior)), 4),
        out_of_class_score=None if score is None else round(score, 4),
    )


def _hypotheses(manifest: Manifest, posterior: Posterior, count: int) -> tuple[HypothesisReport, ...]:
    """The most probable turns, best first; of equally probable ones, the first bin first."""
    order = np.argsort(-posterior.azimuth_probabilities, kind="stable")[:count]
    fine, centres = math.degrees(posterior.azimuth_fine_mean), manifest.azimuth_bin_centres_degrees
    return tuple(
        HypothesisReport(_wrapped(centres[best] + fine), round(float(posterior.azimuth_probabilities[best]), 7))
        for best in order
    )


def _light_evidence(manifest: Manifest, light: LightPosterior) -> LightPosteriorReport:
    return LightPosteriorReport(
        confidence=round(float(light.probabilities.max()), 7),
        bins=_bins(manifest.light_bin_centres_degrees, light.probabilities),
        entropy_nats=_entropy(light.probabilities),
        fine_mean_degrees=round(math.degrees(light.fine_mean), 4),
        fine_deviation_degrees=round(math.degrees(light.fine_deviation), 4),
    )


def _bins(centres: tuple[float, ...], probabilities: NDArray[np.float32]) -> tuple[BinReport, ...]:
    return tuple(BinReport(*pair) for pair in zip(centres, _numbers(probabilities), strict=True))


def _entropy(probabilities: NDArray[np.float32]) -> float:
    positive = probabilities[probabilities > 0].astype(np.float64)
    return abs(round(float((positive * np.log(positive)).sum()), 6))


def _camera(manifest: Manifest) -> CameraReport:
    return CameraReport(
        elevation_degrees=manifest.camera.elevation_degrees,
        distance=manifest.camera.distance,
        field_of_view_degrees=manifest.camera.field_of_view_degrees,
        aspect_ratio=manifest.picture.width / manifest.picture.height,
    )


def _light_azimuth(posterior: Posterior) -> float:
    return 0.0 if posterior.light is None else posterior.light.azimuth


def _lights(manifest: Manifest, light_azimuth: float) -> tuple[LightReport, ...]:
    """The lights of a manifest, turned by `light_azimuth` radians."""
    return tuple(
        LightReport(
            _wrapped(light.azimuth_degrees + math.degrees(light_azimuth)) if light_azimuth else light.azimuth_degrees,
            light.elevation_degrees,
            light.colour,
        )
        for light in manifest.lights
    )


def _wrapped(degrees: float) -> float:
    """The same angle in −180 to 180."""
    return round((degrees + 180.0) % 360.0 - 180.0, 4)


def _numbers(values: NDArray[np.floating]) -> tuple[float, ...]:
    return tuple(round(value, 7) for value in values.astype(np.float64).tolist())
