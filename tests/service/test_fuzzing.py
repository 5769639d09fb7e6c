"""What `python -m benchmarks.fuzz` gives a fuzzer to do, without the fuzzer: seeds are read, damage is refused."""

import io
import struct
import zipfile
import zlib
from pathlib import Path

import numpy as np
import pytest

from benchmarks.fuzz import added, portion_of
from benchmarks.fuzz_mutation import mutator, with_right_checksums
from benchmarks.fuzz_seeds import bundle, pictures
from benchmarks.fuzz_targets import NAMES, WIDTH, Name, seeds_of, target_of
from service.bundle import read_bundle
from service.image import read_picture
from service.inference import load_engine


def test_every_picture_that_fuzzing_begins_with_is_read() -> None:
    for name, content in pictures().items():
        assert read_picture(content, WIDTH, 36, 10_000).method in {"alpha", "background"}, name


def test_the_bundle_that_fuzzing_begins_with_is_served(tmp_path: Path) -> None:
    for name, content in bundle().items():
        (tmp_path / name).write_bytes(content)
    assert load_engine(read_bundle(tmp_path)).manifest.category == "triangle"


@pytest.mark.parametrize("name", NAMES)
def test_damage_is_refused_by_an_error_that_is_documented(name: Name, tmp_path: Path) -> None:
    """A target raises nothing: for its seeds, their beginnings, and some dozens of random changes."""
    random, read = np.random.default_rng(0), target_of(name, tmp_path)

    def damaged(content: bytes, most: int) -> bytes:
        changed = np.frombuffer(content[:most], np.uint8).copy()
        places = random.integers(len(changed), size=random.integers(1, 4))
        changed[places] = random.integers(256, size=len(places))
        return changed[: random.integers(1, len(changed) + 1)].tobytes() if random.random() < 0.2 else changed.tobytes()

    mutate = mutator(damaged)
    for content in seeds_of(name).values():
        read(content)
        for seed in range(60 // len(seeds_of(name)) + 1):
            read(mutate(content, 8192, seed))


def test_checksums_follow_what_is_changed() -> None:
    content = bytearray(pictures()["rgb.png"])
    content[20] ^= 1
    (found,) = struct.unpack_from(">I", with_right_checksums(bytes(content)), 29)
    assert found == zlib.crc32(content[12:29])
    assert with_right_checksums(pictures()["rgb.png"]) == pictures()["rgb.png"]
    assert with_right_checksums(b"BM and so on") == b"BM and so on"


def test_checksums_in_archives_follow_what_is_changed() -> None:
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w") as file:
        file.writestr("a", "one")
        file.writestr("b", "two")
    changed = with_right_checksums(archive.getvalue().replace(b"two", b"2.0"))
    with zipfile.ZipFile(io.BytesIO(changed)) as file:
        assert (file.read("a"), file.read("b")) == (b"one", b"2.0")
    assert with_right_checksums(archive.getvalue()) == archive.getvalue()
    assert with_right_checksums(archive.getvalue()[:50]) == archive.getvalue()[:50]


LOG = """\
INFO: seed corpus: files: 22 min: 225b max: 3654b total: 15237b rss: 103Mb
#23	INITED cov: 695 ft: 1114 corp: 17/9722b exec/s: 23 rss: 111Mb
#411	REDUCE cov: 702 ft: 1151 corp: 31/12598b lim: 8192 exec/s: 102 rss: 112Mb L: 621/1916
"""


def test_a_log_tells_what_was_done() -> None:
    done = portion_of(f"{LOG}#600\tDONE   cov: 710 ft: 1264 corp: 32/12267b lim: 8192 exec/s: 120 rss: 112Mb\n", 0)
    assert (done.executions, done.coverage_before, done.coverage, done.corpus, done.fault) == (600, 695, 710, 32, None)


def test_a_log_tells_what_went_wrong() -> None:
    raised = (
        "\n === Uncaught Python exception: ===\nTokenError: ('EOF', (2, 0))\nTraceback (most recent call last):\n"
        '  File "a.py", line 1, in f\n    g()\n  File "b.py", line 2, in g\n    h()\n\n'
        "==6324== ERROR: libFuzzer: fuzz target exited\nSUMMARY: libFuzzer: fuzz target exited\n"
        "stat::number_of_executed_units: 500\n"
    )
    found = portion_of(LOG + raised, 77)
    assert (found.executions, found.coverage) == (500, 702)
    assert found.fault == "TokenError: ('EOF', (2, 0)) at File \"b.py\", line 2, in g"
    late = portion_of(f"{LOG}SUMMARY: libFuzzer: timeout\n", 70)
    assert late.fault == "libFuzzer: timeout"
    with pytest.raises(RuntimeError, match="expected the fuzzer to begin, found that it ended with 1: no module"):
        portion_of("no module", 1)


def test_portions_add_up() -> None:
    first = {"executions": 100, "seconds": 2.0, "coverage_of_seeds": 5, "coverage": 7, "corpus": 3, "faults": ["a"]}
    second = {"executions": 300, "seconds": 2.0, "coverage_of_seeds": 7, "coverage": 9, "corpus": 4, "faults": []}
    assert added(first, second) == {
        "executions": 400,
        "seconds": 4.0,
        "per_second": 100.0,
        "coverage_of_seeds": 5,
        "coverage": 9,
        "corpus": 4,
        "faults": ["a"],
    }
