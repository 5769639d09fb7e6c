"""Files that appear whole or not at all: written beside their place, then renamed into it."""

import io
import os
from pathlib import Path

from PIL import Image

from trainer.errors import StorageError

AGAIN = "Make room or choose another place, then run the same command again; finished files are kept."


def write_bytes(path: Path, content: bytes, advice: str = AGAIN, durable: bool = False) -> None:
    """Writes a file and, if need be, its folder; `durable` waits until it would survive a power failure.

    Raises StorageError, which ends in `advice`, and leaves what was there before, where the disk is full or the place
    cannot be written.
    """
    beside = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        try:
            _write(beside, content, durable)
        except FileNotFoundError:
            path.parent.mkdir(parents=True, exist_ok=True)
            _write(beside, content, durable)
        os.replace(beside, path)
    except OSError as error:
        _discard(beside)
        raise StorageError(
            f"could not write {path} ({len(content)} bytes): {error.strerror or error}. {advice}"
        ) from error
    except BaseException:
        _discard(beside)
        raise


def write_png(path: Path, picture: Image.Image) -> None:
    """Writes a PNG, lightly compressed; see `write_bytes`."""
    buffer = io.BytesIO()
    picture.save(buffer, "PNG", compress_level=1)
    write_bytes(path, buffer.getvalue())


def discard_parts(folder: Path) -> None:
    """Deletes what killed processes have left half-written in a folder that nobody else writes into."""
    for part in folder.glob(".*.part"):
        _discard(part)


def _write(path: Path, content: bytes, durable: bool) -> None:
    path.write_bytes(content)
    if durable:
        with path.open("rb") as file:
            os.fsync(file.fileno())


def _discard(path: Path) -> None:
    try:
        path.unlink(missing_ok=True)
    except OSError:
        return
