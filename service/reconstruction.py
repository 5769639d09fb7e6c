"""From pictures of one object to an answer: graphs, re-rendering, file. Knows no HTTP, runs in any thread."""

from collections.abc import Iterator, Sequence
from time import perf_counter
from typing import Final, NamedTuple

from pydantic_core import to_jsonable_python

from imaging.preparation import Prepared, placed
from service.answer import Answer, Form, milliseconds
from service.errors import ImageError, StrangeImageError
from service.explanation import MOST_STRANGE, category_probabilities, out_of_class_score, unexplained
from service.exposure import Blocks, used_part
from service.findings import View, report_reconstruction
from service.glb import write_glb
from service.image import check_pixels, read_picture
from service.inference import Array, Engine, Posterior, Surface, decode, encode, pool
from service.manifest import Camera, Picture
from service.overlay import enlargement, overlay_png
from service.placement import DEFAULT_ROUNDS, place
from service.refinement import AS_ENCODED, Effort, improve
from service.report import RefinementReport, Report

Errors = tuple[float, ...]
"""The re-render error of each picture."""

_ROUNDS_TO_CHOOSE: Final = 1
"""In which each of several models looks where cut-out objects belong: a second one names the class hardly better."""


class Candidate(NamedTuple):
    """What one model makes of the pictures."""

    engine: Engine
    pictures: tuple[Prepared, ...]
    posteriors: tuple[Posterior, ...]
    shape_code: Array
    shape_deviation: Array
    surface: Surface


def reconstruct(
    engines: Sequence[Engine],
    contents: Sequence[bytes],
    max_pixels: int,
    form: Form = "glb",
    hypotheses: int = 3,
    effort: Effort = AS_ENCODED,
    blocks: Blocks = "all",
    rounds: int = DEFAULT_ROUNDS,
) -> Answer:
    """The object in uploaded pictures, by the one of several models that explains them best, its answer refined.

    Scores rest on what the encoder says at first sight: so do the figures that they are compared with. Where objects
    were cut out, each model looks where they belong before one is chosen, and that one again in so many `rounds`. A PNG
    shows the mesh over the first picture; a GLB holds all blocks of the object, or those that it uses.

    Raises:
        ImageError: an upload is no picture that can be read, or none of the models explains it.
        InferenceError: the model gave something that is no mesh.
    """
    if len(contents) > 1:
        check_pixels(contents, max_pixels)
    seconds = dict.fromkeys(("picture", "encoder", "decoder", "render", "place", "refine", form), 0.0)
    candidates: dict[str, Candidate] = {}
    errors: dict[str, Errors] = {}
    pictures: dict[tuple[Picture, Camera], tuple[Prepared, ...]] = {}
    for engine in engines:
        name, seen = engine.manifest.category, (engine.manifest.picture, engine.manifest.camera)
        began = perf_counter()
        # Models that see with the same camera share what was read.
        if seen not in pictures:
            pictures[seen] = tuple(_read(engine, content, max_pixels, 1) for content in contents)
            seconds["picture"] += perf_counter() - began
        candidates[name] = _at_first_sight(engine, pictures[seen], seconds)
        began = perf_counter()
        errors[name] = _unexplained(candidates[name])
        seconds["render"] += perf_counter() - began
    placing = rounds > 0 and any(prepared.guessed for seen in pictures.values() for prepared in seen)
    telling = errors
    if placing and len(engines) > 1:
        began = perf_counter()
        telling = {name: _unexplained(_placed(candidate, _ROUNDS_TO_CHOOSE)) for name, candidate in candidates.items()}
        seconds["place"] += perf_counter() - began
    probabilities = category_probabilities(telling)
    told = probabilities if len(engines) > 1 else None
    reports = ((candidates[name], _report(candidates[name], errors[name], told, hypotheses)) for name in probabilities)
    best, report = _first_explained(reports)
    first_sight = errors[report.category]
    if placing:
        began = perf_counter()
        best = _placed(best, rounds)
        report = _report(best, first_sight, told, hypotheses)
        seconds["place"] += perf_counter() - began
    if effort.iterations:
        began = perf_counter()
        best, gain = _refined(best, effort)
        report = _report(best, first_sight, told, hypotheses, gain)
        seconds["refine"] += perf_counter() - began
    began = perf_counter()
    content = _glb(best, report, blocks) if form == "glb" else _png(best, contents[0], max_pixels)
    seconds[form] += perf_counter() - began
    return Answer(content, report, milliseconds({stage: taken for stage, taken in seconds.items() if taken}))


def _at_first_sight(engine: Engine, pictures: tuple[Prepared, ...], seconds: dict[str, float]) -> Candidate:
    """One model's view of the pictures; adds up how long each stage took."""
    started = perf_counter()
    posteriors = tuple(encode(engine, prepared.picture) for prepared in pictures)
    shape_code, shape_deviation = pool(posteriors)
    encoded = perf_counter()
    surface = decode(engine, shape_code)
    seconds["encoder"] += encoded - started
    seconds["decoder"] += perf_counter() - encoded
    return Candidate(engine, pictures, posteriors, shape_code, shape_deviation, surface)


def _placed(candidate: Candidate, rounds: int) -> Candidate:
    """The same model's view, with cut-out objects where it explains them best."""
    engine = candidate.engine
    pictures, posteriors = zip(*(place(engine, prepared, rounds) for prepared in candidate.pictures), strict=True)
    shape_code, shape_deviation = pool(posteriors)
    return Candidate(engine, pictures, posteriors, shape_code, shape_deviation, decode(engine, shape_code))


def _refined(candidate: Candidate, effort: Effort) -> tuple[Candidate, RefinementReport]:
    """The same candidate with better poses, lights and shape; and what was gained."""
    engine = candidate.engine
    better = improve(engine, candidate.pictures, candidate.posteriors, candidate.shape_code, effort)
    new = candidate._replace(
        posteriors=better.posteriors, shape_code=better.shape_code, surface=decode(engine, better.shape_code)
    )
    before, after = (round(sum(errors) / len(errors), 6) for errors in map(_unexplained, (candidate, new)))
    return new, RefinementReport(better.iterations, before, after)


def _unexplained(candidate: Candidate) -> Errors:
    """The re-render error of each picture."""
    return tuple(
        unexplained(candidate.engine, prepared, posterior, candidate.surface)
        for prepared, posterior in zip(candidate.pictures, candidate.posteriors, strict=True)
    )


def _read(engine: Engine, content: bytes, max_pixels: int, scale: int) -> Prepared:
    """A picture as the model sees it, or `scale` times as large."""
    size, camera = engine.manifest.picture, engine.manifest.camera
    width, height = scale * size.width, scale * size.height
    return read_picture(
        content, width, height, max_pixels, camera.distance, camera.field_of_view_degrees, zoom=size.zoom
    )


def _report(
    candidate: Candidate,
    first_sight: Errors,
    probabilities: dict[str, float] | None,
    hypotheses: int,
    refinement: RefinementReport | None = None,
) -> Report:
    manifest = candidate.engine.manifest
    views = [
        View(posterior, out_of_class_score(manifest.held_out, prepared.method, error))
        for posterior, prepared, error in zip(candidate.posteriors, candidate.pictures, first_sight, strict=True)
    ]
    code, deviation = candidate.shape_code, candidate.shape_deviation
    return report_reconstruction(manifest, views, code, deviation, hypotheses, probabilities, refinement)


def _first_explained(reports: Iterator[tuple[Candidate, Report]]) -> tuple[Candidate, Report]:
    """The most probable model's out of those that explain the pictures. Raises StrangeImageError where none does."""
    category, score = "", 0.0
    for candidate, report in reports:
        if report.out_of_class_score is None or report.out_of_class_score <= MOST_STRANGE:
            return candidate, report
        if not category:
            category, score = report.category, report.out_of_class_score
    raise StrangeImageError(
        f"expected a picture that the model of {category} can explain, found one that looks unlike what it "
        f"found in it: an out-of-class score of {score:.1f}, where {MOST_STRANGE:g} is the most; send one "
        f"{category}, whole, before a plain background, in the light that the model knows, or name another "
        "category"
    )


def _glb(candidate: Candidate, report: Report, blocks: Blocks) -> bytes:
    first, *others = candidate.posteriors
    light_azimuth = 0.0 if first.light is None else first.light.azimuth
    surface, manifest = candidate.surface, candidate.engine.manifest
    if blocks == "used":
        surface, manifest = used_part(surface, manifest)
    return write_glb(
        surface,
        manifest,
        first.azimuth,
        to_jsonable_python(report),
        light_azimuth,
        [posterior.azimuth for posterior in others],
    )


def _png(candidate: Candidate, content: bytes, max_pixels: int) -> bytes:
    engine, first = candidate.engine, candidate.posteriors[0]
    scale = enlargement(engine)
    seen = candidate.pictures[0]
    picture = seen.picture.repeat(scale, 1).repeat(scale, 2)
    try:
        closer = _read(engine, content, max_pixels, scale)
    except ImageError:
        # Looked at more closely, its background may be too restless to be told from the object.
        closer = seen
    if closer.method == seen.method and closer is not seen:
        picture = (closer if seen.placement is None else placed(closer, seen.placement)).picture
    light_azimuth = 0.0 if first.light is None else first.light.azimuth
    return overlay_png(engine, candidate.surface, first.azimuth, light_azimuth, picture)
