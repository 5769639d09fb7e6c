"""Meshes from files: OBJ, PLY, STL, OFF, GLB and glTF."""

from pathlib import Path

import numpy as np
from jaxtyping import Float64
from numpy import ndarray

from trainer.data.face_count import announced_faces
from trainer.data.shapes.solid import Mesh, normalise
from trainer.errors import DataError

FORMATS = (".obj", ".ply", ".stl", ".off", ".glb", ".gltf")
"""File name endings that are read, in lower case."""

MOST_FACES = 5_000_000
"""A mesh of so many takes three gigabytes while it is drawn."""

# Of a unit diagonal. Less than one pixel's worth, seen at the default size and from all sides together.
_LEAST_AREA = 1e-4


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
    vertex. The file's axes are kept: +Y is taken to be up and +Z to be the front. Its unit and its origin do not
    matter, as both are normalised away: millimetres do as well as miles.

    Raises DataError where the file cannot be read, has no faces, too many of them, no extent, almost no area (most
    often parts in different units, or a stray vertex far away), or numbers that are not finite.
    """
    vertices, faces = _read(path)
    if faces.min() < 0 or faces.max() >= len(vertices):
        raise DataError(f"{path}: faces name vertices that do not exist; export it again, or remove it")
    used, index = np.unique(faces, return_inverse=True)
    vertices, faces = vertices[used], index.reshape(-1, 3)
    if not np.isfinite(vertices).all():
        raise DataError(f"{path}: expected finite coordinates, found NaN or infinity; export it again, or remove it")
    # The squares of wildly large or small numbers are no numbers any more.
    vertices = vertices / (np.abs(vertices).max() or 1.0)
    if not np.linalg.norm(np.ptp(vertices, axis=0)) > 1e-12:
        raise DataError(
            f"{path}: all vertices lie in one point, or so far from the origin that nothing else is left of them; "
            "move it to the origin and export it again, or remove it"
        )
    mesh = welded(normalise(Mesh(vertices, faces)))
    area = surface_area(mesh)
    if area < _LEAST_AREA:
        raise DataError(
            f"{path}: expected a surface, found faces of {area:.1g} times the squared diagonal in all; look for parts "
            "in different units or for a stray vertex far away, export it again, or remove it"
        )
    return mesh


def _read(path: Path) -> tuple[Float64[ndarray, "V 3"], ndarray]:
    """Vertices and faces as they stand in the file, of which there are some, and not too many."""
    # Here and not above: it takes half a second to load, which processes that draw procedural shapes need not spend.
    import trimesh  # noqa: PLC0415

    try:
        # Before the file is loaded: an enormous one would end the process for want of memory.
        _check_face_count(path, announced_faces(path))
        scene = trimesh.load_scene(path, process=False, skip_materials=True)
        parts = [part for part in scene.dump() if isinstance(part, trimesh.Trimesh) and len(part.faces)]
        geometry = trimesh.util.concatenate(parts) if parts else None
    except DataError:
        raise
    except Exception as error:  # each of trimesh's readers fails in its own way
        raise DataError(
            f"{path} cannot be read as a mesh ({type(error).__name__}: {error}); "
            "open it in a 3D program and export it again, or remove it"
        ) from error
    if geometry is None:
        raise DataError(f"{path}: expected a mesh with faces, found none; export it again as triangles, or remove it")
    _check_face_count(path, len(geometry.faces))
    return np.asarray(geometry.vertices, np.float64), np.asarray(geometry.faces, np.int64)


def _check_face_count(path: Path, count: int) -> None:
    if count > MOST_FACES:
        raise DataError(f"{path}: expected at most {MOST_FACES:,} faces, found {count:,}; simplify it, or remove it")


def welded(mesh: Mesh, tolerance: float = 1e-6) -> Mesh:
    """The mesh with vertices closer than about `tolerance` made one, and faces that collapse thereby left out."""
    keys = np.round(mesh.vertices / tolerance).astype(np.int64)
    _, first, index = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    faces = index.reshape(-1)[mesh.faces]
    distinct = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    return Mesh(mesh.vertices[first], faces[distinct])


def surface_area(mesh: Mesh) -> float:
    """The area of all faces together, one side of each."""
    a, b, c = mesh.vertices[mesh.faces].transpose(1, 0, 2)
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)
