"""A checkpoint comes back as it was, and anything else is refused in a sentence and loses nothing."""

import errno
import json
import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import torch
from safetensors import safe_open
from safetensors.torch import load_file, save_file
from torch import Tensor

from trainer.config import CameraConfig, ModelConfig, SceneConfig, TrainConfig
from trainer.errors import CheckpointError, StorageError
from trainer.model.vae import Model
from trainer.training.checkpoint import (
    FILE_NAME,
    FORMAT_VERSION,
    Checkpoint,
    load_checkpoint,
    optimiser_tensors,
    restore_optimiser,
    save_checkpoint,
)

CONFIG = TrainConfig(
    width=32, height=24, model=ModelConfig(latent=3, azimuth_bins=5, encoder_channels=(3, 4, 4, 5, 5, 6))
)


def trained(seed: int = 0, steps: int = 2) -> tuple[Checkpoint, torch.optim.Adam]:
    """A model that has taken some steps downhill, and its optimiser."""
    torch.manual_seed(seed)
    model = Model(CONFIG.model, CONFIG.width, CONFIG.height)
    optimiser = torch.optim.Adam(model.parameters(), lr=1e-2)
    for _ in range(steps):
        posterior = model.encode(torch.rand(4, 3, 24, 32))
        optimiser.zero_grad()
        everything = (model.decode(posterior.shape_mean), *posterior[:5])
        sum(part.square().sum() for part in everything).backward()
        optimiser.step()
    scene = SceneConfig(32, 24, CameraConfig(elevation_degrees=12.5), ambient=(0.1, 0.2, 0.3))
    run = {"seconds": 12.25, "pictures": 40, "images": "/pictures"}
    return Checkpoint(CONFIG, scene, "car", steps, model, optimiser_tensors(optimiser, model), run), optimiser


def assert_equal(found: dict[str, Tensor], expected: dict[str, Tensor]) -> None:
    assert found.keys() == expected.keys()
    for name, tensor in expected.items():
        assert torch.equal(found[name], tensor), name


@pytest.mark.parametrize("by_directory", [True, False])
def test_everything_comes_back(tmp_path: Path, by_directory: bool) -> None:
    before, optimiser = trained()
    path = tmp_path / "run" / FILE_NAME
    save_checkpoint(path, before)
    after = load_checkpoint(path.parent if by_directory else path)
    assert (after.config, after.scene, after.category, after.step) == (CONFIG, before.scene, "car", 2)
    assert after.run == before.run
    assert not after.model.training
    assert_equal(after.model.state_dict(), before.model.state_dict())
    assert len(after.optimiser_state) == 3 * len(list(before.model.parameters()))
    assert_equal(after.optimiser_state, before.optimiser_state)
    assert [file.name for file in path.parent.iterdir()] == [FILE_NAME]

    again = torch.optim.Adam(after.model.parameters(), lr=1e-2)
    restore_optimiser(again, after.model, after.optimiser_state)
    for model, descent in ((before.model, optimiser), (after.model, again)):
        for parameter in model.parameters():
            parameter.grad = torch.full_like(parameter, 0.1)
        descent.step()
    assert_equal(after.model.state_dict(), before.model.state_dict())


def test_a_checkpoint_holds_no_code(tmp_path: Path) -> None:
    """Nothing but tensors and one JSON text: safetensors reads it without unpickling."""
    save_checkpoint(tmp_path / FILE_NAME, trained()[0])
    with safe_open(tmp_path / FILE_NAME, framework="pt") as opened:
        header = json.loads(opened.metadata()["chiaro"])
    assert header["format_version"] == FORMAT_VERSION
    assert header["config"]["model"]["latent"] == 3


def altered(change: Callable[[dict[str, Any], dict[str, Tensor]], None]) -> Callable[[Path], None]:
    """Something that rewrites a checkpoint with another header or other tensors."""

    def rewrite(path: Path) -> None:
        with safe_open(path, framework="pt") as opened:
            header = json.loads(opened.metadata()["chiaro"])
        tensors = load_file(path)
        change(header, tensors)
        save_file(tensors, path, metadata={"chiaro": json.dumps(header)})

    return rewrite


def _drop(name: str) -> Callable[[dict[str, Any], dict[str, Tensor]], None]:
    return lambda header, tensors: tensors.__delitem__(name)


def _put(name: str, *shape: int) -> Callable[[dict[str, Any], dict[str, Tensor]], None]:
    return lambda header, tensors: tensors.__setitem__(name, torch.zeros(shape))


def _head(key: str, value: Any) -> Callable[[dict[str, Any], dict[str, Tensor]], None]:
    return lambda header, tensors: header.__setitem__(key, value)


def _setting(key: str, value: Any) -> Callable[[dict[str, Any], dict[str, Tensor]], None]:
    return lambda header, tensors: header["config"].__setitem__(key, value)


WEIGHT = "heads.shape_mean.weight"
NOT_A_CHECKPOINT = r"expected a checkpoint of chiaro, found .*Train again, or use a copy"
ANOTHER_MODEL = r"expected the model that its header describes, found .*{}.*use a copy, or train again"


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda path: path.unlink(), r"Expected a checkpoint at .*, found nothing\. Name a run directory"),
        (lambda path: path.write_bytes(b""), NOT_A_CHECKPOINT),
        (lambda path: path.write_text("no tensors, but a long enough text"), NOT_A_CHECKPOINT),
        (lambda path: path.write_bytes(path.read_bytes()[:-100]), NOT_A_CHECKPOINT),
        (lambda path: path.write_bytes(path.read_bytes()[:40]), NOT_A_CHECKPOINT),
        (lambda path: save_file({"a": torch.zeros(1)}, path), "found tensors without its header. Name a file"),
        (altered(_head("format_version", 99)), f"expected format version {FORMAT_VERSION}, found 99. Use the chiaro"),
        (altered(_head("config", {"widht": 3})), ANOTHER_MODEL.format("did you mean 'width'")),
        (altered(_setting("width", 1)), ANOTHER_MODEL.format("width from 16 to 2048, found 1")),
        (altered(_setting("width", 64)), ANOTHER_MODEL.format("size mismatch for encoder")),
        (altered(_head("run", {})), ANOTHER_MODEL.format("seconds")),
        (altered(_head("scene", None)), ANOTHER_MODEL.format("expected a table of settings, found None")),
        (altered(_drop(f"model.{WEIGHT}")), ANOTHER_MODEL.format(f"Missing key.*{WEIGHT}")),
        (altered(_put(f"model.{WEIGHT}", 2, 2)), ANOTHER_MODEL.format(f"size mismatch for {WEIGHT}")),
        (altered(_put("model.extra", 2)), ANOTHER_MODEL.format("Unexpected key.*extra")),
        (
            altered(_put(f"optimiser.exp_avg.{WEIGHT}", 2, 2)),
            ANOTHER_MODEL.format(rf"exp_avg.{WEIGHT} of size \[2, 2\]"),
        ),
        (
            altered(_drop(f"optimiser.exp_avg_sq.{WEIGHT}")),
            ANOTHER_MODEL.format(f"no optimiser.exp_avg_sq.{WEIGHT}"),
        ),
        (altered(_put("optimiser.exp_avg.extra", 2)), ANOTHER_MODEL.format("optimiser.exp_avg.extra")),
        (altered(_put(f"optimiser.other.{WEIGHT}", 3, 6)), ANOTHER_MODEL.format(f"optimiser.other.{WEIGHT}")),
    ],
)
def test_what_is_no_checkpoint_is_refused_in_a_sentence(
    tmp_path: Path, spoil: Callable[[Path], object], message: str
) -> None:
    path = tmp_path / FILE_NAME
    save_checkpoint(path, trained()[0])
    load_checkpoint(path)
    spoil(path)
    with pytest.raises(CheckpointError, match=f"(?s){message}") as refusal:
        load_checkpoint(tmp_path)
    assert FILE_NAME in str(refusal.value)


def test_a_full_disk_is_told_and_the_old_checkpoint_stays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / FILE_NAME
    before, _ = trained()
    save_checkpoint(path, before)
    old = path.read_bytes()

    def half_a_write(self: Path, content: bytes) -> int:
        with self.open("wb") as file:
            file.write(content[: len(content) // 2])
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(Path, "write_bytes", half_a_write)
    with pytest.raises(StorageError, match=r"No space left on device.*untouched: make room, then continue .*--resume"):
        save_checkpoint(path, replace(before, step=3))
    monkeypatch.undo()
    assert [entry.name for entry in tmp_path.iterdir()] == [FILE_NAME]
    assert path.read_bytes() == old
