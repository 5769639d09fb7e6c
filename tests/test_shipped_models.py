"""The bundles in models/ are whole, small, and what their page says of them."""

import json
import shlex
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tyro
from PIL import Image

from service.bundle import read_bundle
from service.catalogue import read_catalogue
from service.inference import decode, load_engine, sample_shape_code
from trainer.commands.train import TrainCommand
from trainer.config import TrainConfig
from trainer.data.shapes.catalogue import CATEGORIES
from trainer.mapping import from_mapping

MODELS = Path(__file__).parents[1] / "models"
LIGHTS = MODELS.with_name("models-light")
BUNDLES = sorted(path.parent for path in MODELS.glob("*/manifest.json"))
IN_OTHER_LIGHTS = sorted(path.parent for path in LIGHTS.glob("*/manifest.json"))
FIGURES: dict[str, Any] = json.loads((MODELS / "figures.json").read_text())


def trainings_of(bundle: Path) -> list[str]:
    """The commands that trained it, without the one that taught its encoder anew."""
    commands = [training["command"] for training in FIGURES[bundle.name]["trainings"]]
    return [command for command in commands if "exporter.restoring" not in command]


@pytest.mark.parametrize("bundle", BUNDLES + IN_OTHER_LIGHTS, ids=lambda bundle: bundle.name)
def test_a_bundle_works_and_has_the_figures_that_are_published(bundle: Path) -> None:
    engine = load_engine(read_bundle(bundle))  # which asks the graphs for what the bundle says they answer
    manifest, published = engine.manifest, FIGURES[bundle.name]
    assert manifest.category == bundle.name.split("-")[0]
    assert manifest.metrics["iou"] == published["test"]["iou"]
    assert manifest.training["config"]["model"]["parameterisation"] == published["parameterisation"]
    run, trainings = manifest.training["run"], trainings_of(bundle)
    assert f"--optimiser.steps {manifest.training['step']} " in trainings[-1]
    # Nobody told it a pose: where it was told any, another training had found them.
    supervised = manifest.training["config"]["loss"]["pose_supervision"] != "none"
    told = run
    while "restored_from" in told:  # once for each time that its encoder was taught anew
        told = told["restored_from"]
    assert supervised == ("poses_of" in told)
    assert len(trainings) == 1 + supervised + ("unknown_poses_of" in told)
    # Whose encoder was taught the last phase anew says so.
    assert ("restored_from" in run) == (trainings[-1] != published["trainings"][-1]["command"])
    assert run["reframing_steps"] > 0
    assert manifest.held_out is not None
    assert manifest.aggregate_posterior is not None
    assert sum(file.stat().st_size for file in bundle.iterdir()) == published["bundle_bytes"] < 4e6
    surface = decode(engine, sample_shape_code(0, manifest.latent))
    assert 0.3 < abs(surface.vertices).max() < 1.0
    assert '": "/' not in (bundle / "manifest.json").read_text()


@pytest.mark.parametrize("bundle", BUNDLES + IN_OTHER_LIGHTS, ids=lambda bundle: bundle.name)
def test_the_command_that_is_published_is_the_training_s(bundle: Path) -> None:
    told = read_bundle(bundle).manifest.training["config"]
    _, _, _, *options = shlex.split(trainings_of(bundle)[-1])
    command = tyro.cli(TrainCommand, args=options[1:], default=TrainCommand.default(options))
    config = command.config
    if command.former.poses_of is not None:
        # As the option's help says, whatever the preset.
        config = replace(config, loss=replace(config.loss, pose_supervision="azimuth"))
    # What trainings of before could not ask for yet is off.
    assert from_mapping(TrainConfig, told, bundle.name) == config


def test_the_service_takes_all_of_them_together() -> None:
    catalogue = read_catalogue(MODELS)
    catalogue.load()
    assert not catalogue.failures
    assert sorted(catalogue.engines) == [bundle.name for bundle in BUNDLES]
    assert set(catalogue.engines) <= set(CATEGORIES)
    assert sum(file.stat().st_size for bundle in BUNDLES for file in bundle.iterdir()) < 40e6


def test_all_that_is_promised_is_there() -> None:
    assert [bundle.name for bundle in BUNDLES] == sorted(CATEGORIES)
    assert [bundle.name for bundle in IN_OTHER_LIGHTS] == ["car-varying-light", "car-white-light"]
    varying, white = (read_bundle(bundle).manifest for bundle in IN_OTHER_LIGHTS)
    assert varying.light_bin_centres_degrees
    assert not white.light_bin_centres_degrees
    assert len(white.lights) == 1


def test_the_page_lists_what_is_there() -> None:
    assert sorted(name for name in FIGURES if not name.startswith("car-")) == [bundle.name for bundle in BUNDLES]
    page = (MODELS / "README.md").read_text()
    for name, figures in FIGURES.items():
        assert f"| {name} | {figures['parameterisation']} | {figures['test']['iou']:.2f} |" in page
        assert "\n".join((figures["pictures"], *(run["command"] for run in figures["trainings"]))) in page
        folder = MODELS if name in CATEGORIES else LIGHTS
        assert (folder / f"{name}.png").stat().st_size > 10_000
        assert (folder / f"{name}-samples.png").stat().st_size > 10_000
        assert (folder / f"{name}-between.png").stat().st_size > 10_000


def test_the_samples_beside_a_model_are_those_that_it_serves(tmp_path: Path) -> None:
    script = MODELS.with_name("scripts") / "invented_sheets.py"
    sheets = {name: tmp_path / f"{name}.png" for name in ("samples", "between")}
    options = [part for name, path in sheets.items() for part in (f"--{name}", str(path))]
    subprocess.run([sys.executable, str(script), "--bundle", str(MODELS / "car"), *options], check=True)
    for name, path in sheets.items():
        shown, drawn = (
            np.asarray(Image.open(sheet).convert("RGB"), float) for sheet in (MODELS / f"car-{name}.png", path)
        )
        assert np.abs(shown - drawn).mean() < 1
