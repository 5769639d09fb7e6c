"""`python -m trainer train`"""

from collections.abc import Callable
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Annotated, Any, Self

import torch
import tyro
from rich.console import Console

from trainer import processes
from trainer.commands.former import FormerOptions
from trainer.commands.fresh import FreshOptions, drawn_scene, fresh_options, open_fresh
from trainer.commands.preparation import check_preparation, report_preparation
from trainer.commands.progress import progress_of
from trainer.config import SceneConfig, TrainConfig
from trainer.data.images import ImageSet, load_image_folder
from trainer.data.rig import load_rig
from trainer.data.scene import SCENE_FILE
from trainer.data.source import PictureSource
from trainer.data.streaming import ShardPictures, open_shards
from trainer.errors import ConfigError
from trainer.mapping import from_mapping, to_mapping
from trainer.presets import DEFAULT, load_preset, preset_names, preset_setting
from trainer.selection.starts import Start, begun, best_start, first_steps, usual_starts
from trainer.training.checkpoint import FILE_NAME, Checkpoint
from trainer.training.checks import check_category, check_intervals, check_pictures, check_processes, check_settings
from trainer.training.device import Choice, chosen_device
from trainer.training.intervals import Intervals
from trainer.training.longer_look import MOST_STEPS as MOST_LOOKING_STEPS
from trainer.training.longer_look import STEPS as LOOKING_STEPS
from trainer.training.loop import train
from trainer.training.reframing import reframe
from trainer.training.threads import limit_threads


@dataclass(frozen=True)
class TrainCommand:
    """Learn shape and pose from pictures, without labels.

    The pictures are those of a folder (--images) or of tar files (--shards), or are drawn for each step, from another
    side each time: of a procedural class (--class alone), of mesh files (--meshes) or of ShapeNet (--shapenet).
    Writes into the run directory: config.json, metrics.jsonl, tensorboard/, previews/ and checkpoint.safetensors.
    Ctrl-C saves and stops; --resume goes on from there. `torchrun --nproc-per-node N -m -- trainer train …`
    starts N processes, also on several machines, that share every batch and, of a folder, compute what one would.
    """

    images: Path | None
    """Folder of pictures (PNG, JPEG, WebP), as `trainer render` writes it or your own, of one object each before a
    plain or transparent background: prepared.png shows how they are cut out. --resume remembers it."""
    run_directory: Annotated[Path, tyro.conf.arg(name="run")]
    """Run directory, new or (with --resume) old."""
    shards: Path | None = None
    """Folder of tar files of pictures (WebDataset), as `trainer render --shards` writes them: read while it trains."""
    shards_at_once: int = 8
    """Tar files in memory that minibatches are drawn from; while they are, as many more are decoded. --resume
    remembers both."""
    category: Annotated[str, tyro.conf.arg(name="class")] = ""
    """What the pictures show, one word; by default the name of the folder. Alone: procedural class to draw."""
    preset: str = DEFAULT
    """Named settings, or a TOML file; every option below overrides it. With --resume the run's own settings stand in
    its place."""
    resume: bool = False
    """Go on with the training in the run directory, with its settings; only --optimiser.* may change."""
    starts: int = 0
    """Trainings that are begun, from --seed on; the one that explains pictures best after 300 steps (or a fifth of all,
    where that is less) goes on. Guards against a seed that fails. 0 means 3 where poses are to be found in 1500 steps
    or more, by one process, not by the paper's objective, and not by views that are moved; else 1. --resume remembers
    it."""
    reframing_share: float = 0.5
    """So many more steps, as a share of --optimiser.steps, in which the encoder alone learns: what a longer look finds
    in pictures, and to see objects also where a rule sets those that are cut out of pictures, and as another camera
    takes them (paper: none)."""
    looking_steps: int = LOOKING_STEPS
    """The longer look: from the encoder's word on, so many steps of descent find what shape and pose explain each
    picture better. 0: the encoder goes on saying what it said, as it does where several views are pooled."""
    device: Choice = "auto"
    """Where the networks and the renderer compute; auto: a GPU where there is one."""
    record: bool = True
    """On a GPU, record a step's kernels once and replay them; --no-record launches each kernel anew, for those who look
    for a mistake. One process only."""
    threads: int = 0
    """CPU threads of the networks and the renderer; 0 means one per core."""
    intervals: Intervals = field(default_factory=Intervals)
    """How often what is written, in steps."""
    former: Annotated[FormerOptions, tyro.conf.arg(name="")] = field(default_factory=FormerOptions)
    """What former trainings found in the pictures of --images."""
    fresh: Annotated[FreshOptions, tyro.conf.arg(name="")] = field(default_factory=FreshOptions)
    """Views that are drawn for each step."""
    config: Annotated[TrainConfig, tyro.conf.arg(name="")] = field(default_factory=TrainConfig)
    """Settings."""

    @classmethod
    def default(cls, arguments: list[str]) -> Self:
        """The defaults that --preset or --resume bring, looked up before the other options are read."""
        required: Any = tyro.MISSING
        if not arguments or arguments[0] != "train":
            return cls(None, required)
        run, preset = _value_of("--run", arguments), _value_of("--preset", arguments) or DEFAULT
        if "--resume" in arguments and run:
            before, starts = begun(Path(run))
            images = Path(before.run["images"]) if "images" in before.run else None
            fresh = from_mapping(FreshOptions, before.run.get("fresh", {}), f"{run}, fresh")
            shards = Path(before.run["shards"]) if "shards" in before.run else None
            at_once = int(before.run.get("shards_at_once", cls.shards_at_once))
            return cls(
                images, required, shards, at_once, before.category, starts=starts, former=FormerOptions.of(before.run),
                fresh=fresh, config=before.config,
            )  # fmt: skip
        return cls(None, required, fresh=fresh_options(preset_setting(preset)), config=load_preset(preset))

    def run(self) -> None:
        if self.former.poses_of is not None and self.config.loss.pose_supervision != "azimuth":
            config = replace(self.config, loss=replace(self.config.loss, pose_supervision="azimuth"))
            replace(self, config=config).run()
            return
        check_settings(self.config)
        check_intervals(self.intervals)
        if not 0 <= self.reframing_share <= 100:
            raise ConfigError(f"Expected --reframing-share from 0 to 100, found {self.reframing_share:g}.")
        if not 0 <= self.looking_steps <= MOST_LOOKING_STEPS:
            raise ConfigError(f"Expected --looking-steps from 0 to {MOST_LOOKING_STEPS}, found {self.looking_steps}.")
        # Here alone: the first rungs of a selection are shorter than what a whole training waits for.
        after, steps = self.config.loss.front_back_after, self.config.optimiser.steps
        if not self.resume and after >= steps:
            raise ConfigError(
                f"Expected loss.front_back_after below optimiser.steps, {steps}, found {after}: front and back would "
                "never be asked to be alike. Let it begin earlier, or train for longer."
            )
        with processes.joined():
            self._train()

    def _train(self) -> None:
        check_processes(self.config.optimiser, processes.count())
        limit_threads(self.threads)
        device = chosen_device(self.device)
        first = processes.number() == 0
        category = self._category()
        check_category(category)
        console = Console(stderr=True, quiet=not first)
        source: ImageSet | PictureSource
        provenance: dict[str, Any]
        if self.images is not None:
            source = self._load(self.images)
            provenance = {"images": str(self.images.resolve())}
            console.print(f"{len(source)} pictures of {len(source.instance_names)} objects, {category}")
            check_preparation(self.images, source)
            if self.resume:
                self.former.check_resumed(begun(self.run_directory)[0].run)
                source = self.former.kept(source, self.run_directory)
            else:
                source = self.former.found(source, self.images, self.run_directory, console)
            provenance |= self.former.remembered()
            if first and (self.resume or not (self.run_directory / FILE_NAME).exists()):
                report_preparation(console, self.images, source, self.run_directory)
        elif self.shards is not None:
            source = self._stream(self.shards)
            provenance = {"shards": str(self.shards.resolve()), "shards_at_once": self.shards_at_once}
            shards = f"{len(source.shards)} of them, {len(source.held_out)} held out"
            console.print(f"{source.training} pictures in shards ({shards}), {category}")
        else:
            source = open_fresh(self.fresh, category, self.config)
            provenance = {"fresh": to_mapping(self.fresh.absolute())}
            console.print(f"fresh views of {source.training} objects, {source.validation} more held out, {category}")
        if source.scene.zoom != 1:
            console.print(f"the middle of each picture is looked at, {source.scene.zoom:g} times as large")
        config, resume = self.config, self.resume
        starts = self._starts()
        if starts != 1:
            config, resume = self._best_start(starts, source, category, provenance, console, device), True
        due = round(self.reframing_share * config.optimiser.steps)
        with progress_of("training", config.optimiser.steps + due, console, device) as report:
            intervals, directory = self.intervals, self.run_directory
            last = train(
                config, source, category, directory, intervals, resume, report, provenance, None, device, self.record
            )
            if last.step >= config.optimiser.steps:
                last = self._taught(last, source, due, report, device, console)
        finished = last.step >= config.optimiser.steps and last.reframing_steps >= due
        done = "finished" if finished else "stopped; continue with --resume"
        alone = f" and {last.reframing_steps} more for the encoder" if last.reframing_steps else ""
        console.print(f"{done} at step {last.step}{alone} after {last.run['seconds']:.0f} s: {self.run_directory}")
        if not finished:
            raise KeyboardInterrupt

    def _taught(
        self,
        last: Checkpoint,
        source: ImageSet | PictureSource,
        steps: int,
        report: Callable[[int, dict[str, float]], None],
        device: torch.device,
        console: Console,
    ) -> Checkpoint:
        """The same training after the phase in which the encoder learns alone."""
        if self.looking_steps and steps > last.reframing_steps:
            console.print("a longer look at the pictures, then the encoder alone learns what that found")
        directory, intervals = self.run_directory, self.intervals
        return reframe(last, directory, source, steps, intervals, report, device, self.record, self.looking_steps)

    def _best_start(
        self,
        starts: int,
        source: ImageSet | PictureSource,
        category: str,
        provenance: dict[str, Any],
        console: Console,
        device: torch.device,
    ) -> TrainConfig:
        """The settings of the start that goes on, whose training so far is in the run directory."""

        def report(start: Start) -> None:
            said = f"log p {start.bound:.1f}" if start.bound is not None else start.problem
            console.print(f"start from seed {start.seed}: {said} ({start.core_seconds:.0f} s)")

        intervals, directory = self.intervals, self.run_directory
        with progress_of(f"{starts} starts", starts * first_steps(self.config), console, device) as report_step:
            try:
                config = best_start(
                    self.config, starts, source, category, directory, intervals, report, report_step, provenance,
                    device, self.record,
                )  # fmt: skip
            except KeyboardInterrupt:
                console.print(f"stopped before one of {starts} starts was chosen; continue with --resume: {directory}")
                raise
        console.print(f"seed {config.seed} explains pictures best, and goes on")
        return config

    def _starts(self) -> int:
        """How many trainings are begun."""
        if not self.resume:
            return self.starts or usual_starts(self.config)
        _, remembered = begun(self.run_directory)
        if self.starts != remembered:
            raise ConfigError(
                f"Expected a training that is resumed to keep its number of starts, {remembered}, found --starts "
                f"{self.starts}. Leave it away."
            )
        return remembered

    def _load(self, folder: Path) -> ImageSet:
        """The pictures of a folder, in its own scene or, without one, in that of the options.

        Raises ConfigError for options that only drawn views have, and where its scene has other lights than the preset.
        """
        config = self.config
        images = load_image_folder(folder, config.width, config.height, self._scene_of(folder), config.zoom)
        self._check_lights(folder, images.scene)
        return images

    def _stream(self, folder: Path) -> ShardPictures:
        """The same for shards."""
        if not 1 <= self.shards_at_once <= 1024:
            raise ConfigError(f"Expected --shards-at-once from 1 to 1024, found {self.shards_at_once}.")
        config, width, height = self.config, self.config.width, self.config.height
        source = open_shards(
            folder, width, height, self._scene_of(folder), config.validation_share, self.shards_at_once, config.zoom
        )
        self._check_lights(folder, source.scene)
        images = source.load(source.shards[:1])
        check_pictures(self.config, images, torch.arange(len(images)))
        return source

    def _scene_of(self, folder: Path) -> SceneConfig:
        """The scene of the options, for pictures without one.

        Raises ConfigError for options that only drawn views have, or that say what the pictures say themselves.
        """
        usual = FreshOptions() if self.resume else fresh_options(preset_setting(self.preset))
        has_scene = (folder / SCENE_FILE).exists()
        for option in fields(FreshOptions):
            if getattr(self.fresh, option.name) == getattr(usual, option.name):
                continue
            name = option.name.replace("_", "-")
            if option.name not in ("camera", "rig"):
                raise ConfigError(
                    f"Expected --{name} only for views that are drawn, found it beside pictures: leave it away."
                )
            if has_scene:
                raise ConfigError(
                    f"Expected --{name} only for pictures whose scene is not known, but {folder} has a {SCENE_FILE}, "
                    "which tells camera and lights: leave it away."
                )
        return self._own_scene()

    def _check_lights(self, folder: Path, scene: SceneConfig) -> None:
        """Raises ConfigError where the pictures have other lights than the preset."""
        usual = FreshOptions() if self.resume else fresh_options(preset_setting(self.preset))
        rig = load_rig(usual.rig)
        if usual.rig != FreshOptions().rig and (scene.lights, scene.ambient) != (rig.lights, rig.ambient):
            raise ConfigError(
                f"Expected pictures lit by the rig {usual.rig}, as {self.preset} has it, found others in {folder}: "
                f"render them with --rig {usual.rig}."
            )

    def _own_scene(self) -> SceneConfig:
        """Camera and lights of pictures that come without any; of a training that is resumed, its own."""
        if self.resume and self.fresh == FreshOptions():
            return begun(self.run_directory)[0].scene
        return drawn_scene(self.fresh, self.config.height, self.config.height)

    def _category(self) -> str:
        """Raises ConfigError where no pictures are named, two kinds of them, or such as former trainings cannot use."""
        folders = [folder for folder in (self.images, self.shards, self.fresh.meshes, self.fresh.shapenet) if folder]
        if len(folders) > 1 or not (folders or self.category):
            raise ConfigError(
                "Expected one of --images DIR, --shards DIR, --meshes DIR, --shapenet DIR and --class CLASS, found "
                f"{'none' if not folders else ' and '.join(map(str, folders))}."
            )
        self.former.check(self.images is not None)
        return self.category or Path(folders[0]).resolve().name


def _value_of(option: str, arguments: list[str]) -> str | None:
    for position, argument in enumerate(arguments):
        if argument == option and position + 1 < len(arguments):
            return arguments[position + 1]
        if argument.startswith(option + "="):
            return argument.removeprefix(option + "=")
    return None


TrainCommand.__doc__ = f"{TrainCommand.__doc__}\n    Presets: {', '.join(preset_names())}.\n    "
