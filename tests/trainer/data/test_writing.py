"""Files appear whole or not at all."""

import errno
import os
from pathlib import Path

import pytest

from trainer.data.writing import write_bytes
from trainer.errors import StorageError


def test_a_file_is_written_with_its_folder(tmp_path: Path) -> None:
    write_bytes(tmp_path / "a" / "b.txt", b"one")
    write_bytes(tmp_path / "a" / "b.txt", b"two")
    assert [(path.name, path.read_bytes()) for path in (tmp_path / "a").iterdir()] == [("b.txt", b"two")]


def test_a_full_disk_leaves_the_old_file_and_nothing_else(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "b.txt"
    write_bytes(path, b"old")

    def half_a_write(self: Path, content: bytes) -> int:
        with self.open("wb") as file:
            file.write(content[: len(content) // 2])
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(Path, "write_bytes", half_a_write)
    with pytest.raises(StorageError, match=r"b\.txt \(6 bytes\): No space left on device\. Make room"):
        write_bytes(path, b"newest")
    assert [entry.read_bytes() for entry in tmp_path.iterdir()] == [b"old"]


def test_an_interrupted_write_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(source: str, target: str) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(os, "replace", interrupted)
    with pytest.raises(KeyboardInterrupt):
        write_bytes(tmp_path / "b.txt", b"new")
    assert not list(tmp_path.iterdir())


def test_a_file_in_the_way_of_a_folder_is_named(tmp_path: Path) -> None:
    (tmp_path / "a").write_text("x")
    with pytest.raises(StorageError, match="could not write"):
        write_bytes(tmp_path / "a" / "b.txt", b"x")
