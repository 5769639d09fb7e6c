"""Reading a bundle: a directory of `manifest.json`, `encoder.onnx`, `decoder.onnx` and `probe.npz`.

A bundle is read once, and what is checked is what is used: sizes before reading, digests over the bytes in memory, and
the graphs are loaded from those bytes. Nothing in a bundle is executed but the two ONNX graphs, and no pickle is read.
"""

import errno
import hashlib
import io
import os
import stat
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from service.errors import BundleError
from service.manifest import (
    DATA_FILES,
    DECODER_FILE,
    DECODER_INPUT,
    DECODER_OUTPUTS,
    ENCODER_FILE,
    ENCODER_INPUT,
    PROBE_FILE,
    Manifest,
    decode_manifest,
    encoder_outputs,
    tensor_shapes,
)

MANIFEST_FILE: Final = "manifest.json"
LARGEST_PROBE_BATCH: Final = 16

_LARGEST_BYTES: Final = {
    MANIFEST_FILE: 16 * 2**20,
    ENCODER_FILE: 512 * 2**20,
    DECODER_FILE: 512 * 2**20,
    PROBE_FILE: 64 * 2**20,
}


@dataclass(frozen=True)
class Bundle:
    """A bundle in memory, its digests verified; `probe` maps names of `probe_arrays` to float32 arrays [N, ...]."""

    path: Path
    manifest: Manifest
    encoder: bytes
    decoder: bytes
    probe: dict[str, NDArray[np.float32]]


def probe_arrays(manifest: Manifest) -> tuple[str, ...]:
    """The names of a probe's arrays: inputs and outputs of both graphs."""
    return ENCODER_INPUT, *encoder_outputs(manifest), DECODER_INPUT, *DECODER_OUTPUTS


def read_bundle(directory: Path) -> Bundle:
    """The bundle in a directory; other files beside its four are ignored.

    Raises:
        BundleError: the directory or a file is missing, is a link, is too large, was altered, or is of another format.
    """
    if not directory.is_dir():
        raise BundleError(f"{directory}: expected a bundle's directory, found none; export a model there first")
    manifest = decode_manifest(_read_file(directory / MANIFEST_FILE), str(directory / MANIFEST_FILE))
    contents = {name: _read_file(directory / name) for name in DATA_FILES}
    for name, content in contents.items():
        found = hashlib.sha256(content).hexdigest()
        if found != manifest.files[name]:
            raise BundleError(
                f"{directory / name}: expected sha256 {manifest.files[name][:12]}…, found {found[:12]}…: the file was "
                "altered or belongs to another model; export the bundle again"
            )
    probe = _read_probe(contents[PROBE_FILE], manifest, str(directory / PROBE_FILE))
    return Bundle(directory, manifest, contents[ENCODER_FILE], contents[DECODER_FILE], probe)


def _read_file(path: Path) -> bytes:
    """The content of a regular file that is no link and no larger than its kind may be."""
    limit = _LARGEST_BYTES[path.name]
    try:
        with open(path, "rb", opener=_open_without_surprise) as file:
            content = file.read(limit + 1)
    except OSError as error:
        raise BundleError(
            f"{path}: expected a regular file that can be read, found: {error.strerror}; export the bundle again"
        ) from None
    if len(content) > limit:
        raise BundleError(f"{path}: expected at most {limit} bytes, found more; export the bundle again")
    return content


def _open_without_surprise(path: str, flags: int) -> int:
    # A link could lead anywhere, and without O_NONBLOCK a named pipe would hold the service up for ever.
    descriptor = os.open(path, flags | os.O_NOFOLLOW | os.O_NONBLOCK)
    if not stat.S_ISREG(os.fstat(descriptor).st_mode):
        os.close(descriptor)
        raise OSError(errno.EINVAL, "Not a regular file")
    return descriptor


def _read_probe(content: bytes, manifest: Manifest, where: str) -> dict[str, NDArray[np.float32]]:
    shapes, names = tensor_shapes(manifest), probe_arrays(manifest)
    # zipfile and numpy answer damage with whatever they stumble over (BadZipFile, ValueError, struct.error, TokenError,
    # …): any of it means that the file is at fault.
    try:
        archive = zipfile.ZipFile(io.BytesIO(content))
    except Exception as error:
        raise BundleError(
            f"{where}: expected an .npz archive, found: {str(error)[:200]}; export the bundle again"
        ) from error
    with archive:
        found = sorted(archive.namelist())
        expected = sorted(f"{name}.npy" for name in names)
        if found != expected:
            raise BundleError(
                f"{where}: expected the arrays {', '.join(expected)}, found {', '.join(found)[:200]}; "
                "export the bundle again"
            )
        arrays = {name: _read_array(archive, name, shapes[name], where) for name in names}
    batches = {len(array) for array in arrays.values()}
    if len(batches) != 1:
        raise BundleError(
            f"{where}: expected arrays of one batch size, found {sorted(batches)}; export the bundle again"
        )
    return arrays


def _read_array(archive: zipfile.ZipFile, name: str, shape: tuple[int, ...], where: str) -> NDArray[np.float32]:
    """One member of the archive. Its size is known before it is inflated, and its header is read as data: no pickle."""
    largest = LARGEST_PROBE_BATCH * 4 * int(np.prod(shape, dtype=np.int64)) + 1024
    member = archive.getinfo(f"{name}.npy")
    if member.file_size > largest:
        raise BundleError(
            f"{where}: {name}: expected at most {largest} bytes, found {member.file_size}; export the bundle again"
        )
    try:
        stream = io.BytesIO(archive.read(member))
        version = np.lib.format.read_magic(stream)
        found_shape, fortran, dtype = np.lib.format.read_array_header_1_0(stream)
    except Exception as error:
        raise BundleError(
            f"{where}: {name}: expected a NumPy array, found: {str(error)[:200]}; export the bundle again"
        ) from error
    data = stream.read()
    right = (
        version == (1, 0)
        and not fortran
        and dtype == np.dtype("<f4")
        and len(found_shape) == 1 + len(shape)
        and 1 <= found_shape[0] <= LARGEST_PROBE_BATCH
        and found_shape[1:] == shape
        and len(data) == 4 * int(np.prod(found_shape, dtype=np.int64))
    )
    if not right:
        raise BundleError(
            f"{where}: {name}: expected float32 [1 to {LARGEST_PROBE_BATCH}, {', '.join(map(str, shape))}], "
            f"found {dtype} {list(found_shape)} in {len(data)} bytes; export the bundle again"
        )
    array = np.frombuffer(data, "<f4").reshape(found_shape)
    if not np.isfinite(array).all():
        raise BundleError(f"{where}: {name}: expected finite numbers, found others; export the bundle again")
    return array
