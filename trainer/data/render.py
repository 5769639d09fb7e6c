"""Renders a class of procedural shapes, or a folder of meshes, into a folder of pictures.

    OUT/scene.json                       camera, lights, size
    OUT/render.json                      the other settings, by which a second run knows whether it continues the first
    OUT/metadata.csv                     file_name, instance, azimuth_degrees, light_azimuth_degrees
    OUT/<class>/<instance>-<view>.png    8-bit sRGB

Each picture depends only on the settings, its instance and its view: an interrupted run continues where it stopped,
and a larger number of instances or views extends a folder without changing what it holds.
"""

import gc
import logging
import math
import os
import time
from collections import deque
from collections.abc import Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing import get_context
from pathlib import Path
from typing import NamedTuple

import numpy as np
from jaxtyping import Float32, UInt8
from numpy import ndarray
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, ProgressColumn, Task, TextColumn, TimeRemainingColumn
from rich.text import Text

from imaging.srgb import encode
from trainer.config import SceneConfig
from trainer.data.metadata import read_metadata, write_metadata
from trainer.data.normals import corner_normals
from trainer.data.opengl import opengl
from trainer.data.picture import Draw, draw
from trainer.data.plan import Job, RenderSettings, category_of, claim, load_instance, plan_jobs
from trainer.data.png import encode_png
from trainer.data.writing import write_bytes
from trainer.errors import DataError, StorageError
from trainer.interrupts import interrupts_left_to_this_process

# Objects that a process takes at once. To open OpenGL takes it as long as to draw fifty pictures.
_CHUNKS = {"chiaro": 8, "pyrender": 64}
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
    jobs = plan_jobs(settings, instances, views)
    with drawing(settings, scene):
        pass  # What cannot be drawn with is told before anything is written.
    claim(out, settings, scene)
    earlier = read_metadata(out) or {}
    # Poses are known beforehand. Written first, the file tells a reader of an unfinished folder what is missing.
    rows = earlier | {row.file_name: row for job in jobs for row in job.rows}
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
    if skipped:
        if len(skipped) == len(jobs):
            raise DataError(
                f"none of the {len(jobs)} meshes in {settings.source} can be read; first: {min(skipped.values())}"
            )
        # What an earlier run has drawn of them stays.
        there = (row for row in rows.values() if row.instance not in skipped or (out / row.file_name).exists())
        write_metadata(out, there)
    return RenderReport(written, kept, tuple(skipped[name] for name in sorted(skipped)), time.monotonic() - started)


Result = tuple[Job, int, str | None]


def _execute(
    out: Path, settings: RenderSettings, scene: SceneConfig, jobs: list[Job], workers: int | None
) -> Iterator[Result]:
    """Runs the jobs, in this process and `workers` - 1 more, and yields each as it is done."""
    workers = max(1, workers or len(os.sched_getaffinity(0)))
    if workers == 1 or sum(len(job.rows) for job in jobs) < _FEWEST_FOR_PROCESSES:
        with _settled(), drawing(settings, scene) as draws:
            for job in jobs:
                yield _render(out, settings, job, draws)
        return
    size = _CHUNKS[settings.renderer]
    chunks = [jobs[start : start + size] for start in range(0, len(jobs), size)]
    pool = ProcessPoolExecutor(min(workers - 1, len(chunks)), get_context("spawn"), _settle)
    try:
        with interrupts_left_to_this_process():
            futures: deque[tuple[list[Job], Future[list[Result]]]] = deque(
                (chunk, pool.submit(_render_all, out, settings, scene, chunk)) for chunk in chunks
            )
        # The processes begin with the first chunk, and this one, which need not start up, with the last.
        with _settled():
            while futures:
                while futures and futures[0][1].done():
                    yield from futures.popleft()[1].result()
                if futures:
                    chunk, last = futures.pop()
                    yield from _render_all(out, settings, scene, chunk) if last.cancel() else last.result()
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


def _render_all(out: Path, settings: RenderSettings, scene: SceneConfig, jobs: list[Job]) -> list[Result]:
    with drawing(settings, scene) as draws:
        return [_render(out, settings, job, draws) for job in jobs]


@contextmanager
def drawing(settings: RenderSettings, scene: SceneConfig) -> Iterator[Draw]:
    """What draws the pictures, for the block and this thread. Raises ConfigError where it is not installed."""
    match settings.renderer:
        case "chiaro":
            yield lambda mesh, azimuth, light_azimuth, normals: draw(
                mesh, azimuth, light_azimuth, scene, settings.supersampling, normals
            )[0]
        case "pyrender":
            with opengl(scene, settings.supersampling) as draws:
                yield draws


def _render(out: Path, settings: RenderSettings, job: Job, draws: Draw) -> Result:
    """Draws what is missing of one object: how many pictures, or why it cannot be drawn."""
    missing = [row for row in job.rows if not (out / row.file_name).exists()]
    if not missing:
        return job, 0, None
    try:
        mesh = load_instance(settings, job.instance)
    except DataError as error:
        return job, 0, str(error)
    normals = corner_normals(mesh)
    for row in missing:
        angles = math.radians(row.azimuth_degrees or 0.0), math.radians(row.light_azimuth_degrees or 0.0)
        write_bytes(out / row.file_name, encode_png(_encoded(draws(mesh, *angles, normals))))
    return job, len(missing), None


def _encoded(colour: Float32[ndarray, "H W 3"]) -> UInt8[ndarray, "H W 3"]:
    """sRGB codes; the background, most of a picture, is spared the arithmetic."""
    codes = np.zeros(colour.shape, np.uint8)
    seen = colour > 0
    codes[seen] = encode(colour[seen])
    return codes


def _progress(show: bool) -> Progress:
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), _Rate(), TimeRemainingColumn())
    return Progress(*columns, console=Console(stderr=True), disable=not show)


class _Rate(ProgressColumn):
    def render(self, task: Task) -> Text:
        return Text(f"{task.speed or 0:.0f} pictures/s")
