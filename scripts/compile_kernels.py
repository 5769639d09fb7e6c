"""Uses what numba compiles once, on next to nothing, so that all that follows finds it compiled.

Two processes that meet an uncompiled kernel both compile it. `make test` therefore runs this before it shares the tests
among processes, while other tools are being installed.
"""

import tempfile
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
from command import run

from rasteriser import pictures
from rasteriser.topology import build_topology


def main() -> None:
    # A training compiles the drawing of pictures after all that is for itself: until then another core does.
    with ProcessPoolExecutor(1) as other, tempfile.TemporaryDirectory() as folder:
        drawn = other.submit(draw_a_triangle)
        rendered, directory = Path(folder) / "pictures", Path(folder) / "run"
        run("trainer", "render", "--class", "car", "--instances", 8, "--output", rendered, quiet=True)
        run("trainer", "train", "--images", rendered, "--run", directory, "--preset", "fast", "--optimiser.steps", 1,
            "--optimiser.batch-size", 4, quiet=True)  # fmt: skip
        run("trainer", "evaluate", "--checkpoint", directory, "--validation", rendered, "--images", rendered,
            "--output", Path(folder) / "found", quiet=True)  # fmt: skip
        drawn.result()


def draw_a_triangle() -> None:
    screen, white = np.array([[[0, 0, 0.5], [0, 8, 0.5], [8, 0, 0.5]]], np.float32), np.ones((1, 3, 3), np.float32)
    pictures.draw(screen, white, build_topology(np.array([[0, 1, 2]])), 8, 8)


if __name__ == "__main__":
    main()
