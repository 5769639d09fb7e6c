"""Compiled kernels are kept on the disk, and never longer than what they were compiled from."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

INNER = """
from rasteriser.compilation import kernel

@kernel()
def inner(x):
    return x + {}
"""
OUTER = """
from inner import inner
from rasteriser.compilation import kernel

@kernel()
def outer(x):
    return inner(x)

if __name__ == "__main__":
    import outer
    print(outer.outer(1), sum(outer.outer.stats.cache_hits.values()))
"""
ROOT = Path(__file__).parents[2]


@pytest.fixture
def sources(tmp_path: Path) -> Path:
    folder = tmp_path / "sources"
    folder.mkdir()
    (folder / "inner.py").write_text(INNER.format(1))
    (folder / "outer.py").write_text(OUTER)
    return folder


def run(sources: Path, **environment: str) -> tuple[int, int]:
    """(what `outer(1)` is, how often it came from the disk)"""
    clean = {name: value for name, value in os.environ.items() if not name.startswith("NUMBA_")}
    done = subprocess.run(
        [sys.executable, "-B", sources / "outer.py"],
        env=clean | {"PYTHONPATH": str(ROOT)} | environment,
        capture_output=True,
        text=True,
        check=True,
    )
    value, hits = map(int, done.stdout.split())
    return value, hits


def test_a_change_in_another_file_reaches_who_calls_it(sources: Path) -> None:
    assert run(sources) == (2, 0)
    assert run(sources) == (2, 1)
    (sources / "inner.py").write_text(INNER.format(5))
    assert run(sources) == (6, 0)
    assert len(list((sources / "__pycache__").glob("kernels-*"))) == 2
    # Back again, as between two branches: both are still there.
    (sources / "inner.py").write_text(INNER.format(1))
    assert run(sources) == (2, 1)


def test_what_nobody_used_for_weeks_is_deleted(sources: Path) -> None:
    old = sources / "__pycache__" / "kernels-0123456789abcdef"
    old.mkdir(parents=True)
    os.utime(old, (1e9, 1e9))
    run(sources)
    assert not old.exists()


def test_the_user_s_own_folder_is_taken(sources: Path, tmp_path: Path) -> None:
    assert run(sources, NUMBA_CACHE_DIR=str(tmp_path / "chosen")) == (2, 0)
    assert run(sources, NUMBA_CACHE_DIR=str(tmp_path / "chosen")) == (2, 1)
    assert not (sources / "__pycache__").exists()


def test_where_nothing_can_be_written_it_is_compiled_each_time(sources: Path, tmp_path: Path) -> None:
    (sources / "__pycache__").write_text("a file stands in the way")
    cache = tmp_path / "cache"
    assert run(sources, XDG_CACHE_HOME=str(cache)) == (2, 0)
    assert run(sources, XDG_CACHE_HOME=str(cache)) == (2, 1)
    blocked = tmp_path / "blocked"
    blocked.write_text("another")
    assert run(sources, XDG_CACHE_HOME=str(blocked)) == (2, 0)
    assert run(sources, XDG_CACHE_HOME=str(blocked)) == (2, 0)
