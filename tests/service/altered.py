"""Bundles as somebody else would alter them: what depends on a file follows."""

import hashlib
import io
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import onnx

from service.manifest import model_identity


def edit_manifest(directory: Path, edit: Callable[[dict[str, Any]], object]) -> None:
    manifest = json.loads((directory / "manifest.json").read_text())
    edit(manifest)
    (directory / "manifest.json").write_text(json.dumps(manifest))


def replace_file(directory: Path, name: str, content: bytes) -> None:
    """Replaces a file as its author would: digest and identity follow."""
    (directory / name).write_bytes(content)

    def adopt(manifest: dict[str, Any]) -> None:
        manifest["files"][name] = hashlib.sha256(content).hexdigest()
        manifest["identity"] = model_identity(manifest["files"])

    edit_manifest(directory, adopt)


def edit_graph(directory: Path, name: str, edit: Callable[[onnx.ModelProto], object]) -> None:
    model = onnx.load(directory / name)
    edit(model)
    replace_file(directory, name, model.SerializeToString())


def replace_probe(directory: Path, **arrays: np.ndarray) -> None:
    with np.load(directory / "probe.npz") as archive:
        content = {**archive, **arrays}
    buffer = io.BytesIO()
    np.savez(buffer, allow_pickle=True, **content)
    replace_file(directory, "probe.npz", buffer.getvalue())
