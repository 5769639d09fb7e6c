"""Mesh files hold the mesh; a GLB its parts and normals, too."""

import io

import numpy as np
import pytest
import torch
import trimesh

from trainer.config import ModelConfig
from trainer.evaluation.mesh_file import FORMATS, mesh_file
from trainer.model.vae import Decoder, decoder_of


def shape_of(kind: str) -> tuple[Decoder, torch.Tensor, torch.Tensor]:
    """(decoder, vertices, normals) of some shape."""
    torch.manual_seed(2)
    decoder = decoder_of(ModelConfig(latent=3, parameterisation=kind, blocks=2 * (kind != "subdivision")))  # type: ignore[arg-type]
    code = torch.randn(1, 3) * 20
    with torch.no_grad():
        return decoder, decoder(code)[0], decoder.normals(code)[0]


# A GLB's parts come back in any order: see below.
@pytest.mark.parametrize("kind", sorted(set(FORMATS) - {"glb"}))
def test_every_format_holds_all_faces_where_they_are(kind: str) -> None:
    decoder, vertices, _ = shape_of("full-block")
    found = trimesh.load(
        io.BytesIO(mesh_file(vertices, decoder.faces, decoder.parts, kind)), kind, force="mesh", process=False
    )
    np.testing.assert_allclose(found.triangles, vertices[decoder.faces], atol=1e-5)


@pytest.mark.parametrize(("kind", "names"), [("subdivision", ["body"]), ("ortho-block", ["block-1", "block-2"])])
def test_a_part_of_a_glb_is_a_node_with_its_name_and_normals(kind: str, names: list[str]) -> None:
    decoder, vertices, normals = shape_of(kind)
    content = mesh_file(vertices, decoder.faces, decoder.parts, "glb")
    scene = trimesh.load(io.BytesIO(content), "glb", process=False)
    assert sorted(scene.graph.nodes_geometry) == names
    per_part = len(vertices) // len(names)
    triangles = vertices[decoder.faces].unflatten(0, (len(names), -1))
    for number, name in enumerate(names):
        mesh = scene.geometry[scene.graph[name][1]]
        own = slice(number * per_part, (number + 1) * per_part)
        np.testing.assert_allclose(mesh.vertices, vertices[own], atol=1e-6)
        np.testing.assert_allclose(mesh.triangles, triangles[number], atol=1e-6)
        np.testing.assert_allclose(mesh.vertex_normals, normals[own], atol=1e-4)
