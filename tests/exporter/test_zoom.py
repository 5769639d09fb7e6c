"""A model that looks at the middle of its pictures: the trainer, the service and the judge show it the same."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from exporter.export import export
from imaging.srgb import decode_table
from service.bundle import read_bundle
from service.image import read_picture
from tests.exporter.conftest import OFFSET
from trainer.data.images import load_image_folder
from trainer.data.lens import zoomed
from trainer.data.plan import RenderSettings
from trainer.data.render import render_folder
from trainer.evaluation.bundle import from_bundle
from trainer.training.checkpoint import Checkpoint


@pytest.mark.usefixtures("converted")
def test_the_service_and_the_judge_zoom_as_the_training_did(checkpoint: Checkpoint, tmp_path: Path) -> None:
    pictures, bundle = tmp_path / "pictures", tmp_path / "car"
    wide = replace(checkpoint.scene, width=128, height=96)
    render_folder(pictures, RenderSettings("car"), wide, 24, 1, 1, show_progress=False)
    scene = zoomed(checkpoint.scene, 1.4)
    shown = load_image_folder(pictures, scene.width, scene.height, scene)
    files = [(pictures / name).read_bytes() for name in shown.names]
    export(replace(checkpoint, scene=scene), bundle, OFFSET, {}, held_out=files)

    manifest = read_bundle(bundle).manifest
    assert manifest.picture.zoom == 1.4
    assert manifest.camera.field_of_view_degrees == scene.camera.field_of_view_degrees
    assert manifest.held_out is not None
    assert manifest.held_out.framed is not None
    for content, codes in zip(files, shown.pictures, strict=True):
        size, camera = manifest.picture, manifest.camera
        prepared = read_picture(
            content, size.width, size.height, 10**6, camera.distance, camera.field_of_view_degrees, zoom=size.zoom
        )
        assert prepared.method == "framed"
        np.testing.assert_allclose(prepared.picture, decode_table()[codes], atol=0.01)
    assert from_bundle(bundle).scene == scene
