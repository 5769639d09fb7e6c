"""A bundle becomes a run again, which says what the bundle says, and can learn on."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import torch
from torch import Tensor

from exporter.restoring import main, restored
from imaging.srgb import decode_table
from service.bundle import MANIFEST_FILE, read_bundle
from service.manifest import encode_manifest
from service.thrift import Precision
from tests.exporter.conftest import small_checkpoint
from tests.trainer.training.runs import EVERY_STEP, silent
from trainer.data.images import ImageSet
from trainer.data.plan import RenderSettings
from trainer.data.render import render_folder
from trainer.evaluation.pictures import load_as_seen
from trainer.model.vae import Model
from trainer.training.checkpoint import FILE_NAME, load_checkpoint, save_checkpoint
from trainer.training.reframing import reframe


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Pictures of twelve cars in the small model's scene."""
    directory = tmp_path_factory.mktemp("pictures")
    render_folder(directory, RenderSettings("car"), small_checkpoint().scene, 12, 1, 1, False)
    return directory


@pytest.fixture(scope="module")
def images(folder: Path) -> ImageSet:
    return load_as_seen(folder, small_checkpoint().scene)


@pytest.fixture
def copy(exported: Path, tmp_path: Path) -> Path:
    """The bundle, to be altered."""
    directory = tmp_path / "bundle"
    directory.mkdir()
    for file in exported.iterdir():
        (directory / file.name).write_bytes(file.read_bytes())
    return directory


def answers(model: Model, pictures: Tensor) -> list[Tensor]:
    """All that it says of pictures, and the vertices that it makes of it."""
    with torch.inference_mode():
        posterior = model.encode(pictures)
        numbers = [part for part in posterior if isinstance(part, Tensor)]
        return [*numbers, model.decode(posterior.shape_mean)]


def linear(images: ImageSet) -> Tensor:
    return torch.from_numpy(decode_table()[images.pictures])


def test_it_says_what_the_bundle_s_model_said(exported: Path, folder: Path, images: ImageSet) -> None:
    before, after = small_checkpoint(), restored(exported, folder)
    assert (after.config, after.scene, after.category, after.step) == (before.config, before.scene, "car", 12)
    for expected, found in zip(
        answers(before.model, linear(images)), answers(after.model, linear(images)), strict=True
    ):
        assert torch.allclose(found, expected, rtol=1e-4, atol=1e-5)


def test_layers_that_normalise_by_the_batch_change_nothing_of_pictures_that_they_know(
    exported: Path, folder: Path, images: ImageSet
) -> None:
    """So it learns on from where it was."""
    model, pictures = restored(exported, folder).model, linear(images)
    evaluated, brighter = answers(model, pictures), answers(model, 2 * pictures)
    for expected, found in zip(evaluated, answers(model.train(), pictures), strict=True):
        assert torch.allclose(found, expected, rtol=1e-2, atol=1e-3)
    # As bright again, a batch looks the same once it is normalised.
    normalised = answers(model, 2 * pictures)
    assert (normalised[0] - evaluated[0]).norm() < 0.1 * (brighter[0] - evaluated[0]).norm()


def test_the_last_phase_goes_on_from_it(
    exported: Path, folder: Path, images: ImageSet, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["--bundle", str(exported), "--images", str(folder), "--run", str(tmp_path / "run")]
    assert main(arguments) == 0
    assert "car, step 12, without the encoder's last phase" in capsys.readouterr().out
    before = load_checkpoint(tmp_path / "run")
    assert before.reframing_steps == 0
    assert before.run["restored_from"]["seconds"] == before.run["seconds"] == 1.5
    reframe(before, tmp_path / "run", images, 2, EVERY_STEP, silent)
    after = load_checkpoint(tmp_path / "run")
    assert (after.step, after.reframing_steps) == (12, 2)
    assert after.run["restored_from"] == before.run["restored_from"]
    assert main(arguments) == 2
    assert "expected no training there yet, found one" in capsys.readouterr().err


def test_the_lattice_inside_of_shapes_which_no_bundle_holds_begins_anew(
    copy: Path, folder: Path, tmp_path: Path
) -> None:
    manifest = read_bundle(copy).manifest
    training: Any = manifest.training
    loss = {**training["config"]["loss"], "inversion_weight": 1.0, "inner_points": "learnt"}
    config = {**training["config"], "loss": loss}
    (copy / MANIFEST_FILE).write_bytes(encode_manifest(replace(manifest, training={**training, "config": config})))
    save_checkpoint(tmp_path / FILE_NAME, restored(copy, folder))
    lattice = load_checkpoint(tmp_path).model.lattice
    assert lattice is not None
    assert not lattice.offsets.weight.any()


def test_a_bundle_that_lacks_something_of_its_training_is_refused(copy: Path, folder: Path) -> None:
    manifest = read_bundle(copy).manifest
    assert manifest.parsimony is not None
    slim = replace(manifest.parsimony, trained_latent=7, removed_blocks=("block-2",))
    (copy / MANIFEST_FILE).write_bytes(encode_manifest(replace(manifest, parsimony=slim)))
    with pytest.raises(Exception, match="found one that does without 2 numbers of its shape code and 1 blocks"):
        restored(copy, folder)
    coarse = Precision("int8", "float32", 20, {}, {})
    (copy / MANIFEST_FILE).write_bytes(encode_manifest(replace(manifest, precision=coarse)))
    with pytest.raises(Exception, match="found int8"):
        restored(copy, folder)


def test_no_bundle_no_run(tmp_path: Path, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["--bundle", str(tmp_path / "none"), "--images", str(folder), "--run", str(tmp_path / "run")]
    assert main(arguments) == 2
    assert "expected a bundle's directory, found none" in capsys.readouterr().err
    assert not (tmp_path / "run").exists()
