"""What turning objects does to poses (`train --fronts alike`, `quarters`): every bundle of fixed light.

    python -m benchmarks.fronts --models models

Poses as a second training would be told them, of pictures of procedural objects that no training or validation saw.
Writes a JSON file with the machine and, for each bundle, the share of azimuths within 30° and of flipped ones (by 150°
or more) as they are found, turned alike, and turned by quarters, and how many objects were turned. A frame that is a
multiple of 90° beside the class's own counts as good as that: which side of an object is called its front is nobody's
to know.
"""

import argparse
import io
import math
import sys
import tempfile
from pathlib import Path
from typing import Any, get_args

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from rich.console import Console

from benchmarks.bundles import TEST_SEED, measure_bundles, rendered
from trainer.commands.teaching import Fronts, told_poses
from trainer.data.images import ImageSet
from trainer.evaluation.bundle import from_bundle
from trainer.evaluation.pictures import load_as_seen

PLACES = 4


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--models", type=Path, default=Path("models"), help="a directory of bundles")
    parser.add_argument("--only", nargs="*", help="names of bundles; all, if absent")
    parser.add_argument("--objects", type=int, default=400, help="procedural objects, in one picture each")
    parser.add_argument("--output", type=Path, default=Path("docs/results/fronts.json"))
    measure_bundles("benchmarks.fronts", parser.parse_args(), measured)
    return 0


def measured(bundle: Path, arguments: argparse.Namespace) -> dict[str, Any]:
    """All figures of one bundle."""
    subject = from_bundle(bundle)
    with tempfile.TemporaryDirectory() as place:
        folder = rendered(Path(place), subject, TEST_SEED, arguments.objects)
        images = load_as_seen(folder, subject.scene)
        quiet = Console(file=io.StringIO())
        told = {fronts: _azimuths(told_poses(images, folder, subject, fronts, quiet)) for fronts in get_args(Fronts)}
    truth = _azimuths(images)
    return {
        **{fronts: _right(azimuths, truth) for fronts, azimuths in told.items()},
        "turned": _turned(told["found"], told["alike"]),
        "turned_by_quarters": _turned(told["found"], told["quarters"]),
    }


def _azimuths(images: ImageSet) -> Float[ndarray, "N"]:
    assert images.azimuths is not None
    return images.azimuths


def _turned(found: Float[ndarray, "N"], told: Float[ndarray, "N"]) -> float:
    """The share that is told otherwise, by a quarter of a turn at least."""
    return round(float((np.cos(found - told) < math.cos(math.pi / 4)).mean()), PLACES)


def _right(azimuths: Float[ndarray, "N"], truth: Float[ndarray, "N"]) -> dict[str, float]:
    """In the frame that is best of four."""
    frames = np.arange(4)[:, None] * 90
    errors = np.abs((np.rad2deg(azimuths - truth) + frames + 180) % 360 - 180)
    best = errors[(errors < 30).mean(1).argmax()]
    shares = {"azimuth_accuracy": best < 30, "flipped": best > 150}
    return {name: round(float(share.mean()), PLACES) for name, share in shares.items()}


if __name__ == "__main__":
    sys.exit(main())
