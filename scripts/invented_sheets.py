"""Sheets of what a bundle invents, as the service draws it: the objects of the first seeds, each from four sides, and
what lies between two of them.

python scripts/invented_sheets.py --bundle models/car --samples car-samples.png --between car-between.png
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
from service.generation import interpolate, sample
from service.inference import load_engine
from trainer.evaluation.sheet import write_sheet

SIDES_DEGREES: Final = (-45, 45, 135, -135)
COUNT: Final = 6
PASSAGES: Final = ((0, 1), (2, 3), (4, 5))
"""From which seed to which."""
STATIONS: Final = (0.0, 0.25, 0.5, 0.75, 1.0)
WIDTH: Final = 160
"""Of each picture, pixels."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bundle", type=Path, required=True, help="a directory that python -m exporter has written")
    parser.add_argument("--samples", type=Path, required=True, help="PNG to write, a row an object")
    parser.add_argument("--between", type=Path, required=True, help="PNG to write, a row from one object to another")
    arguments = parser.parse_args()
    write_invented(arguments.bundle, arguments.samples, arguments.between)


def write_invented(bundle: Path, samples: Path, between: Path) -> None:
    engine = load_engine(read_bundle(bundle))
    rows = [
        [_picture(sample(engine, seed, azimuth=math.radians(side), form="png").content) for side in SIDES_DEGREES]
        for seed in range(COUNT)
    ]
    write_sheet(samples, rows, [f"from {side:+d}°" for side in SIDES_DEGREES])
    rows = [
        [
            _picture(interpolate(engine, *seeds, t, azimuth=math.radians(SIDES_DEGREES[0]), form="png").content)
            for t in STATIONS
        ]
        for seeds in PASSAGES
    ]
    write_sheet(between, rows, [f"{t:.0%}" for t in STATIONS])


def _picture(png: bytes) -> Float32[ndarray, "H W 3"]:
    """In linear light."""
    with Image.open(io.BytesIO(png)) as drawn:
        codes = np.asarray(
            drawn.convert("RGB").resize((WIDTH, WIDTH * drawn.height // drawn.width), Image.Resampling.BOX)
        )
    return decode_table()[codes]


if __name__ == "__main__":
    main()
