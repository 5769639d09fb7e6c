"""Bundles that are altered, foreign or hostile are refused with a sentence that says what to do."""

import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from service.bundle import Bundle, read_bundle
from service.catalogue import read_catalogue
from service.errors import BundleError
from service.inference import load_engine
from service.manifest import decode_manifest, encode_manifest
from tests.service.altered import edit_manifest


def test_manifest_survives_the_round_trip(bundle: Bundle) -> None:
    assert decode_manifest(encode_manifest(bundle.manifest), "here") == bundle.manifest


def test_a_whole_bundle_is_proven(copy: Path) -> None:
    (copy / "README.md").write_text("other files do not matter")
    assert load_engine(read_bundle(copy)).manifest.category == "car"


@pytest.mark.parametrize(
    ("edit", "sentence"),
    [
        (lambda m: m.update(format_version=2), "expected format_version 1, found 2"),
        (lambda m: m.update(format_version=True), "expected format_version 1, found True"),
        (lambda m: m.pop("format_version"), "expected format_version 1, found None"),
        (lambda m: m.update(surprise=1), "surprise: "),
        (lambda m: m.pop("camera"), "camera: "),
        (lambda m: m["camera"].update(distance=-1), r"camera.distance: .*greater than 0.* found -1"),
        (lambda m: m["picture"].update(width=10**6), "picture.width: "),
        (lambda m: m["conventions"].update(frame="Z up"), "conventions.frame: .*Z up"),
        (lambda m: m.update(category="../../etc"), "category: "),
        (lambda m: m.update(latent="12"), "latent: .*found 12"),
        (lambda m: m["faces"].append([0, 1, 98]), "vertices 0 to 97, found 98"),
        (lambda m: m["faces"].append([0, 1, 2]), "blocks should cover 193 faces, found 192"),
        (lambda m: m["blocks"][0].update(first_face=1), "begin at face 0, found 1"),
        (lambda m: m["files"].update({"../../../etc/passwd": "0" * 64}), "files should name just"),
        (lambda m: m["files"].pop("probe.npz"), "files should name just"),
        (lambda m: m["files"].update({"encoder.onnx": "0" * 64}), "identity does not belong"),
        (lambda m: m["files"].update({"probe.npz": "0" * 64}), "probe.npz: expected sha256 000000000000…, found"),
        (
            lambda m: m.update(latent=13, parsimony=None),
            r"shape_mean: expected float32 \[1 to 16, 13\], found float32 \[2, 12\]",
        ),
        (lambda m: m.update(category_bias=1e9), "category_bias: .*less than or equal to 20.* found 1000000000.0"),
        (lambda m: m.update(vertices=99), r"vertices: expected float32 \[1 to 16, 99, 3\]"),
        (lambda m: m.update(held_out={"pictures": 20}), "held_out.framed: "),
        (
            lambda m: m.update(held_out={"pictures": 20, "framed": {"median": 0.2, "high": 0.2}, "fitted": None}),
            "held_out: expected a median below the high error, found 0.2 and 0.2",
        ),
        (lambda m: m["azimuth_bin_centres_degrees"].pop(), r"azimuth_probabilities: expected float32 \[1 to 16, 11\]"),
    ],
)
def test_a_wrong_manifest_is_refused(copy: Path, edit: Callable[[dict[str, Any]], object], sentence: str) -> None:
    edit_manifest(copy, edit)
    with pytest.raises(BundleError, match=sentence) as caught:
        read_bundle(copy)
    assert "export" in str(caught.value)


@pytest.mark.parametrize("text", [b"", b"\xff\xfe", b"[1]", b"{", b'{"format_version": NaN}', b"[" * 100_000])
def test_a_manifest_that_is_no_manifest_is_refused(copy: Path, text: bytes) -> None:
    (copy / "manifest.json").write_bytes(text)
    with pytest.raises(BundleError, match=r"expected (JSON|format_version 1), found"):
        read_bundle(copy)


@pytest.mark.parametrize("name", ["manifest.json", "encoder.onnx", "decoder.onnx", "probe.npz"])
def test_a_missing_file_is_refused(copy: Path, name: str) -> None:
    (copy / name).unlink()
    with pytest.raises(BundleError, match=f"{name}: expected a regular file .* found: No such file"):
        read_bundle(copy)


@pytest.mark.parametrize("name", ["encoder.onnx", "decoder.onnx", "probe.npz"])
def test_one_altered_bit_is_refused(copy: Path, name: str) -> None:
    content = bytearray((copy / name).read_bytes())
    content[len(content) // 2] ^= 1
    (copy / name).write_bytes(content)
    with pytest.raises(BundleError, match=f"{name}: expected sha256 .* was altered"):
        read_bundle(copy)


def test_links_pipes_and_directories_are_refused(copy: Path, tmp_path: Path) -> None:
    path = copy / "encoder.onnx"
    path.rename(tmp_path / "elsewhere")
    path.symlink_to(tmp_path / "elsewhere")
    with pytest.raises(
        BundleError, match=r"encoder.onnx: expected a regular file .* found: Too many levels of symbolic"
    ):
        read_bundle(copy)
    path.unlink()
    os.mkfifo(path)
    with pytest.raises(BundleError, match=r"encoder.onnx: expected a regular file .* found: Not a regular file"):
        read_bundle(copy)
    path.unlink()
    path.mkdir()
    with pytest.raises(BundleError, match=r"encoder.onnx: expected a regular file .* found: Not a regular file"):
        read_bundle(copy)


def test_a_huge_file_is_refused_before_it_is_read(copy: Path) -> None:
    with (copy / "manifest.json").open("wb") as file:
        file.truncate(2**40)
    with pytest.raises(BundleError, match=r"manifest.json: expected at most 16777216 bytes, found more"):
        read_bundle(copy)


def test_a_catalogue_reads_one_bundle_or_many(
    bundle_directory: Path, second_bundle_directory: Path, tmp_path: Path
) -> None:
    assert [b.manifest.category for b in read_catalogue(bundle_directory).bundles] == ["car"]
    shutil.copytree(bundle_directory, tmp_path / "a")
    shutil.copytree(second_bundle_directory, tmp_path / "b")
    (tmp_path / ".c.partial").mkdir()
    assert [b.manifest.category for b in read_catalogue(tmp_path).bundles] == ["car", "chair"]
    shutil.copytree(bundle_directory, tmp_path / "d")
    with pytest.raises(BundleError, match="expected one bundle a category, found a and d for car; remove one"):
        read_catalogue(tmp_path)


def test_a_catalogue_without_bundles_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BundleError, match="found neither; name another directory with --models"):
        read_catalogue(tmp_path)
    with pytest.raises(BundleError, match="found no directory"):
        read_catalogue(tmp_path / "absent")
