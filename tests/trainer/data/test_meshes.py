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
@pytest.mark.parametrize("category", ["car", "chair"])
def test_real_meshes_are_read(category: str) -> None:
    for path in mesh_files(REAL_MESHES / category):
        mesh = load_mesh(path)
        np.testing.assert_allclose(mesh.vertices.min(0), -mesh.vertices.max(0), atol=1e-6)
        assert np.linalg.norm(np.ptp(mesh.vertices, axis=0)) == pytest.approx(1.0, abs=1e-5)
