"""Short trainings of cars under each regime: whether they come to an end, and what of.

OUT/pictures/<class>-<count>/         what is trained on, rendered where it is missing
OUT/trainings/<regime>/seed-<n>/      the run, and figures.json once it is done; an interrupted one goes on
"""

import json
import math
import zlib
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from trainer.config import SceneConfig, TrainConfig
from trainer.data.images import ImageSet, load_image_folder
from trainer.data.plan import RenderSettings
from trainer.data.render import render_folder
from trainer.data.writing import write_bytes
from trainer.errors import CheckpointError, DataError
from trainer.evaluation.pictures import Pictures, Validation
from trainer.evaluation.subject import from_checkpoint
from trainer.presets import load_preset
from trainer.stability.answers import answers, examinee, figures_of
from trainer.stability.budget import Budget
from trainer.stability.objects import TEST_SEED, VALIDATION_SEED, exhibits, photographs, pictures_of, truths
from trainer.stability.regimes import REGIMES, Regime, Stock
from trainer.training.checkpoint import FILE_NAME, Checkpoint, load_checkpoint
from trainer.training.intervals import Intervals
from trainer.training.loop import train

PRESET, CATEGORY = "fast", "car"
_FIGURES_FILE = "figures.json"
# Of the last line of metrics.jsonl.
_HEALTH = ("loss", "shape_nats", "active_dimensions", "azimuth_entropy", "aggregate_azimuth_entropy", "rerender_error")


def run_trainings(
    output: Path, budget: Budget, regimes: Sequence[Regime], recipe: TrainConfig, report: Callable[[str], None]
) -> None:
    """Trains and judges what is not done yet, all regimes with one seed before the next.

    A training that fails is a finding, and is kept as one. Raises KeyboardInterrupt after Ctrl-C, when the training is
    saved; ConfigError for a directory of other settings; StorageError where the disk is full.
    """
    missing = [
        (regime, seed)
        for seed in range(budget.seeds)
        for regime in regimes
        if not (_directory(output, regime, seed) / _FIGURES_FILE).exists()
    ]
    if not missing:
        return
    stock = _stock(output, budget, recipe)
    test, validation = _judged(budget, stock.cars.scene)
    for regime, seed in missing:
        report(f"{regime.title}, seed {seed}")
        figures = _trained(_directory(output, regime, seed), regime, seed, stock, budget, recipe, test, validation)
        content = json.dumps(figures, indent=2, allow_nan=False) + "\n"
        write_bytes(_directory(output, regime, seed) / _FIGURES_FILE, content.encode())


def found_trainings(output: Path) -> dict[str, Any]:
    """What is known of each regime so far, a list of its seeds each."""
    found = {}
    for regime in REGIMES:
        files = sorted((output / "trainings" / regime.name).glob(f"seed-*/{_FIGURES_FILE}"))
        if files:
            found[regime.name] = {"title": regime.title, "seeds": [json.loads(file.read_text()) for file in files]}
    return found


def recipe_for(budget: Budget) -> TrainConfig:
    """The usual training, in single precision."""
    recipe = load_preset(PRESET)
    return replace(recipe, precision="float32", optimiser=replace(recipe.optimiser, steps=budget.steps))


def _directory(output: Path, regime: Regime, seed: int) -> Path:
    return output / "trainings" / regime.name / f"seed-{seed}"


def _stock(output: Path, budget: Budget, recipe: TrainConfig) -> Stock:
    scene = SceneConfig(recipe.width, recipe.height)
    loaded = []
    for category, count in ((CATEGORY, budget.training_pictures), ("chair", budget.training_pictures // 2)):
        folder = output / "pictures" / f"{category}-{count}"
        render_folder(folder, RenderSettings(category), scene, count, 1, show_progress=False)
        loaded.append(load_image_folder(folder, recipe.width, recipe.height, zoom=recipe.zoom))
    return Stock(*loaded)


def _judged(budget: Budget, scene: SceneConfig) -> tuple[Pictures, Validation]:
    shown = exhibits(CATEGORY, TEST_SEED, budget.judged_objects)
    others = exhibits(CATEGORY, VALIDATION_SEED, budget.judged_objects)
    azimuths = np.array([exhibit.azimuths[0] for exhibit in others])
    validation = Validation(photographs(others, scene), azimuths, np.arange(len(others)), None)
    return pictures_of(photographs(shown, scene), shown, truths(shown)), validation


def _trained(
    directory: Path,
    regime: Regime,
    seed: int,
    stock: Stock,
    budget: Budget,
    recipe: TrainConfig,
    test: Pictures,
    validation: Validation,
) -> dict[str, Any]:
    """One training's figures; where it did not come to its end, the sentence that was said in their place."""
    config = replace(regime.settings(recipe), seed=seed)
    images = regime.pictures(stock, np.random.default_rng([seed, zlib.crc32(regime.name.encode())]))
    told: dict[str, Any] = {"seed": seed, "pictures": len(images), "batch_size": config.optimiser.batch_size}
    try:
        last = _run(config, images, directory, budget)
        seen = {"finished": True, "sentence": None, "seconds": last.run["seconds"]}
        examined = examinee(regime.name, from_checkpoint(last), validation, None)
        figures = figures_of(answers(examined, test))
    except (DataError, CheckpointError) as error:
        seen = {"finished": False, "sentence": str(error), "seconds": None}
        figures = None
    return told | seen | _journal(directory) | {"figures": figures}


def _run(config: TrainConfig, images: ImageSet, directory: Path, budget: Budget) -> Checkpoint:
    begun = (directory / FILE_NAME).exists()
    # Its health is looked at once, at the end.
    intervals = Intervals(log=max(1, budget.steps // 25), preview=budget.steps, checkpoint=max(1, budget.steps // 4))
    last = train(config, images, CATEGORY, directory, intervals, begun, _to_nobody, {"regime": directory.parent.name})
    if last.step < config.optimiser.steps:
        raise KeyboardInterrupt
    return load_checkpoint(directory)


def _journal(directory: Path) -> dict[str, Any]:
    """What somebody saw who looked at the run directory: steps, those that were skipped, and the last figures."""
    lines = _lines(directory / "metrics.jsonl")
    last = json.loads(lines[-1]) if lines else {"step": 0}
    notes = _lines(directory / "log.txt")
    health = {name: last.get(name) for name in _HEALTH}
    rounded = {name: value if value is None else _short(value) for name, value in health.items()}
    return {"step": last["step"], "skipped_steps": len(notes), "first_note": notes[0] if notes else None} | rounded


def _lines(path: Path) -> list[str]:
    return path.read_text().splitlines() if path.exists() else []


def _short(value: float) -> float:
    """Four digits."""
    return float(f"{value:.4g}") if math.isfinite(value) else value


def _to_nobody(step: int, figures: dict[str, float]) -> None:
    """The run directory's metrics.jsonl has the figures."""
