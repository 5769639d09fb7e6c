"""Meshes from files: OBJ, PLY, STL, OFF, GLB and glTF."""

from pathlib import Path

import numpy as np
import trimesh

from trainer.data.shapes.solid import Mesh, normalise
from trainer.errors import DataError

FORMATS = (".obj", ".ply", ".stl", ".off", ".glb", ".gltf")
"""File name endings that are read, in lower case."""

_MOST_FACES = 5_000_000


def mesh_files(folder: Path) -> list[Path]:
    """All mesh files below a folder, in order of their paths.

    Raises DataError where the folder is missing or holds none.
    """
    if not folder.is_dir():
        raise DataError(f"expected a folder of meshes at {folder}, found {'a file' if folder.exists() else 'nothing'}")
    files = sorted(path for path in folder.rglob("*") if path.suffix.lower() in FORMATS and path.is_file())
    if not files:
        raise DataError(f"expected at least one mesh ({', '.join(FORMATS)}) in {folder} or below it, found none")
    return files


def load_mesh(path: Path) -> Mesh:
    """The whole content of a mesh file as one mesh: centred, with a unit bounding-box diagonal.

    Transformations of a scene are applied and all its geometry is put together; vertices at one position are one
    vertex. The file's axes are kept: +Y is taken to be up and +Z to be the front.

    Raises DataError where the file cannot be read, has no faces, too many of them, no extent, or numbers that are not
    finite.
    """
    try:
        scene = trimesh.load_scene(path, process=False, skip_materials=True)
        geometry = scene.to_geometry() if scene.geometry else None
    except Exception as error:  # each of trimesh's readers fails in its own way
        raise DataError(
            f"{path} cannot be read as a mesh ({type(error).__name__}: {error}); "
            "open it in a 3D program and export it again, or remove it"
        ) from error
    if not isinstance(geometry, trimesh.Trimesh) or len(geometry.faces) == 0:
        raise DataError(f"{path}: expected a mesh with faces, found none; export it again as triangles, or remove it")
    if len(geometry.faces) > _MOST_FACES:
        raise DataError(
            f"{path}: expected at most {_MOST_FACES:,} faces, found {len(geometry.faces):,}; simplify it, or remove it"
        )
    vertices, faces = np.asarray(geometry.vertices, np.float64), np.asarray(geometry.faces, np.int64)
    if faces.min() < 0 or faces.max() >= len(vertices):
        raise DataError(f"{path}: faces name vertices that do not exist; export it again, or remove it")
    if not np.isfinite(vertices[faces]).all():
        raise DataError(f"{path}: expected finite coordinates, found NaN or infinity; export it again, or remove it")
    used = vertices[faces.reshape(-1)]
    if not np.linalg.norm(np.ptp(used, axis=0)) > 0:
        raise DataError(f"{path}: all vertices lie in one point; export it again, or remove it")
    return welded(normalise(Mesh(vertices, faces)))


def welded(mesh: Mesh, tolerance: float = 1e-6) -> Mesh:
    """The mesh with vertices closer than about `tolerance` made one, and faces that collapse thereby left out."""
    keys = np.round(mesh.vertices / tolerance).astype(np.int64)
    _, first, index = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    faces = index.reshape(-1)[mesh.faces]
    distinct = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    return Mesh(mesh.vertices[first], faces[distinct])
