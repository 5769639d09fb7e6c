"""What it costs accuracy to have to cut an object out, and that it is exposed otherwise: every bundle of fixed light.

    python -m benchmarks.cutouts --models models --real-meshes DIR

Pictures of procedural objects that no training or validation saw, and of real meshes, if any, are judged as they are,
in the model's own frame; and cut out and set there by rule, as anybody's own pictures are: with their light, with half
of it, and with twice as much. Writes a JSON file with the machine and the judge's figures of each.
"""

import argparse
import io
import sys
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import UInt8
from numpy import ndarray
from PIL import Image

from benchmarks.bundles import TEST_SEED, VALIDATION_SEED, add_options, measure_bundles, rendered
from imaging.srgb import decode_table, encode
from service.bundle import read_bundle
from service.errors import ImageError
from service.image import read_picture
from service.inference import Engine, load_engine
from trainer.evaluation.bundle import from_bundle
from trainer.evaluation.pictures import Pictures, Validation, from_folder, from_meshes, validation_from
from trainer.evaluation.protocol import judge
from trainer.evaluation.report import as_json
from trainer.evaluation.subject import Subject

MOST_PIXELS = 10**6
LIGHTS = {"cut out": 1.0, "darker": 0.5, "brighter": 2.0}
"""Times the light of the pictures that are cut out."""
FIGURES = (
    "iou",
    "symmetric_azimuth_error_degrees",
    "symmetric_azimuth_accuracy",
    "flipped",
    "untempered_calibration_error",
    "objects",
    "pictures",
)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_options(parser, 200, 6, Path("benchmarks/cutouts.json"))
    measure_bundles("benchmarks.cutouts", parser.parse_args(), measured)
    return 0


def measured(bundle: Path, arguments: argparse.Namespace) -> dict[str, Any]:
    """All figures of one bundle."""
    subject, engine = from_bundle(bundle), load_engine(read_bundle(bundle))
    with tempfile.TemporaryDirectory() as folder:
        validation = validation_from(rendered(Path(folder), subject, VALIDATION_SEED, arguments.objects), subject.scene)
        test = from_folder(rendered(Path(folder), subject, TEST_SEED, arguments.objects), subject.scene)
    found = {"test": _judged(subject, engine, test, validation)}
    meshes = arguments.real_meshes and arguments.real_meshes / subject.category
    if meshes and meshes.is_dir():
        real = from_meshes(meshes, subject.scene, arguments.views)
        found["real_meshes"] = _judged(subject, engine, real, validation)
    return found


def _judged(subject: Subject, engine: Engine, pictures: Pictures, validation: Validation) -> dict[str, Any]:
    """The judge's figures of pictures as they are, and cut out in any of the lights."""
    found = {"framed": _figures(subject, pictures, validation)}
    for name, gain in LIGHTS.items():
        exposed = encode(np.clip(gain * decode_table()[pictures.codes], 0, 1))
        codes = np.stack([_cut_out(engine, one) for one in exposed])
        found[name] = _figures(subject, replace(pictures, codes=codes), validation)
    return found


def _figures(subject: Subject, pictures: Pictures, validation: Validation) -> dict[str, Any]:
    report = as_json(judge(subject, pictures, validation).report)
    return {figure: report[figure] for figure in FIGURES}


def _cut_out(engine: Engine, codes: UInt8[ndarray, "3 H W"]) -> UInt8[ndarray, "3 H W"]:
    """A picture as it is after it was sent as a file whose object had to be cut out; as it was, where that fails."""
    buffer = io.BytesIO()
    Image.fromarray(np.pad(codes, ((0, 0), (8, 8), (8, 8))).transpose(1, 2, 0)).save(buffer, "PNG")
    size, camera = engine.manifest.picture, engine.manifest.camera
    try:
        prepared = read_picture(
            buffer.getvalue(),
            size.width,
            size.height,
            MOST_PIXELS,
            camera.distance,
            camera.field_of_view_degrees,
            keep_framed=False,
            zoom=size.zoom,
        )
    except ImageError:
        return codes
    return encode(prepared.picture)


if __name__ == "__main__":
    sys.exit(main())
