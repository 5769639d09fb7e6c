"""Putting a directory in its place as a whole: written beside, then renamed."""

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from exporter.errors import ExportError
from service.bundle import MANIFEST_FILE
from service.manifest import DATA_FILES
from trainer.errors import StorageError


@contextmanager
def published(target: Path) -> Iterator[Path]:
    """A hidden directory beside `target`, to be filled; it becomes `target` when the block ends well.

    A bundle that was there is replaced. When anything goes wrong, `target` is as it was and nothing is left beside it.

    Raises:
        ExportError: something other than a bundle is at `target`.
        StorageError: the disk is full, or cannot be written.
    """
    target = target.absolute()
    check_replaceable(target)
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        staging = Path(tempfile.mkdtemp(prefix=f".{target.name}.", suffix=".partial", dir=target.parent))
    except OSError as error:
        raise _storage_error(target, error) from error
    try:
        yield staging
        # mkdtemp lets nobody else in; a bundle is for every reader.
        staging.chmod(0o755)
        _flush(staging)
        _replace(target, staging)
    except OSError as error:
        raise _storage_error(target, error) from error
    finally:
        shutil.rmtree(staging, ignore_errors=True)


def check_replaceable(target: Path) -> None:
    """Raises ExportError where something other than a bundle is at `target`."""
    if not target.exists():
        return
    found = {path.name for path in target.iterdir()} if target.is_dir() else {"a file"}
    foreign = sorted(found - {MANIFEST_FILE, *DATA_FILES})
    if foreign or target.is_symlink():
        found_names = ", ".join(foreign)[:200] or "a link"
        raise ExportError(
            f"{target}: expected nothing, an empty directory or a bundle there, found {found_names}; "
            "name another directory with --output, or move it away"
        )


def _flush(directory: Path) -> None:
    """What was written is on the disk, and not only on its way there, before it takes the old one's place."""
    for path in (*directory.iterdir(), directory):
        descriptor = os.open(path, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


def _replace(target: Path, staging: Path) -> None:
    if not target.exists():
        staging.rename(target)
        return
    retired = staging.with_suffix(".retired")
    target.rename(retired)
    try:
        staging.rename(target)
    except OSError:
        retired.rename(target)
        raise
    shutil.rmtree(retired, ignore_errors=True)


def _storage_error(target: Path, error: OSError) -> StorageError:
    return StorageError(
        f"{target}: expected a place to write a bundle, found: {error.strerror or error}; nothing was changed there: "
        "make room, or name another directory with --output"
    )
