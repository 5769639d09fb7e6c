"""Functions compiled by numba, once for each state of the sources.

numba keeps compiled code as long as the function's own file stays as it is, although code of other files, which that
function calls, is compiled into it. Here the code is kept in a folder that is named after all files beside that file:
a kernel calls kernels of its own folder only.
"""

import functools
import hashlib
import os
import shutil
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import llvmlite
import numba
from numba import config, njit

# Compiled code that nobody has used for so long is deleted.
_RETAINED_SECONDS = 14 * 86400
# Where nothing can be written: this process's own, until it ends.
_OWN: list[tempfile.TemporaryDirectory[str]] = []


def kernel(**options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Compiles a function when it is first called, or takes it from the disk; it runs without Python's lock.

    `options` are numba.njit's. Code is kept in `__pycache__` beside the function's file, else in the user's cache
    folder, or in NUMBA_CACHE_DIR where that is set.
    """

    def decorate(function: Callable[..., Any]) -> Any:
        sources = Path(function.__code__.co_filename).resolve().parent
        chosen = config.CACHE_DIR
        # numba looks at its setting here and never again.
        config.CACHE_DIR = str(_folder(sources, chosen))
        try:
            return njit(cache=True, nogil=True, **options)(function)
        finally:
            config.CACHE_DIR = chosen

    return decorate


@functools.cache
def _folder(sources: Path, chosen: str) -> Path:
    """The folder for what is compiled from these sources; it exists and can be written."""
    digest = hashlib.sha256(f"{numba.__version__} {llvmlite.__version__}".encode())
    for file in sorted(sources.glob("*.py")):
        digest.update(file.name.encode() + b"\0" + file.read_bytes() + b"\0")
    name = f"kernels-{digest.hexdigest()[:16]}"
    home = Path(os.environ.get("XDG_CACHE_HOME") or "~/.cache").expanduser() / "chiaro" / sources.name
    for parent in [Path(chosen)] if chosen else [sources / "__pycache__", home]:
        try:
            (parent / name).mkdir(parents=True, exist_ok=True)
            tempfile.TemporaryFile(dir=parent / name).close()
            os.utime(parent / name)
            _forget_unused(parent)
        except (OSError, RuntimeError):
            continue  # It cannot be written, or nobody's home is known.
        return parent / name
    _OWN.append(tempfile.TemporaryDirectory())
    return Path(_OWN[-1].name)


def _forget_unused(parent: Path) -> None:
    for folder in parent.glob("kernels-*"):
        if folder.stat().st_mtime < time.time() - _RETAINED_SECONDS:
            # A process that still uses them compiles again.
            shutil.rmtree(folder, ignore_errors=True)
