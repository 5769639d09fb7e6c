"""`python -m trainer select`"""

import json
import math
import shlex
import sys
from dataclasses import dataclass, field, fields, replace
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Self

import tyro
from rich.console import Console

from trainer.commands.fresh import FreshOptions, drawn_scene
from trainer.commands.preparation import check_preparation, report_preparation
from trainer.config import CameraConfig, Symmetry, TrainConfig
from trainer.data.scene import SCENE_FILE
from trainer.data.writing import write_bytes
from trainer.errors import ConfigError
from trainer.presets import load_preset
from trainer.selection.bound import empty_log_likelihood
from trainer.selection.candidates import Candidate, Light, config_of, grid
from trainer.selection.choice import choose
from trainer.selection.halving import Budget, halve
from trainer.selection.held_out import by_object, check_split, held_out
from trainer.selection.judging import judge
from trainer.selection.page import as_json, as_markdown
from trainer.selection.record import mean_of
from trainer.selection.selection import Selection, claim
from trainer.selection.size import Size, size_of
from trainer.selection.winner import PRESET_FILE, WINNER_DIRECTORY, keep_winner
from trainer.training.checks import check_category

MOST_RUNGS = 10


@dataclass(frozen=True)
class SelectCommand:
    """Find the smallest model that explains a folder of pictures, without labels.

    Candidates are trained side by side and judged by how likely they find pictures that none of them has seen; the less
    likely half is dropped, and so forth. Chosen is the smallest that comes within a standard error of the best. Writes
    selection.md, selection.json, preset.toml and the chosen training; the same command goes on where it was
    interrupted. docs/select.md says what is compared, and what that means.
    """

    images: Path
    """Folder of pictures (PNG, JPEG, WebP), as `trainer render` writes it or your own, as for `trainer train`."""
    output: Path
    """Directory to write to."""
    category: Annotated[str, tyro.conf.arg(name="class")] = ""
    """What the pictures show, one word; by default the name of the folder."""
    forms: tuple[str, ...] = (
        "subdivision-3", "subdivision-4", "ortho-block-3", "ortho-block-6", "full-block-6", "full-block-12",
    )  # fmt: skip
    """Kinds of mesh: subdivision-N with N segments along each edge of the cube, cup-N with as many of the cup,
    ortho-block-N and full-block-N with N blocks."""
    latents: tuple[int, ...] = (6, 12)
    """Sizes of the shape code."""
    lights: tuple[Light, ...] = ("fixed", "varying")
    """Whether the lights stand still, or turn by an angle that is inferred from each picture."""
    symmetries: tuple[Symmetry, ...] = ("none", "mirror")
    """Whether shapes are free, or their own mirror images: left to right, and with two-mirrors front to back, too."""
    preset: str = "balanced"
    """Named settings, or a TOML file, that all candidates share; its --model.* as far as no option here sets it."""
    steps: int = 0
    """Steps that the last candidates come to; 0 means the preset's, more there cannot be."""
    minutes: float = 0.0
    """Instead of --steps: minutes of one core for training and judging all candidates; several cores share them."""
    rungs: int = 3
    """How often candidates are judged; after each time but the last, half of them are dropped."""
    validation_share: float = 0.1
    """Share of the objects that is held out."""
    samples: int = 4
    """Draws from the posterior of each held-out picture."""
    seed: int = 0
    """Seed of all trainings, and of what is held out."""
    camera: CameraConfig = field(default_factory=CameraConfig)
    """Where the camera stands, for pictures of your own."""
    rig: str = "colour"
    """Lights of pictures of your own: colour, white, or a TOML file."""
    workers: int = 0
    """Trainings at once, which share the cores; 0 means one per core."""
    dry_run: bool = False
    """Only say what would be compared."""

    @classmethod
    def default(cls, arguments: list[str]) -> Self:
        required: Any = tyro.MISSING
        return cls(required, required)

    def run(self) -> None:
        self._check()
        selection = self._selection()
        sizes = {candidate: size_of(selection.config(candidate)) for candidate in selection.candidates}
        images = selection.pictures()
        check_preparation(self.images, images)
        check_split(images, selection.recipe)
        shown = held_out(images, selection.recipe)
        counts = len(images) - len(shown), len(shown)
        if self.dry_run:
            print(_plan(selection, sizes, counts))
            return
        claim(selection, images)
        console = Console(stderr=True, soft_wrap=True)
        report_preparation(console, self.images, images, self.output)
        say = partial(console.print, markup=False)
        rungs = halve(selection.candidates, selection.budget, partial(judge, selection, images, self.workers, say))
        choice = choose(rungs, sizes)
        empty = by_object(empty_log_likelihood(selection.recipe.loss, images.batch(shown)), images, selection.recipe)
        found = as_json(selection, sizes, rungs, choice, counts, mean_of(empty))
        page = as_markdown(found)
        write_bytes(self.output / "selection.json", (json.dumps(found, indent=2) + "\n").encode())
        write_bytes(self.output / "selection.md", page.encode())
        keep_winner(selection, choice.chosen)
        print(page, end="")
        print(self._further(selection.category, rungs[-1].step), file=sys.stderr)

    def _check(self) -> None:
        """Raises ConfigError for options out of range or that contradict each other."""
        for option, value, low, high in (
            ("steps", self.steps, 0, 10**9),
            ("minutes", self.minutes, 0, 10**6),
            ("rungs", self.rungs, 1, MOST_RUNGS),
            ("samples", self.samples, 1, 1000),
            ("workers", self.workers, 0, 1024),
        ):
            if not (math.isfinite(value) and low <= value <= high):
                raise ConfigError(f"Expected --{option} from {low} to {high}, found {value}.")
        if self.steps and self.minutes:
            raise ConfigError("Expected either --steps or --minutes, found both.")
        if (self.images / SCENE_FILE).exists() and (self.camera, self.rig) != (CameraConfig(), "colour"):
            raise ConfigError(
                f"Expected --camera and --rig only for pictures whose scene is not known, but {self.images} has a "
                f"{SCENE_FILE}, which tells camera and lights: leave them away."
            )

    def _selection(self) -> Selection:
        recipe = self._recipe()
        category = self.category or self.images.resolve().name
        check_category(category)
        candidates = grid(self.forms, self.latents, self.lights, self.symmetries)
        for candidate in candidates:
            config_of(candidate, recipe)
        return Selection(
            root=self.output,
            images=self.images,
            own_scene=drawn_scene(FreshOptions(camera=self.camera, rig=self.rig), recipe.height, recipe.height),
            category=category,
            recipe=recipe,
            candidates=tuple(candidates),
            budget=Budget(
                steps=self.steps or recipe.optimiser.steps,
                seconds=60 * self.minutes if self.minutes else None,
                rungs=self.rungs,
            ),
            samples=self.samples,
        )

    def _recipe(self) -> TrainConfig:
        """What all candidates share. Raises ConfigError for presets that candidates cannot be compared with."""
        recipe = replace(load_preset(self.preset), seed=self.seed, validation_share=self.validation_share)
        if recipe.loss.pose_supervision != "none":
            raise ConfigError(
                f"Expected a preset without labels, found loss.pose_supervision {recipe.loss.pose_supervision} in "
                f"{self.preset}: a selection looks at pictures alone. Leave it away."
            )
        if recipe.optimiser.views_per_instance > 1:
            raise ConfigError(
                f"Expected a preset of single pictures, found optimiser.views_per_instance "
                f"{recipe.optimiser.views_per_instance} in {self.preset}: held-out pictures are judged one by one."
            )
        if recipe.loss.kl_weight == 0:
            raise ConfigError(
                f"Expected loss.kl_weight above 0 in {self.preset}, found 0: it says how exactly a model has to "
                "explain a picture."
            )
        if recipe.loss.kind == "silhouette" and "varying" in self.lights:
            raise ConfigError(
                f"Expected --lights fixed with {self.preset}, found varying: its loss compares silhouettes, which say "
                "nothing about the light."
            )
        if not self.rungs <= (self.steps or recipe.optimiser.steps) <= recipe.optimiser.steps:
            raise ConfigError(
                f"Expected --steps from {self.rungs} (--rungs) to {recipe.optimiser.steps}, those of {self.preset}, "
                f"found {self.steps or recipe.optimiser.steps}. Name a longer preset, or fewer steps."
            )
        return recipe

    def _further(self, category: str, step: int) -> str:
        """How to go on with what was chosen."""
        winner, preset = str(self.output / WINNER_DIRECTORY), str(self.output / PRESET_FILE)
        own = ["--class", category] + ([] if self.rig == "colour" else ["--rig", self.rig])
        for part in fields(CameraConfig):
            if (value := getattr(self.camera, part.name)) != getattr(CameraConfig(), part.name):
                own += [f"--camera.{part.name.replace('_', '-')}", str(value)]
        trainer = ["python", "-m", "trainer", "train"]
        on = [*trainer, "--run", winner, "--resume", "--optimiser.steps", str(2 * step)]
        anew = [*trainer, "--images", str(self.images), "--preset", preset, "--run", "RUN", *own]
        return f"{'train on':12}{shlex.join(on)}\n{'train anew':12}{shlex.join(anew)}"


def _plan(selection: Selection, sizes: dict[Candidate, Size], counts: tuple[int, int]) -> str:
    """What would be compared, the smallest first."""
    budget = selection.budget
    lines = [
        f"{candidate.name:36}{size.parameters:>9,} parameters, {size.vertices:>4} vertices, about "
        f"{size.bundle_bytes / 1000:,.0f} kB"
        for candidate, size in sorted(sizes.items(), key=lambda item: item[1])
    ]
    goal = f"{budget.steps} steps" if budget.seconds is None else f"{budget.seconds / 60:g} minutes of a core in all"
    return "\n".join(
        [*lines, f"{len(lines)} candidates, {budget.rungs} rungs, {goal}; {counts[0]} pictures, {counts[1]} held out"]
    )
