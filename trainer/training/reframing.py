"""The last phase of a training: the encoder learns to see objects in pictures that another camera took.

Renderings show an object where their camera has it, and as bright and as sharp as that camera has it. Whoever sends a
picture of their own has no such camera: the object is cut out and set into the frame by a rule (`imaging.framing`),
which is off by some percent, and exposure, white balance and sharpness are others. An encoder that has never seen this
is easily led astray: it takes darker cars for lower ones, and turns them round. So it learns to say of such a picture
what is to be said of the one that was rendered: what it says itself, or rather what a longer look finds from there
(`training.longer_look`), which explains the picture better. Shapes stay as they are.
"""

from collections.abc import Callable, Iterator
from contextlib import closing, nullcontext
from copy import deepcopy
from dataclasses import replace
from pathlib import Path
from typing import Final, NamedTuple

import torch
from jaxtyping import Float
from torch import Tensor, nn
from torch.nn import functional
from torch.nn.parallel import DistributedDataParallel

from imaging.framing import Frame
from trainer import processes
from trainer.config import TrainConfig
from trainer.data.images import ImageSet, frame_in
from trainer.data.source import PictureSource
from trainer.model.batch_norm import synchronise
from trainer.model.posterior import Posterior, divergence_between
from trainer.model.vae import Model
from trainer.recording import normal_noise
from trainer.training.checkpoint import FILE_NAME, Checkpoint, save_checkpoint
from trainer.training.clock import Clock
from trainer.training.descent import Descent, Given, descend
from trainer.training.device import CPU, enough_memory, sent_to
from trainer.training.interruption import interruptible
from trainer.training.intervals import Intervals
from trainer.training.journal import Journal
from trainer.training.lessons import MOST_STUDIED, Lesson, lessons, study, told
from trainer.training.longer_look import STEPS as LOOKING_STEPS
from trainer.training.loop import note_skipped, of_folder
from trainer.training.optimiser import adam, at_step
from trainer.training.recorded import differentiation_on
from trainer.training.step import encode_mixed, number_format

# Linear intensity of sRGB code 8: what is brighter is the object.
_VISIBLE: Final = 0.0024
# Standard deviations about the rule: edges of a silhouette, and with them its box, are not found to the pixel.
_SIZE_DEVIATION: Final = 0.03
_CENTRE_DEVIATION: Final = 0.01
# Of another camera: the logarithm of all light, that of each channel beside it, and how many times over what a blur of
# a pixel takes away is added (or, below zero, taken away).
_EXPOSURE_DEVIATION: Final = 0.5
_BALANCE_DEVIATION: Final = 0.1
_SHARPNESS_DEVIATION: Final = 0.7
_PLACEMENT, _CAMERA = 3, 5
"""Numbers that say where an object is set, and what camera took it."""


def reframe(
    checkpoint: Checkpoint,
    run_directory: Path,
    images: ImageSet | PictureSource,
    steps: int,
    intervals: Intervals,
    report: Callable[[int, dict[str, float]], None],
    device: torch.device = CPU,
    record: bool = True,
    looking: int = LOOKING_STEPS,
) -> Checkpoint:
    """The phase of a run whose other steps are done, from what `training.loop.train` returned; returns the last
    checkpoint, which is also written there.

    It has so many steps, with numbers behind the others'; nothing is done where it has had as many. One that is
    stopped, by Ctrl-C or otherwise, leaves the checkpoint as it was, and begins anew. Pictures, `report`, device,
    `record` and processes are as they are there. What is taught is found by `looking` steps of a longer look at
    `MOST_STUDIED` pictures; if that is 0, or several views are pooled, it is what the encoder says of all.

    Raises:
        DataError: no finite gradient, or shape, any more.
        StorageError: the disk, or the memory, is full.
    """
    config, model, before = checkpoint.config, checkpoint.model, checkpoint.step
    source = of_folder(config, images) if isinstance(images, ImageSet) else images
    if steps <= checkpoint.reframing_steps:
        return checkpoint
    if processes.count() > 1:
        synchronise(model.encoder)
    clock, skipped, first = Clock(checkpoint.run), 0, processes.number() == 0
    with (
        Journal(run_directory, config, before, clock.seconds_before) if first else nullcontext() as journal,
        interruptible() as interrupted,
        enough_memory(device, config.optimiser.batch_size),
    ):

        def stopped() -> bool:
            return processes.anywhere(interrupted())

        studied = None
        if looking and config.optimiser.views_per_instance == 1:
            studied = study(checkpoint, source.some(MOST_STUDIED, config.seed), looking, device, stopped)
            if studied is None:
                return checkpoint
        with (
            closing(lessons(config, studied or source, before)) as drawn,
            closing(sent_to(device, drawn)) as taught,
        ):
            frame = frame_in(checkpoint.scene) if source.framed else None
            learning = learn_reframed(model, config, frame, taught, steps, device, record)
            for step, taken in enumerate(learning, before + 1):
                if taken is None:
                    skipped += 1
                    note_skipped(journal, step, skipped)
                else:
                    skipped = 0
                    if journal and (step % intervals.log == 0 or step == before + steps):
                        figures = {"loss": float(taken.result.loss().detach()), "gradient_norm": taken.gradient_norm}
                        journal.log(step, figures)
                        report(step, figures)
                if stopped():
                    return checkpoint
    done = {"reframing_steps": steps, "framed": source.framed}
    last = replace(checkpoint, run=checkpoint.run | clock.told() | done)
    if first:
        save_checkpoint(run_directory / FILE_NAME, last)
    return last


def learn_reframed(
    model: Model,
    config: TrainConfig,
    frame: Frame | None,
    taught: Iterator[Lesson],
    steps: int,
    device: torch.device = CPU,
    record: bool = True,
) -> Iterator[Descent["ReframingResult"] | None]:
    """Teaches the model's encoder what a longer look finds in pictures, or else what it says itself of them, also where
    another camera took them and the rule sets their objects.

    Every second picture is changed so, the others stay as they are. Without a `frame` the rule has set all objects
    already, and another camera is all that differs. Yields what each step gave, None where it was
    skipped for want of a finite gradient; the model is as it was until the last one has been asked for. Of processes
    that train together each has its share of the lessons, and all end with the same model. It may be on another
    device than `device`, where the pictures are and everything is computed.
    """
    convolutions, size = number_format(config.precision, device), config.optimiser.batch_size
    teacher, student = deepcopy(model).eval().to(device), Reframing(deepcopy(model)).train().to(device)
    taking = student if processes.count() == 1 else DistributedDataParallel(student, forward_sync_buffers=False)
    schedule = replace(config.optimiser, steps=steps, falling_share=1.0)
    optimiser = adam(student, schedule)
    own = processes.share(size)
    every_second = (torch.arange(size)[own] % 2 == 1)[:, None, None, None].to(device)

    def forward(given: Given) -> ReframingResult:
        pictures = given.pictures
        with torch.no_grad():
            said = told(encode_mixed(teacher, pictures, convolutions), given.look)
        noise = normal_noise((size, _PLACEMENT + _CAMERA), given.generator, pictures.dtype, pictures.device)[own]
        placed = pictures if frame is None else reframed(pictures, frame, noise[:, :_PLACEMENT])
        seen = torch.where(every_second, retaken(placed, noise[:, _PLACEMENT:]), pictures)
        result: ReframingResult = taking(seen, said, convolutions)
        return result

    differentiation = differentiation_on(device, student, schedule.gradient_clip, forward, record)
    for step in range(steps):
        lesson = next(taught)
        given = Given(lesson.pictures, None, None, lesson.generator, lesson.look)
        yield descend(at_step(optimiser, schedule, step), differentiation, given)
    model.encoder.load_state_dict(student.encoder.state_dict())
    model.heads.load_state_dict(student.heads.state_dict())


class ReframingResult(NamedTuple):
    """One step's."""

    divergence: Float[Tensor, "B"]
    """KL from what is taught of each picture to what the model says now, nats."""

    def loss(self) -> Tensor:
        return self.divergence.mean()


class Reframing(nn.Module):
    """What one step of the phase computes; its parameters are the encoder's and the heads', and not the decoder's."""

    def __init__(self, model: Model) -> None:
        super().__init__()
        self.encoder, self.heads = model.encoder, model.heads

    def forward(
        self, pictures: Float[Tensor, "B 3 H W"], taught: Posterior, convolutions: torch.dtype
    ) -> ReframingResult:
        return ReframingResult(divergence_between(taught, encode_mixed(self, pictures, convolutions)))


def reframed(pictures: Float[Tensor, "B 3 H W"], frame: Frame, noise: Float[Tensor, "B 3"]) -> Float[Tensor, "B 3 H W"]:
    """Linear pictures on black with their objects where the rule sets them, give or take what a box may be off by.

    `noise` is standard normal: of the size, of x and of y. A picture without an object stays black. The rule's own
    function, `imaging.framing.framed`, takes one picture file at a time; this one interpolates between pixels, by
    cubics: linear interpolation blurs, and files, which have more pixels than the model sees, are not blurred.
    """
    height, width = pictures.shape[2:]
    left, right, top, bottom = _boxes(pictures)
    size = torch.exp(_SIZE_DEVIATION * noise[:, 0]) * frame.diagonal / torch.hypot(right - left, bottom - top)
    x, y = (_CENTRE_DEVIATION * frame.diagonal * noise[:, 1:]).unbind(1)
    across = _sampled(width, (left + right) / 2, width / 2 + x, size)
    down = _sampled(height, (top + bottom) / 2, height / 2 + frame.drop + y, size)
    grid = torch.stack(
        [across[:, None].expand(-1, height, -1), down[:, :, None].expand(-1, -1, width)],
        dim=-1,
    )
    return functional.grid_sample(pictures, grid, mode="bicubic", align_corners=False).clamp(0, 1)


def retaken(pictures: Float[Tensor, "B 3 H W"], noise: Float[Tensor, "B 5"]) -> Float[Tensor, "B 3 H W"]:
    """Linear pictures on black as another camera would have taken them: sharper or softer, brighter or darker, with
    another white balance; what is too bright is cut off.

    `noise` is standard normal: of the sharpness, of the exposure and of the three channels.
    """
    sharpness, exposure, balance = noise[:, 0], noise[:, 1:2], noise[:, 2:]
    details = pictures - _blurred(pictures)
    sharpened = pictures + _SHARPNESS_DEVIATION * sharpness[:, None, None, None] * details
    gain = torch.exp(_EXPOSURE_DEVIATION * exposure + _BALANCE_DEVIATION * balance)
    return (sharpened * gain[:, :, None, None]).clamp(0, 1)


def _blurred(pictures: Float[Tensor, "B 3 H W"]) -> Float[Tensor, "B 3 H W"]:
    """By a binomial of three pixels along both axes; there is black around the picture."""
    padded = functional.pad(pictures, (1, 1, 1, 1))
    across = padded[..., :-2] + 2 * padded[..., 1:-1] + padded[..., 2:]
    return (across[..., :-2, :] + 2 * across[..., 1:-1, :] + across[..., 2:, :]) / 16


def _boxes(pictures: Float[Tensor, "B 3 H W"]) -> tuple[Tensor, Tensor, Tensor, Tensor]:
    """The box around what is visible: left, right, top and bottom, pixels; its outermost pixels are covered by half in
    the mean. Where nothing is, the whole picture."""
    visible = pictures.amax(1) > _VISIBLE
    columns, rows = visible.any(1).float(), visible.any(2).float()
    ends = []
    for line in (columns, rows):
        first, last = line.argmax(1), line.flip(1).argmax(1)
        ends += [first + 0.5, line.shape[1] - last - 0.5]
    return ends[0], ends[1], ends[2], ends[3]


def _sampled(count: int, from_centre: Tensor, to_centre: Tensor, size: Tensor) -> Float[Tensor, "B count"]:
    """Where each pixel of a line comes from, −1 at one end of the line and 1 at the other."""
    places = torch.arange(count, dtype=size.dtype, device=size.device) + 0.5
    sources = (places - to_centre[:, None]) / size[:, None] + from_centre[:, None]
    return 2 * sources / count - 1
