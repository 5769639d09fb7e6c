"""`python -m trainer train`"""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, Self

import tyro
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from trainer.config import TrainConfig
from trainer.data.images import load_image_folder
from trainer.presets import load_preset, preset_names
from trainer.training.checkpoint import load_checkpoint
from trainer.training.checks import check_category, check_intervals, check_settings
from trainer.training.intervals import Intervals
from trainer.training.loop import train
from trainer.training.threads import limit_threads


@dataclass(frozen=True)
class TrainCommand:
    """Learn shape and pose from a folder of pictures, without labels.

    Writes into the run directory: config.json, metrics.jsonl, tensorboard/, previews/ and checkpoint.safetensors.
    Ctrl-C saves and stops; --resume goes on from there.
    """

    images: Path
    """Folder of pictures (PNG, JPEG, WebP), as `trainer render` writes it or your own. --resume remembers it."""
    run_directory: Annotated[Path, tyro.conf.arg(name="run")]
    """Run directory, new or (with --resume) old."""
    category: str = ""
    """What the pictures show, one word; by default the name of the picture folder."""
    preset: str = "demo"
    """Named settings, or a TOML file; every option below overrides it."""
    resume: bool = False
    """Go on with the training in the run directory, with its settings; only --optimiser.* may change."""
    threads: int = 0
    """CPU threads of the networks and the renderer; 0 means one per core."""
    intervals: Intervals = field(default_factory=Intervals)
    """How often what is written, in steps."""
    config: Annotated[TrainConfig, tyro.conf.arg(name="")] = field(default_factory=TrainConfig)
    """Settings."""

    @classmethod
    def default(cls, arguments: list[str]) -> Self:
        """The defaults that --preset or --resume bring, looked up before the other options are read."""
        required: Any = tyro.MISSING
        if not arguments or arguments[0] != "train":
            return cls(required, required)
        run, preset = _value_of("--run", arguments), _value_of("--preset", arguments) or "demo"
        if "--resume" in arguments and run:
            before = load_checkpoint(Path(run))
            images = Path(before.run["images"]) if "images" in before.run else required
            return cls(images, required, config=before.config, category=before.category)
        return cls(required, required, config=load_preset(preset))

    def run(self) -> None:
        check_settings(self.config)
        check_intervals(self.intervals)
        limit_threads(self.threads)
        category = self.category or self.images.resolve().name
        check_category(category)
        images = load_image_folder(self.images, self.config.width, self.config.height)
        console = Console(stderr=True)
        console.print(f"{len(images)} pictures of {len(images.instance_names)} objects, {category}")
        columns = (
            TextColumn("training"),
            BarColumn(),
            MofNCompleteColumn(),
            TextColumn("{task.fields[rate]} steps/s"),
            TimeRemainingColumn(),
            TextColumn("loss {task.fields[loss]}"),
        )
        with Progress(*columns, console=console) as progress:
            bar = progress.add_task("training", total=self.config.optimiser.steps, rate="…", loss="…")

            def report(step: int, figures: dict[str, float]) -> None:
                speed = progress.tasks[bar].speed
                rate = "…" if speed is None else f"{speed:.1f}"
                progress.update(bar, completed=step, rate=rate, loss=f"{figures['loss']:.1f}")

            last = train(
                self.config, images, category, self.run_directory, self.intervals, self.resume, report,
                {"images": str(self.images.resolve())},
            )  # fmt: skip
        done = "finished" if last.step >= self.config.optimiser.steps else "stopped; continue with --resume"
        console.print(f"{done} at step {last.step} after {last.run['seconds']:.0f} s: {self.run_directory}")


def _value_of(option: str, arguments: list[str]) -> str | None:
    for position, argument in enumerate(arguments):
        if argument == option and position + 1 < len(arguments):
            return arguments[position + 1]
        if argument.startswith(option + "="):
            return argument.removeprefix(option + "=")
    return None


TrainCommand.__doc__ = f"{TrainCommand.__doc__}\n    Presets: {', '.join(preset_names())}.\n    "
