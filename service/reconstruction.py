"""From pictures of one object to an answer: graphs, re-rendering, file. Knows no HTTP, runs in any thread."""

from collections.abc import Iterator, Sequence
from time import perf_counter
from typing import NamedTuple

from pydantic_core import to_jsonable_python

from imaging.framing import Frame, frame_of
from imaging.preparation import Prepared
from service.answer import Answer, Form, milliseconds
from service.errors import ImageError, StrangeImageError
from service.explanation import MOST_STRANGE, category_probabilities, out_of_class_score, unexplained
from service.exposure import Blocks, used_part
from service.findings import View, report_reconstruction
from service.glb import write_glb
from service.image import check_pixels, read_pictures
from service.inference import Array, Engine, Posterior, Surface, decode, encode, pool
from service.overlay import enlargement, overlay_png
from service.refinement import AS_ENCODED, Effort, improve
from service.report import RefinementReport, Report


class Candidate(NamedTuple):
    """What one model makes of the pictures."""

    engine: Engine
    pictures: tuple[Prepared, ...]
    posteriors: tuple[Posterior, ...]
    shape_code: Array
    shape_deviation: Array
    surface: Surface
    errors: tuple[float, ...]
    """The re-render error of each picture."""


def reconstruct(
    engines: Sequence[Engine],
    contents: Sequence[bytes],
    max_pixels: int,
    form: Form = "glb",
    hypotheses: int = 3,
    effort: Effort = AS_ENCODED,
    blocks: Blocks = "all",
) -> Answer:
    """The object in uploaded pictures, by the one of several models that explains them best, its answer refined.

    Scores and the choice of the model rest on what the encoder says: so do the figures that they are compared with. A
    PNG shows the mesh over the first picture; a GLB holds all blocks of the object, or those that it uses.

    Raises:
        ImageError: an upload is no picture that can be read, or none of the models explains it.
        InferenceError: the model gave something that is no mesh.
    """
    if len(contents) > 1:
        check_pixels(contents, max_pixels)
    refining = ("refine",) if effort.iterations else ()
    seconds = dict.fromkeys(("picture", "encoder", "decoder", "render", *refining, form), 0.0)
    began = perf_counter()
    frames = tuple(dict.fromkeys(frame_for(engine) for engine in engines))
    read = [dict(zip(frames, read_pictures(content, frames, max_pixels), strict=True)) for content in contents]
    seconds["picture"] += perf_counter() - began
    candidates = {
        engine.manifest.category: _try(engine, tuple(seen[frame_for(engine)] for seen in read), seconds)
        for engine in engines
    }
    probabilities = category_probabilities(
        {name: candidate.errors for name, candidate in candidates.items()},
        {name: candidate.engine.manifest.category_bias for name, candidate in candidates.items()},
    )
    told = probabilities if len(engines) > 1 else None
    reports = ((candidates[name], _report(candidates[name], told, hypotheses)) for name in probabilities)
    best, report = _first_explained(reports)
    if effort.iterations:
        began = perf_counter()
        best, gain = _refined(best, effort)
        report = _report(best, told, hypotheses, gain)
        seconds["refine"] += perf_counter() - began
    began = perf_counter()
    content = _glb(best, report, blocks) if form == "glb" else _png(best, contents[0], max_pixels)
    seconds[form] += perf_counter() - began
    return Answer(content, report, milliseconds(seconds))


def frame_for(engine: Engine, scale: int = 1) -> Frame:
    """Where the model expects objects in its pictures, or in pictures `scale` times as large."""
    size, camera = engine.manifest.picture, engine.manifest.camera
    width, height = scale * size.width, scale * size.height
    return frame_of(width, height, camera.distance, camera.field_of_view_degrees, size.zoom)


def _try(engine: Engine, pictures: tuple[Prepared, ...], seconds: dict[str, float]) -> Candidate:
    """One model's view of the pictures; adds up how long each stage took."""
    started = perf_counter()
    posteriors = tuple(encode(engine, prepared.picture) for prepared in pictures)
    shape_code, shape_deviation = pool(posteriors, engine.manifest.views_per_instance)
    encoded = perf_counter()
    surface = decode(engine, shape_code)
    decoded = perf_counter()
    errors = tuple(
        unexplained(engine, prepared, posterior, surface)
        for prepared, posterior in zip(pictures, posteriors, strict=True)
    )
    drawn = perf_counter()
    for stage, value in (
        ("encoder", encoded - started),
        ("decoder", decoded - encoded),
        ("render", drawn - decoded),
    ):
        seconds[stage] += value
    return Candidate(engine, pictures, posteriors, shape_code, shape_deviation, surface, errors)


def _refined(candidate: Candidate, effort: Effort) -> tuple[Candidate, RefinementReport]:
    """The same candidate with better poses, lights and shape, its errors as they were; and what was gained."""
    engine, pictures = candidate.engine, candidate.pictures
    better = improve(engine, pictures, candidate.posteriors, candidate.shape_code, effort)
    surface = decode(engine, better.shape_code)
    errors = [
        unexplained(engine, prepared, posterior, surface)
        for prepared, posterior in zip(pictures, better.posteriors, strict=True)
    ]
    before, after = (round(sum(found) / len(found), 6) for found in (candidate.errors, errors))
    new = candidate._replace(posteriors=better.posteriors, shape_code=better.shape_code, surface=surface)
    return new, RefinementReport(better.iterations, before, after)


def _report(
    candidate: Candidate,
    probabilities: dict[str, float] | None,
    hypotheses: int,
    refinement: RefinementReport | None = None,
) -> Report:
    manifest = candidate.engine.manifest
    views = [
        View(posterior, out_of_class_score(manifest.held_out, prepared.method, error))
        for posterior, prepared, error in zip(candidate.posteriors, candidate.pictures, candidate.errors, strict=True)
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
        (closer,) = read_pictures(content, (frame_for(engine, scale),), max_pixels)
    except ImageError:
        # Looked at more closely, its background may be too restless to be told from the object.
        closer = seen
    if closer.method == seen.method and closer is not seen:
        picture = closer.picture
    light_azimuth = 0.0 if first.light is None else first.light.azimuth
    return overlay_png(engine, candidate.surface, first.azimuth, light_azimuth, picture, seen.method != "framed")
