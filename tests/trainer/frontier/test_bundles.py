"""A bundle is made once, and what the exporter refuses is told in its own words."""

import json
from pathlib import Path

import pytest

from tests.trainer.new_model import new_model, save_model
from trainer.errors import DataError
from trainer.frontier.answering import Answerer, latencies_ms
from trainer.frontier.bundles import exported, megabytes
from trainer.frontier.plan import DEFAULT, load_plan
from trainer.frontier.trainings import study_of
from trainer.tables.cells import Cell
from trainer.tables.study import TRAINED_FILE
from trainer.training.checkpoint import FILE_NAME


@pytest.mark.slow
def test_a_bundle_is_made_once_answers_and_is_made_again_after_more_steps(tmp_path: Path) -> None:
    plan = load_plan("small")
    study, cell = study_of(plan, tmp_path), Cell("car", plan.point(DEFAULT).variant, 0)
    directory = study.run_directory(cell)
    directory.mkdir(parents=True)
    (directory / TRAINED_FILE).write_text(json.dumps({"steps": 1, "seconds": 1.0, "core_seconds": 1.0}))
    with pytest.raises(DataError, match=r"float32 bundle of .*Expected a checkpoint at"):
        exported(study, cell, "float32")

    save_model(directory / FILE_NAME, new_model())
    bundle = exported(study, cell, "float32")
    written = (bundle / "manifest.json").stat().st_mtime_ns
    assert exported(study, cell, "float32") == bundle
    assert (bundle / "manifest.json").stat().st_mtime_ns == written
    assert megabytes(bundle) == sum(len(file.read_bytes()) for file in bundle.iterdir()) / 1e6
    # Six boxes of eight corners, or of 24 with normals of their own.
    vertices = Answerer(bundle).answer()
    assert vertices.shape[0] == 1
    assert vertices.shape[1] % 48 == 0
    times = latencies_ms({"one": bundle, "same": bundle}, turns=3)
    assert 0.2 < times["one"] / times["same"] < 5

    # The training went on; the exporter must be asked again.
    (directory / TRAINED_FILE).write_text(json.dumps({"steps": 2, "seconds": 2.0, "core_seconds": 2.0}))
    (directory / FILE_NAME).unlink()
    with pytest.raises(DataError, match="Expected a checkpoint at"):
        exported(study, cell, "float32")
