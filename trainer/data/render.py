"""Renders a class of procedural shapes, or a folder of meshes, into a folder of pictures.

    OUT/scene.json                       camera, lights, size
    OUT/render.json                      the other settings, by which a second run knows whether it continues the first
    OUT/metadata.csv                     file_name, instance, azimuth_degrees, light_azimuth_degrees
    OUT/<class>/<instance>-<view>.png    8-bit sRGB

Each picture depends only on the settings, its instance and its view: an interrupted run continues where it stopped,
and a larger number of instances or views extends a folder without changing what it holds.
"""

import logging
import math
import os
import signal
import time
from collections.abc import Iterator
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing import get_context, resource_tracker
from pathlib import Path
from typing import NamedTuple

from PIL import Image
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, ProgressColumn, Task, TextColumn, TimeRemainingColumn
from rich.text import Text

from trainer.config import SceneConfig
from trainer.data.metadata import read_metadata, write_metadata
from trainer.data.normals import corner_normals
from trainer.data.picture import draw
from trainer.data.plan import Job, RenderSettings, category_of, claim, load_instance, plan_jobs
from trainer.data.srgb import encode
from trainer.data.writing import write_png
from trainer.errors import DataError, StorageError

_CHUNK = 8
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
    warning, counted and skipped. Raises ConfigError for settings that mean nothing, DataError where `out` holds
    pictures of other settings or no mesh can be read, StorageError where `out` cannot be written.
    """
    started = time.monotonic()
    jobs = plan_jobs(settings, instances, views)
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
        write_metadata(out, [row for row in rows.values() if row.instance not in skipped])
    return RenderReport(written, kept, tuple(skipped[name] for name in sorted(skipped)), time.monotonic() - started)


Result = tuple[Job, int, str | None]


def _execute(
    out: Path, settings: RenderSettings, scene: SceneConfig, jobs: list[Job], workers: int | None
) -> Iterator[Result]:
    """Runs the jobs, in this process or in several, and yields each as it is done."""
    workers = max(1, workers or len(os.sched_getaffinity(0)))
    if workers == 1 or sum(len(job.rows) for job in jobs) < _FEWEST_FOR_PROCESSES:
        for job in jobs:
            yield _render(out, settings, scene, job)
        return
    chunks = [jobs[start : start + _CHUNK] for start in range(0, len(jobs), _CHUNK)]
    pool = ProcessPoolExecutor(min(workers, len(chunks)), get_context("spawn"))
    try:
        with _interrupts_left_to_this_process():
            futures: list[Future[list[Result]]] = [
                pool.submit(_render_all, out, settings, scene, chunk) for chunk in chunks
            ]
        for future in as_completed(futures):
            yield from future.result()
    except BrokenProcessPool as error:
        raise StorageError(
            "a rendering process was ended from outside, often for want of memory; finished pictures are kept: "
            "run the same command again, with fewer workers"
        ) from error
    finally:
        pool.shutdown(cancel_futures=True)


@contextmanager
def _interrupts_left_to_this_process() -> Iterator[None]:
    """Processes that are started in the block inherit that Ctrl-C is held back, from their first moment on; one that
    comes meanwhile reaches this process at the end of the block."""
    # It would let signals through again, were it started within the block.
    resource_tracker.ensure_running()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _render_all(out: Path, settings: RenderSettings, scene: SceneConfig, jobs: list[Job]) -> list[Result]:
    return [_render(out, settings, scene, job) for job in jobs]


def _render(out: Path, settings: RenderSettings, scene: SceneConfig, job: Job) -> Result:
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
        azimuth, light_azimuth = (
            math.radians(row.azimuth_degrees or 0.0),
            math.radians(row.light_azimuth_degrees or 0.0),
        )
        colour, _ = draw(mesh, azimuth, light_azimuth, scene, settings.supersampling, normals)
        write_png(out / row.file_name, Image.fromarray(encode(colour)))
    return job, len(missing), None


def _progress(show: bool) -> Progress:
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), _Rate(), TimeRemainingColumn())
    return Progress(*columns, console=Console(stderr=True), disable=not show)


class _Rate(ProgressColumn):
    def render(self, task: Task) -> Text:
        return Text(f"{task.speed or 0:.0f} pictures/s")
