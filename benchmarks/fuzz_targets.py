"""What is fuzzed: the readers of anybody's bytes, as the service calls them.

Each target takes a file's content. It returns where the reader accepts the file or refuses it by its documented error;
whatever else it raises is a fault.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Final, Literal, get_args

from benchmarks.fuzz_seeds import bundle, pictures, sealed
from service.bundle import MANIFEST_FILE, read_bundle
from service.errors import BundleError, ImageError
from service.image import check_pixels, read_picture
from service.inference import load_engine
from service.manifest import DATA_FILES, DECODER_FILE, ENCODER_FILE, PROBE_FILE

Name = Literal["pictures", "manifests", "probes", "encoders", "decoders"]
NAMES: Final[tuple[Name, ...]] = get_args(Name)
Target = Callable[[bytes], None]

WIDTH, HEIGHT = 48, 36
MOST_PIXELS: Final = 16_384
"""Larger pictures are refused: they take the same ways, and longer."""

_FILES: Final = {
    "manifests": MANIFEST_FILE,
    "probes": PROBE_FILE,
    "encoders": ENCODER_FILE,
    "decoders": DECODER_FILE,
}


def seeds_of(name: Name) -> dict[str, bytes]:
    """The files that a target begins with, by name."""
    return pictures() if name == "pictures" else {_FILES[name]: bundle()[_FILES[name]]}


def target_of(name: Name, folder: Path) -> Target:
    """The function that is fuzzed; what it reads from a file lies in the folder."""
    return _read_picture if name == "pictures" else _bundle_reader(_FILES[name], folder)


def _read_picture(content: bytes) -> None:
    try:
        check_pixels([content], MOST_PIXELS)
        found = read_picture(content, WIDTH, HEIGHT, MOST_PIXELS)
    except ImageError:
        return
    picture = found.picture
    if picture.shape != (3, HEIGHT, WIDTH) or not (picture.min() >= 0 and picture.max() <= 1):
        raise ValueError(
            f"expected [3, {HEIGHT}, {WIDTH}] in 0 to 1, found {picture.shape} in {picture.min()} to {picture.max()}"
        )


def _bundle_reader(file: str, folder: Path) -> Target:
    """Reads a bundle, one of whose files has some content, and loads it where that is a graph; its manifest tells the
    digests that the files have."""
    whole = bundle()
    for name, content in whole.items():
        (folder / name).write_bytes(content)

    def read(content: bytes) -> None:
        (folder / file).write_bytes(content)
        if file != MANIFEST_FILE:
            (folder / MANIFEST_FILE).write_bytes(sealed({**{name: whole[name] for name in DATA_FILES}, file: content}))
        try:
            found = read_bundle(folder)
            if file in (ENCODER_FILE, DECODER_FILE):
                load_engine(found)
        except BundleError:
            return

    return read
