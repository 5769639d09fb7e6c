"""Renders a class of procedural shapes, or a folder of meshes, into a folder of pictures.

    OUT/scene.json                       camera, lights, size
    OUT/render.json                      the other settings, by which a second run knows whether it continues the first
    OUT/metadata.csv                     file_name, instance, azimuth_degrees, light_azimuth_degrees
    OUT/<class>/<instance>-<view>.png    8-bit sRGB

or, with `shard_pictures`, into tar files (`data.shards`), each of which is drawn as a whole.

Each picture depends only on the settings, its instance and its view: an interrupted run continues where it stopped,
and a larger number of instances or views extends a folder without changing what it holds.
"""

import gc
import logging
import math
import os
import time
from collections import deque
from collections.abc import Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path
from typing import NamedTuple

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, ProgressColumn, Task, TextColumn, TimeRemainingColumn
from rich.text import Text

from trainer.config import SceneConfig
from trainer.data.metadata import Row, read_metadata, write_metadata
from trainer.data.normals import corner_normals
from trainer.data.opengl import opengl
from trainer.data.picture import Draw, draw
from trainer.data.plan import Job, RenderSettings, category_of, claim, is_procedural, load_instance, plan_jobs
from trainer.data.png import encode_png, srgb_codes
from trainer.data.shards import INDEX_FILE, rows_of, shard_name, write_index, write_shard
from trainer.data.writing import write_bytes
from trainer.errors import DataError, StorageError
from trainer.interrupts import interrupts_left_to_this_process

# Objects that a process takes at once. To open OpenGL takes it as long as to draw fifty pictures.
_CHUNKS = {"chiaro": 8, "pyrender": 64}
# Those that are laid ready for each other process.
_CHUNKS_AHEAD = 4
_FEWEST_FOR_PROCESSES = 64

logger = logging.getLogger(__name__)


class RenderReport(NamedTuple):
    """What a run did."""

    written: int
    """Pictures drawn by this run."""
    kept: int
    """Pictures that were there already."""
    skipped: tuple[str, ...]
    """A sentence for each mesh that could not be read."""
    seconds: float


def render_folder(
    out: Path,
    settings: RenderSettings,
    scene: SceneConfig,
    instances: int | None = None,
    views: int = 1,
    workers: int | None = None,
    show_progress: bool = True,
) -> RenderReport:
    """Renders `views` pictures of each of `instances` objects, azimuths uniform in [-180°, 180°), into `out`.

    `instances` None means every file of a mesh folder. `workers` processes share the work, by default one a core.
    Finished pictures of an earlier run with the same settings are kept. Meshes that cannot be read are named in a
    warning, counted and skipped. Raises ConfigError for settings that mean nothing or a renderer that is not
    installed, DataError where `out` holds pictures of other settings or no mesh can be read, StorageError where `out`
    cannot be written.
    """
    started = time.monotonic()
    # What a model's camera sees of larger pictures is drawn as it is seen.
    scene = replace(scene, zoom=1.0)
    jobs = plan_jobs(settings, instances, views)
    with drawing(settings, scene):
        pass  # What cannot be drawn with is told before anything is written.
    claim(out, settings, scene)
    rows: dict[str, Row] = {}
    if settings.shard_pictures:
        # It is counted anew, once all are there.
        (out / INDEX_FILE).unlink(missing_ok=True)
    else:
        # Poses are known beforehand. Written first, the file tells a reader of an unfinished folder what is missing.
        rows = (read_metadata(out) or {}) | {row.file_name: row for job in jobs for row in job.rows}
        write_metadata(out, rows.values())

    written = kept = 0
    skipped: dict[str, str] = {}
    with _progress(show_progress) as progress:
        bar = progress.add_task(f"rendering {category_of(settings)}", total=len(jobs) * views)
        for job, new, problem in _execute(out, settings, scene, jobs, workers):
            progress.advance(bar, len(job.rows))
            if problem is None:
                written, kept = written + new, kept + len(job.rows) - new
            else:
                skipped[job.instance] = problem
                logger.warning("skipped: %s", problem)
    if len(skipped) == len(jobs):
        raise DataError(
            f"none of the {len(jobs)} meshes in {settings.source} can be read; first: {min(skipped.values())}"
        )
    if settings.shard_pictures:
        write_index(out)
    elif skipped:
        # What an earlier run has drawn of them stays.
        there = (row for row in rows.values() if row.instance not in skipped or (out / row.file_name).exists())
        write_metadata(out, there)
    return RenderReport(written, kept, tuple(skipped[name] for name in sorted(skipped)), time.monotonic() - started)


Result = tuple[Job, int, str | None]


class Chunk(NamedTuple):
    """What a process takes at once; the content of a shard where there are shards."""

    number: int
    jobs: list[Job]


def _execute(
    out: Path, settings: RenderSettings, scene: SceneConfig, jobs: list[Job], workers: int | None
) -> Iterator[Result]:
    """Runs the jobs, in this process and `workers` - 1 more, and yields each as it is done."""
    workers = max(1, workers or len(os.sched_getaffinity(0)))
    size = _CHUNKS[settings.renderer]
    if settings.shard_pictures:
        size = max(1, settings.shard_pictures // len(jobs[0].rows))
    chunks = [Chunk(start // size, jobs[start : start + size]) for start in range(0, len(jobs), size)]
    if workers == 1 or sum(len(job.rows) for job in jobs) < _FEWEST_FOR_PROCESSES:
        with _settled(), drawing(settings, scene) as draws:
            for chunk in chunks:
                yield from _render_chunk(out, settings, chunk, draws)
        return
    pool = ProcessPoolExecutor(min(workers - 1, len(chunks)), get_context("spawn"), _settle)
    try:
        waiting, futures = deque(chunks), deque[Future[list[Result]]]()
        # The processes begin with the first chunk, and this one, which need not start up, with the last.
        with _settled():
            while waiting or futures:
                with interrupts_left_to_this_process():
                    while waiting and len(futures) < _CHUNKS_AHEAD * (workers - 1):
                        futures.append(pool.submit(_render_all, out, settings, scene, waiting.popleft()))
                while futures and (futures[0].done() or not waiting):
                    yield from futures.popleft().result()
                if waiting:
                    yield from _render_all(out, settings, scene, waiting.pop())
    except BrokenProcessPool as error:
        raise StorageError(
            "a rendering process was ended from outside, often for want of memory; finished pictures are kept: "
            "run the same command again, with fewer workers"
        ) from error
    finally:
        pool.shutdown(cancel_futures=True)


def _settle() -> None:
    """From now on Python does not look again and again for garbage among what there is already."""
    gc.freeze()


@contextmanager
def _settled() -> Iterator[None]:
    """The same, for the block."""
    _settle()
    try:
        yield
    finally:
        gc.unfreeze()


def _render_all(out: Path, settings: RenderSettings, scene: SceneConfig, chunk: Chunk) -> list[Result]:
    with drawing(settings, scene) as draws:
        return list(_render_chunk(out, settings, chunk, draws))


def _render_chunk(out: Path, settings: RenderSettings, chunk: Chunk, draws: Draw) -> Iterator[Result]:
    if not settings.shard_pictures:
        for job in chunk.jobs:
            yield _render(out, settings, job, draws)
        return
    path, expected = out / shard_name(chunk.number), sum(len(job.rows) for job in chunk.jobs)
    if path.exists() and len(rows_of(path)) == expected:
        yield from ((job, 0, None) for job in chunk.jobs)
        return
    samples: list[tuple[Row, bytes]] = []
    done: list[Result] = []
    for job in chunk.jobs:
        drawn, problem = _drawn(settings, job, job.rows, draws)
        samples += drawn
        done.append((job, len(drawn), problem))
    write_shard(path, samples)
    yield from done


@contextmanager
def drawing(settings: RenderSettings, scene: SceneConfig) -> Iterator[Draw]:
    """What draws the pictures, for the block and this thread. Raises ConfigError where it is not installed."""
    match settings.renderer:
        case "chiaro":
            closed = is_procedural(settings)
            yield lambda mesh, azimuth, light_azimuth, normals: draw(
                mesh, azimuth, light_azimuth, scene, settings.supersampling, normals, closed
            )[0]
        case "pyrender":
            with opengl(scene, settings.supersampling) as draws:
                yield draws


def _render(out: Path, settings: RenderSettings, job: Job, draws: Draw) -> Result:
    """Draws what is missing of one object: how many pictures, or why it cannot be drawn."""
    missing = [row for row in job.rows if not (out / row.file_name).exists()]
    drawn, problem = _drawn(settings, job, missing, draws)
    for row, picture in drawn:
        write_bytes(out / row.file_name, picture)
    return job, len(drawn), problem


def _drawn(
    settings: RenderSettings, job: Job, rows: Sequence[Row], draws: Draw
) -> tuple[list[tuple[Row, bytes]], str | None]:
    """These pictures of an object, as PNG files, or why it cannot be drawn."""
    if not rows:
        return [], None
    try:
        mesh = load_instance(settings, job.instance)
    except DataError as error:
        return [], str(error)
    normals, drawn = corner_normals(mesh), []
    for row in rows:
        angles = math.radians(row.azimuth_degrees or 0.0), math.radians(row.light_azimuth_degrees or 0.0)
        drawn.append((row, encode_png(srgb_codes(draws(mesh, *angles, normals)))))
    return drawn, None


def _progress(show: bool) -> Progress:
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), _Rate(), TimeRemainingColumn())
    return Progress(*columns, console=Console(stderr=True), disable=not show)


class _Rate(ProgressColumn):
    def render(self, task: Task) -> Text:
        return Text(f"{task.speed or 0:.0f} pictures/s")
