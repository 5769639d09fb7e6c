"""The bundles of trainings, made by the exporter in a process of its own: the trainer does not know it."""

import json
import re
import subprocess
import sys
from pathlib import Path

from trainer.errors import DataError
from trainer.frontier.plan import BundlePrecision
from trainer.tables.cells import Cell
from trainer.tables.study import Study


def exported(study: Study, cell: Cell, precision: BundlePrecision) -> Path:
    """The bundle of a training, exported where it is not there yet.

    Raises DataError with what the exporter says where it refuses.
    """
    bundle = study.run_directory(cell) / f"bundle-{precision}"
    manifest = bundle / "manifest.json"
    steps = study.trained(cell)["steps"]
    if manifest.exists() and json.loads(manifest.read_text(encoding="utf-8"))["training"]["step"] == steps:
        return bundle
    command = [sys.executable, "-m", "exporter", "--checkpoint", study.run_directory(cell), "--output", bundle]
    if precision != "float32":
        command += ["--precision", precision, "--images", study.validation_pictures(cell).path]
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        said = re.sub(r"[\s│╭╮╰╯─]+", " ", done.stderr).strip() or f"status {done.returncode}"
        raise DataError(f"{precision} bundle of {study.run_directory(cell)}: {said}")
    return bundle


def megabytes(bundle: Path) -> float:
    """Of all its files."""
    return sum(file.stat().st_size for file in bundle.iterdir()) / 1e6
