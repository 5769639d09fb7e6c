"""What a file announces is what it holds, and an enormous one is refused unread."""

import struct
from pathlib import Path

import pytest
import trimesh

from trainer.data import meshes
from trainer.data.face_count import announced_faces
from trainer.data.meshes import FORMATS, MOST_FACES, load_mesh
from trainer.data.shapes.catalogue import make_shape
from trainer.errors import DataError


def write(folder: Path, ending: str) -> Path:
    vertices, faces = make_shape("chair", 4)
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    if ending == ".gltf":
        for name, content in trimesh.exchange.gltf.export_gltf(trimesh.Scene([mesh, mesh])).items():
            (folder / name).write_bytes(content)
        return folder / "model.gltf"
    mesh.export(folder / f"mesh{ending}")
    return folder / f"mesh{ending}"


@pytest.mark.parametrize("ending", FORMATS)
def test_the_announced_number_is_the_true_one(tmp_path: Path, ending: str) -> None:
    path = write(tmp_path, ending)
    assert announced_faces(path) == sum(
        len(part.faces) for part in trimesh.load_scene(path, process=False).geometry.values()
    )


def test_text_is_counted_across_pieces_that_it_is_read_in(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    vertices, faces = make_shape("chair", 4)
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    (tmp_path / "a.obj").write_text("f 1 2 3\n" + mesh.export(file_type="obj"))
    (tmp_path / "a.stl").write_text(mesh.export(file_type="stl_ascii"))
    for size in (1, 7, 1000):
        monkeypatch.setattr("trainer.data.face_count._PIECE", size)
        assert announced_faces(tmp_path / "a.obj") == len(faces) + 1
        assert announced_faces(tmp_path / "a.stl") == len(faces)


@pytest.mark.parametrize("ending", [*FORMATS, ".txt"])
@pytest.mark.parametrize("content", [b"", b"{}", b"nothing of the kind", b"\x00\xff" * 60, b'{"meshes": [{"x": 1}]}'])
def test_a_file_that_is_not_what_its_name_says_announces_nothing(tmp_path: Path, ending: str, content: bytes) -> None:
    (tmp_path / f"mesh{ending}").write_bytes(content)
    assert announced_faces(tmp_path / f"mesh{ending}") == 0


def test_ten_million_faces_are_refused_unread(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def unread(*_: object, **__: object) -> None:
        raise AssertionError("the file was loaded")

    monkeypatch.setattr(trimesh, "load_scene", unread)
    count = 10**7
    with (tmp_path / "huge.stl").open("wb") as file:
        file.write(struct.pack("<80xI", count))
        file.truncate(84 + 50 * count)  # The rest is a hole: it takes no room on the disk.
    (tmp_path / "huge.ply").write_text(f"ply\nformat ascii 1.0\nelement face {count}\nend_header\n")
    (tmp_path / "huge.off").write_text(f"OFF # by hand\n{3 * count} {count} 0\n")
    for name in ("huge.stl", "huge.ply", "huge.off"):
        with pytest.raises(DataError, match=rf"{name}: expected at most 5,000,000 faces, found 10,000,000; simplify"):
            load_mesh(tmp_path / name)


def test_a_number_that_only_loading_tells_is_checked_then(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A polygon is one line, and many triangles."""
    (tmp_path / "fan.obj").write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n")
    assert MOST_FACES == 5_000_000
    monkeypatch.setattr(meshes, "MOST_FACES", 1)
    with pytest.raises(DataError, match="expected at most 1 faces, found 2"):
        load_mesh(tmp_path / "fan.obj")
