"""A sheet of what a bundle invents: the objects of the first seeds, as the service draws them, each from four sides.

python scripts/samples_sheet.py --bundle models/car --output models/car-samples.png
"""

import argparse
import io
import math
from pathlib import Path
from typing import Final

import numpy as np
from jaxtyping import Float32
from numpy import ndarray
from PIL import Image

from imaging.srgb import decode_table
from service.bundle import read_bundle
from service.generation import sample
from service.inference import Engine, load_engine
from trainer.evaluation.sheet import write_sheet

SIDES_DEGREES: Final = (-45, 45, 135, -135)
COUNT: Final = 6
WIDTH: Final = 160
"""Of each picture, pixels."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bundle", type=Path, required=True, help="a directory that python -m exporter has written")
    parser.add_argument("--output", type=Path, required=True, help="PNG to write")
    arguments = parser.parse_args()
    write_samples(arguments.bundle, arguments.output)


def write_samples(bundle: Path, output: Path) -> None:
    engine = load_engine(read_bundle(bundle))
    rows = [[_picture(engine, seed, side) for side in SIDES_DEGREES] for seed in range(COUNT)]
    write_sheet(output, rows, [f"from {side:+d}°" for side in SIDES_DEGREES])


def _picture(engine: Engine, seed: int, side: int) -> Float32[ndarray, "H W 3"]:
    """In linear light."""
    with Image.open(io.BytesIO(sample(engine, seed, azimuth=math.radians(side), form="png").content)) as drawn:
        codes = np.asarray(
            drawn.convert("RGB").resize((WIDTH, WIDTH * drawn.height // drawn.width), Image.Resampling.BOX)
        )
    return decode_table()[codes]


if __name__ == "__main__":
    main()
