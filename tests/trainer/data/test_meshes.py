"""Mesh files of every format give the mesh that trimesh wrote into them; broken ones are named."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

from trainer.data.meshes import FORMATS, load_mesh, mesh_files
from trainer.data.shapes.catalogue import make_shape
from trainer.data.shapes.solid import Mesh, signed_volume
from trainer.errors import DataError

REAL_MESHES = Path(__file__).parents[4] / "shared" / "meshes"


def write(path: Path, mesh: Mesh, scale: float = 1.0) -> Path:
    trimesh.Trimesh(mesh.vertices * scale, mesh.faces, process=False).export(path)
    return path


@pytest.mark.parametrize("ending", FORMATS)
def test_every_format_is_read(tmp_path: Path, ending: str) -> None:
    mesh = make_shape("chair", 4)
    if ending == ".gltf":
        for name, content in trimesh.exchange.gltf.export_gltf(
            trimesh.Scene(trimesh.Trimesh(mesh.vertices, mesh.faces, process=False))
        ).items():
            (tmp_path / name).write_bytes(content)
        path = tmp_path / "model.gltf"
    else:
        path = write(tmp_path / f"mesh{ending}", mesh, 37.0)
    loaded = load_mesh(path)
    assert len(loaded.faces) == len(mesh.faces)
    assert signed_volume(loaded) == pytest.approx(signed_volume(mesh), rel=1e-4)
    np.testing.assert_allclose(np.ptp(loaded.vertices, axis=0), np.ptp(mesh.vertices, axis=0), atol=1e-5)


def test_a_scene_is_put_together_where_its_nodes_stand(tmp_path: Path) -> None:
    scene = trimesh.Scene()
    cube = trimesh.creation.box((1.0, 1.0, 1.0))
    for x in (0.0, 3.0):
        scene.add_geometry(cube, transform=trimesh.transformations.translation_matrix((x, 0.0, 0.0)))
    scene.export(tmp_path / "two.glb")
    mesh = load_mesh(tmp_path / "two.glb")
    diagonal = np.sqrt(16 + 1 + 1)
    np.testing.assert_allclose(np.ptp(mesh.vertices, axis=0), np.array([4, 1, 1]) / diagonal, rtol=1e-6)
    assert signed_volume(mesh) == pytest.approx(2 / diagonal**3, rel=1e-5)
    assert len(mesh.vertices) == 16  # corners that a renderer keeps apart for their normals are one vertex


def test_broken_files_are_named(tmp_path: Path) -> None:
    contents = {
        "noise.glb": b"not a mesh at all",
        "empty.obj": b"",
        "points.obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\n",
        "nan.obj": b"v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
        "dot.obj": b"v 1 1 1\nv 1 1 1\nv 1 1 1\nf 1 2 3\n",
        "missing.obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n",
        "cut.ply": b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n",
        "cut.stl": b"solid x\nfacet normal 0 0 1\n",
    }
    for name, content in contents.items():
        (tmp_path / name).write_bytes(content)
        with pytest.raises(DataError, match=name):
            load_mesh(tmp_path / name)


@pytest.mark.parametrize("unit", [1e-200, 1e-12, 0.001, 0.0254, 1000.0, 1e12, 1e200])
def test_the_unit_of_a_file_does_not_matter(tmp_path: Path, unit: float) -> None:
    corners = [(x, y, z) for x in (0, 1) for y in (0, 2) for z in (0, 3)]
    faces = trimesh.convex.convex_hull(np.array(corners, float)).faces
    vertices = "".join("v " + " ".join(repr(unit * value) for value in corner) + "\n" for corner in corners)
    hull = trimesh.convex.convex_hull(np.array(corners, float))
    order = [corners.index(tuple(vertex)) for vertex in hull.vertices.round().astype(int).tolist()]
    lines = "".join("f " + " ".join(str(order[corner] + 1) for corner in face) + "\n" for face in faces)
    (tmp_path / "box.obj").write_text(vertices + lines)
    mesh = load_mesh(tmp_path / "box.obj")
    np.testing.assert_allclose(np.ptp(mesh.vertices, axis=0), np.array([1, 2, 3]) / np.sqrt(14), rtol=1e-9)
    assert signed_volume(mesh) == pytest.approx(6 / 14**1.5)


def test_a_place_far_from_the_origin_does_not_matter(tmp_path: Path) -> None:
    """As surveyors have it, in doubles."""
    (tmp_path / "far.obj").write_text(
        "v 500000.25 4649776.5 0\nv 500002.25 4649776.5 0\nv 500000.25 4649777.5 0\nf 1 2 3\n"
    )
    np.testing.assert_allclose(np.ptp(load_mesh(tmp_path / "far.obj").vertices, 0), np.array([2, 1, 0]) / np.sqrt(5))


def test_parts_in_different_units_are_named(tmp_path: Path) -> None:
    """A thing of a metre, and a vertex that somebody meant in tenths of a millimetre."""
    (tmp_path / "mixed.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 10000\nv 0 0 10000\nf 1 2 3\nf 1 4 5\n")
    with pytest.raises(DataError, match=r"mixed\.obj: expected a surface, found faces of 5e-09 times"):
        load_mesh(tmp_path / "mixed.obj")
    (tmp_path / "gone.obj").write_text("v 0 0 1e30\nv 1 0 1e30\nv 0 1 1e30\nf 1 2 3\n")
    with pytest.raises(DataError, match=r"gone\.obj: all vertices lie in one point, or so far from the origin"):
        load_mesh(tmp_path / "gone.obj")


def test_what_no_face_uses_is_left_out(tmp_path: Path) -> None:
    (tmp_path / "spare.obj").write_text("v nan 0 0\nv 0 0 0\nv 2 0 0\nv 0 1 0\nv 90 90 90\nl 2 5\np 1\nf 2 3 4\n")
    mesh = load_mesh(tmp_path / "spare.obj")
    assert len(mesh.vertices) == 3
    np.testing.assert_allclose(np.ptp(mesh.vertices, axis=0), np.array([2, 1, 0]) / np.sqrt(5))


def test_a_mesh_among_more_lines_than_meshes_is_found(tmp_path: Path) -> None:
    scene = trimesh.Scene([trimesh.creation.box((1.0, 1.0, 1.0))])
    for height in (2.0, 3.0):
        scene.add_geometry(trimesh.load_path([[(0.0, 0.0, 0.0), (0.0, height, 0.0)]]))
    scene.export(tmp_path / "annotated.glb")
    assert len(load_mesh(tmp_path / "annotated.glb").faces) == 12


def test_a_folder_lists_its_meshes_and_says_when_there_are_none(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="found nothing"):
        mesh_files(tmp_path / "nowhere")
    (tmp_path / "notes.txt").write_text("x")
    with pytest.raises(DataError, match="expected at least one mesh"):
        mesh_files(tmp_path)
    with pytest.raises(DataError, match="found a file"):
        mesh_files(tmp_path / "notes.txt")
    (tmp_path / "b").mkdir()
    for name in ("b/c.OBJ", "a.ply"):
        (tmp_path / name).write_text("x")
    assert [path.relative_to(tmp_path).as_posix() for path in mesh_files(tmp_path)] == ["a.ply", "b/c.OBJ"]


@pytest.mark.skipif(not REAL_MESHES.is_dir(), reason="no ../shared/meshes beside the project")
def test_real_meshes_are_read() -> None:
    for path in mesh_files(REAL_MESHES):
        mesh = load_mesh(path)
        np.testing.assert_allclose(mesh.vertices.min(0), -mesh.vertices.max(0), atol=1e-6)
        assert np.linalg.norm(np.ptp(mesh.vertices, axis=0)) == pytest.approx(1.0, abs=1e-5)
