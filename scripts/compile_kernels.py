"""Uses what numba compiles once, on next to nothing, so that all that follows finds it compiled.

Two processes that meet an uncompiled kernel both compile it. `make test` therefore runs this before it shares the tests
among processes, while other tools are being installed.
"""

import tempfile
from pathlib import Path

from command import run


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        pictures, directory = Path(folder) / "pictures", Path(folder) / "run"
        run("trainer", "render", "--class", "car", "--instances", 8, "--output", pictures, quiet=True)
        run("trainer", "train", "--images", pictures, "--run", directory, "--preset", "quick", "--optimiser.steps", 1,
            "--optimiser.batch-size", 4, quiet=True)  # fmt: skip
        run("trainer", "evaluate", "--checkpoint", directory, "--validation", pictures, "--images", pictures,
            "--output", Path(folder) / "found", quiet=True)  # fmt: skip


if __name__ == "__main__":
    main()
