"""A reconstruction as a mesh file."""

from collections.abc import Sequence

import numpy as np
import trimesh
from jaxtyping import Float, Int64
from torch import Tensor

from trainer.geometry.normals import vertex_normals
from trainer.model.decoder import Part

FORMATS = ("ply", "obj", "stl", "glb")
"""File name endings that can be written."""


def mesh_file(vertices: Float[Tensor, "V 3"], faces: Int64[Tensor, "F 3"], parts: Sequence[Part], kind: str) -> bytes:
    """A mesh in one of FORMATS, in its own frame (front +Z, up +Y).

    In a GLB each part is a node of its own, which has the part's name, and normals come with the vertices.
    """
    if kind == "glb":
        scene = trimesh.Scene()
        normals = vertex_normals(vertices, faces).numpy()
        for part in parts:
            used, own = np.unique(faces[part.first_face : part.first_face + part.face_count], return_inverse=True)
            mesh = trimesh.Trimesh(
                vertices[used].numpy(), own.reshape(-1, 3), vertex_normals=normals[used], process=False
            )
            scene.add_geometry(mesh, node_name=part.name, geom_name=part.name)
        content = scene.export(file_type="glb", include_normals=True)
    else:
        content = trimesh.Trimesh(vertices.numpy(), faces.numpy(), process=False).export(file_type=kind)
    return content.encode() if isinstance(content, str) else content
