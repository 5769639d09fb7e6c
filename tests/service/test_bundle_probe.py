"""A bundle whose probe is wrong, huge or broken is refused with a sentence."""

import io
import struct
import zipfile
from pathlib import Path

import numpy as np
import pytest

from service.bundle import read_bundle
from service.errors import BundleError
from tests.service.altered import replace_file, replace_probe


@pytest.mark.parametrize(
    ("arrays", "sentence"),
    [
        ({"vertices": np.zeros((2, 98, 3))}, r"vertices: expected float32 .* found float64"),
        ({"vertices": np.zeros((3, 98, 3), np.float32)}, "one batch size, found"),
        ({"vertices": np.zeros((99, 98, 3), np.float32)}, "vertices: expected at most .* bytes, found"),
        ({"azimuth": np.full(2, np.nan, np.float32)}, "azimuth: expected finite numbers"),
        ({"surprise": np.zeros(2, np.float32)}, "expected the arrays .* surprise.npy"),
        ({"azimuth": np.array([{}, {}], object)}, "azimuth: expected float32 .* found object"),
        ({"shape_codes": np.asfortranarray(np.zeros((2, 12), np.float32))}, r"shape_codes: expected float32 \[1 to 16"),
    ],
)
def test_a_wrong_probe_is_refused(copy: Path, arrays: dict[str, np.ndarray], sentence: str) -> None:
    replace_probe(copy, **arrays)
    with pytest.raises(BundleError, match=sentence):
        read_bundle(copy)


def replace_probe_file(directory: Path, name: str, data: bytes) -> None:
    """Replaces one file of the probe's archive."""
    with zipfile.ZipFile(directory / "probe.npz") as archive:
        content = {member: archive.read(member) for member in archive.namelist()}
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for member, old in content.items():
            archive.writestr(member, data if member == name else old)
    replace_file(directory, "probe.npz", buffer.getvalue())


def test_a_probe_that_claims_to_be_huge_is_refused(copy: Path) -> None:
    header = io.BytesIO()
    np.lib.format.write_array_header_1_0(header, {"descr": "<f4", "fortran_order": False, "shape": (2, 10**12)})
    replace_probe_file(copy, "shape_codes.npy", header.getvalue())
    with pytest.raises(BundleError, match=r"shape_codes: expected float32 .* found float32 \[2, 1000000000000\]"):
        read_bundle(copy)


@pytest.mark.parametrize(
    "header",
    [
        # Found by fuzzing: numpy takes it for a header that Python 2 wrote, and answers with an error of its tokenizer.
        b"{'descr': '<f4', 'fortran_order': False, 'shape': (2, 12",
        b"'",
        b"",
        b"(" * 500,
        b"{'descr': 'V', 'fortran_order': 0, 'shape': ()}",
    ],
)
def test_a_probe_with_a_broken_header_is_refused(copy: Path, header: bytes) -> None:
    replace_probe_file(copy, "shape_codes.npy", b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header)
    with pytest.raises(BundleError, match=r"probe.npz: shape_codes: expected (a NumPy array|float32 .*), found"):
        read_bundle(copy)
