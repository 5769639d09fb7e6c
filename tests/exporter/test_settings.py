"""The paper's other settings as bundles: lights that vary, and objects made of blocks."""

import json
import math
import struct
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pytest
import torch

from exporter.examples import random_pictures
from exporter.export import export
from exporter.graphs import EncoderGraph, exported_light_bin_centres
from service.bundle import read_bundle
from service.errors import BundleError
from service.findings import Origin, View, report_reconstruction, report_shape
from service.glb import write_glb
from service.inference import Engine, decode, encode, load_engine
from service.manifest import ENCODER_OUTPUTS, LIGHT_OUTPUTS
from tests.exporter.conftest import small_checkpoint
from trainer.config import ModelConfig
from trainer.model.posterior import most_probable_light
from trainer.model.vae import Model
from trainer.training.checkpoint import Checkpoint

Kind = Literal["subdivision", "ortho-block", "full-block"]


def checkpoint_with(**model: Any) -> Checkpoint:
    """The small checkpoint with other settings of its model, whose weights are large enough to say something."""
    small = small_checkpoint()
    config = replace(small.config, model=replace(small.config.model, **model))
    torch.manual_seed(5)
    lively = Model(config.model, config.width, config.height).eval()
    with torch.no_grad():
        for name, parameter in lively.named_parameters():
            if name.startswith("decoder.") or name == "heads.azimuth_logits.weight":
                parameter.mul_(20)
            elif name.startswith("heads.light"):
                parameter.mul_(3000 if name.endswith("weight") else 0)
    return replace(small, config=config, model=lively)


@pytest.fixture(scope="module")
def varying(tmp_path_factory: pytest.TempPathFactory) -> tuple[Checkpoint, Engine]:
    """A model of varying light, and the same as the service runs it; offset 25°."""
    checkpoint, directory = checkpoint_with(light="varying", light_bins=4), tmp_path_factory.mktemp("varying") / "car"
    export(checkpoint, directory, math.radians(25), {})
    return checkpoint, load_engine(read_bundle(directory))


def test_the_service_finds_the_light_that_the_model_finds(varying: tuple[Checkpoint, Engine]) -> None:
    checkpoint, engine = varying
    assert engine.manifest.light_bin_centres_degrees == (22.5, 67.5, 112.5, 157.5)
    assert set(engine.manifest.parity) == {*ENCODER_OUTPUTS, *LIGHT_OUTPUTS, "vertices", "normals"}
    images = random_pictures(8, 48, 64, torch.Generator().manual_seed(1))
    with torch.no_grad():
        expected = checkpoint.model.encode(images)
    azimuths = most_probable_light(expected)
    assert expected.light is not None
    assert azimuths is not None
    assert azimuths.std() > 0.05
    for number, image in enumerate(images):
        found = encode(engine, image.numpy()).light
        assert found is not None
        np.testing.assert_allclose(found.probabilities, expected.light.logits[number].softmax(0), atol=1e-5)
        assert found.azimuth == pytest.approx(azimuths[number].item(), abs=1e-4)
        assert found.fine_mean == pytest.approx(expected.light.fine_mean[number].item(), abs=1e-5)
        assert found.fine_deviation == pytest.approx(expected.light.fine_deviation[number].item(), abs=1e-5)


def test_the_light_needs_no_offset(varying: tuple[Checkpoint, Engine]) -> None:
    model, images = varying[0].model, torch.rand(3, 3, 48, 64)
    with torch.no_grad():
        plain, turned = EncoderGraph(model, 0.0)(images), EncoderGraph(model, 1.0)(images)
    assert len(plain) == len(ENCODER_OUTPUTS) + len(LIGHT_OUTPUTS)
    assert all(torch.equal(one, two) for one, two in zip(plain[6:], turned[6:], strict=True))
    assert exported_light_bin_centres(3) == [30, 90, 150]


def test_report_and_glb_turn_the_lights(varying: tuple[Checkpoint, Engine]) -> None:
    _, engine = varying
    posterior = encode(engine, np.random.default_rng(1).random((3, 48, 64), np.float32))
    light = posterior.light
    assert light is not None
    assert light.azimuth > 0.1
    report = report_reconstruction(engine.manifest, [View(posterior)], posterior.shape_mean, posterior.shape_deviation)
    assert report.light_azimuth_degrees == pytest.approx(math.degrees(light.azimuth), abs=1e-3)
    for turned, plain in zip(report.lights, engine.manifest.lights, strict=True):
        away = math.radians(turned.azimuth_degrees - plain.azimuth_degrees - math.degrees(light.azimuth))
        assert math.cos(away) == pytest.approx(1)
        assert -180 <= turned.azimuth_degrees < 180
    assert report.posterior is not None
    evidence = report.posterior.light
    assert evidence is not None
    assert [entry.azimuth_degrees for entry in evidence.bins] == [22.5, 67.5, 112.5, 157.5]
    assert sum(entry.probability for entry in evidence.bins) == pytest.approx(1, abs=1e-5)
    assert evidence.confidence == max(entry.probability for entry in evidence.bins)
    assert 0 <= evidence.entropy_nats <= math.log(4)

    surface = decode(engine, posterior.shape_mean)
    found = _document(write_glb(surface, engine.manifest, posterior.azimuth, asdict(report), light.azimuth))
    # An object that turns and lights that turn with it look the same from where the lights are.
    still = _document(write_glb(surface, engine.manifest, posterior.azimuth - light.azimuth, {}))
    rotations = [
        [node["rotation"] for node in document["nodes"] if node["name"].startswith("light")]
        for document in (found, still)
    ]
    np.testing.assert_allclose(rotations[0], rotations[1], atol=1e-12)
    assert found["scenes"][0]["extras"]["light_azimuth_degrees"] == report.light_azimuth_degrees
    sample = report_shape(engine.manifest, posterior.shape_mean, 0.0, Origin(seed=3))
    assert (sample.light_azimuth_degrees, sample.lights[0].azimuth_degrees) == (0, 30)


@pytest.mark.parametrize(("kind", "blocks"), [("ortho-block", 6), ("full-block", 12), ("ortho-block", 2)])
def test_each_block_is_a_node_of_its_own(kind: Kind, blocks: int, tmp_path: Path) -> None:
    named = 0 if blocks in (6, 12) else blocks
    checkpoint = checkpoint_with(parameterisation=kind, blocks=named)
    manifest = export(checkpoint, tmp_path / "car", math.radians(25), {})
    assert [block.name for block in manifest.blocks] == [f"block-{k}" for k in range(1, blocks + 1)]
    assert (manifest.vertices, len(manifest.faces)) == (24 * blocks, 44 * blocks)
    engine = load_engine(read_bundle(tmp_path / "car"))
    surface = decode(engine, np.zeros(manifest.latent, np.float32))
    document = _document(write_glb(surface, manifest, 0.3, {}))
    nodes = [node for node in document["nodes"] if "mesh" in node]
    assert [node["name"] for node in nodes] == [block.name for block in manifest.blocks]
    assert [document["meshes"][node["mesh"]]["name"] for node in nodes] == [block.name for block in manifest.blocks]


def test_a_bundle_of_varying_light_cannot_pass_for_one_of_fixed_light(tmp_path: Path) -> None:
    export(checkpoint_with(light="varying"), tmp_path / "car", 0.0, {})
    path = tmp_path / "car" / "manifest.json"
    manifest = json.loads(path.read_text())
    assert manifest.pop("light_bin_centres_degrees") == [30, 90, 150]
    path.write_text(json.dumps(manifest))
    with pytest.raises(BundleError, match=r"expected the arrays .* found .*light_azimuth"):
        read_bundle(tmp_path / "car")


def test_a_manifest_from_before_lights_varied_still_loads(exported: Path, tmp_path: Path) -> None:
    for file in exported.iterdir():
        (tmp_path / file.name).write_bytes(file.read_bytes())
    manifest = json.loads((tmp_path / "manifest.json").read_text())
    assert manifest.pop("light_bin_centres_degrees") == []
    (tmp_path / "manifest.json").write_text(json.dumps(manifest))
    engine = load_engine(read_bundle(tmp_path))
    assert encode(engine, np.zeros((3, 48, 64), np.float32)).light is None


def test_a_model_of_fixed_light_says_nothing_about_it() -> None:
    assert not Model(ModelConfig(encoder_channels=(4, 4, 4, 4, 4, 4)), 32, 24).heads.light


def _document(glb: bytes) -> dict[str, Any]:
    (length,) = struct.unpack_from("<I", glb, 12)
    document: dict[str, Any] = json.loads(glb[20 : 20 + length])
    return document
