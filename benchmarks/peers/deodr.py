"""DEODR: its compiled core, called picture by picture, and its torch classes.

The core is called as bare as can be: scenes are assembled and checks are switched off beforehand. It is measured twice,
with the silhouettes given, and with the silhouettes of each picture found by DEODR's own function, which every new
mesh or pose needs. Colours are interpolated linearly on the screen: its backward pass knows no perspective correction.
"""

import warnings
from dataclasses import replace

import numpy as np
import torch
from deodr import differentiable_renderer_cython as core
from deodr.differentiable_renderer import Scene2DBase
from deodr.pytorch import CameraPytorch, ColoredTriMeshPytorch, Scene3DPytorch
from deodr.triangulated_mesh import TriMeshAdjacencies
from torch.nn import functional

from benchmarks.contender import Contender, FloatArray, Gradients, Renderer
from benchmarks.scene import Scene

# Width of the antialiasing over silhouettes, pixels: DEODR's default.
SIGMA = 1.0


def use_cores(cores: int) -> None:
    torch.set_num_threads(cores)


def bare_core(scene: Scene) -> Renderer:
    """The compiled functions with the silhouettes given."""
    return _core(scene, find_silhouettes=False)


def core_with_silhouettes(scene: Scene) -> Renderer:
    """The compiled functions and what must be known before them."""
    return _core(scene, find_silhouettes=True)


def _core(scene: Scene, find_silhouettes: bool) -> Renderer:
    adjacencies = TriMeshAdjacencies(scene.faces)
    flat = [_scene_2d(scene, adjacencies, index) for index in range(scene.count)]
    targets = np.ascontiguousarray(scene.targets.transpose(0, 2, 3, 1), np.float64)
    image, depth = np.empty(targets.shape[1:]), np.empty(targets.shape[1:3])

    def draw(one: Scene2DBase, out: FloatArray) -> None:
        if find_silhouettes:
            one.edgeflags = np.asarray(adjacencies.edge_on_silhouette(one.ij))
        core.renderSceneCpp(one, SIGMA, out, depth, False, None, None, False)

    def forward() -> FloatArray:
        images = np.empty(targets.shape)
        for one, out in zip(flat, images, strict=True):
            draw(one, out)
        return images.transpose(0, 3, 1, 2)

    def step() -> Gradients:
        positions, colours = np.zeros((*scene.screen.shape[:2], 2)), np.zeros(scene.colours.shape)
        for index, one in enumerate(flat):
            draw(one, image)
            one.ij_b, one.colors_b = positions[index], colours[index]
            residual = image - targets[index]
            residual *= 2.0
            core.renderSceneBCpp(one, SIGMA, image, depth, residual, False, None, None, None, False)
            positions[index], colours[index] = one.ij_b, one.colors_b
        return Gradients(positions, colours)

    return Renderer(forward, step)


def _scene_2d(scene: Scene, adjacencies: TriMeshAdjacencies, index: int) -> Scene2DBase:
    vertex_count, face_count = scene.screen.shape[1], len(scene.faces)
    corners = scene.screen[index, :, :2].astype(np.float64)
    return Scene2DBase(
        faces=scene.faces,
        faces_uv=scene.faces,
        ij=corners,
        depths=1.0 / scene.screen[index, :, 2].astype(np.float64),
        textured=np.zeros(face_count, bool),
        uv=np.zeros((vertex_count, 2)),
        shade=np.zeros(vertex_count),
        colors=scene.colours[index].astype(np.float64),
        shaded=np.zeros(face_count, bool),
        edgeflags=np.asarray(adjacencies.edge_on_silhouette(corners)),
        height=scene.height,
        width=scene.width,
        nb_colors=3,
        texture=np.zeros((0, 0)),
        background_color=np.zeros(3),
        uv_b=np.zeros((vertex_count, 2)),
        shade_b=np.zeros(vertex_count),
        texture_b=np.zeros((0, 0)),
        integer_pixel_centers=False,
    )


def torch_classes(scene: Scene) -> Renderer:
    """`Scene3DPytorch`, which projects, shades and finds silhouettes itself; here by ambient light only."""
    # Its classes call what newer versions of torch deprecate.
    warnings.filterwarnings("ignore", category=UserWarning, module=r"deodr\.pytorch")
    points, shades = torch.from_numpy(scene.camera_points).double(), torch.from_numpy(scene.colours).double()
    mesh = ColoredTriMeshPytorch(scene.faces, points[0], colors=shades[0])
    renderer = Scene3DPytorch()
    renderer.set_mesh(mesh)
    renderer.set_background_color(np.zeros(3))
    renderer.set_light(torch.zeros(3, dtype=torch.float64), torch.ones((), dtype=torch.float64))
    # Its pixel centres are at whole numbers.
    intrinsic = np.array(
        [[scene.focal, 0.0, scene.width / 2 - 0.5], [0.0, scene.focal, scene.height / 2 - 0.5], [0.0, 0.0, 1.0]]
    )
    camera = CameraPytorch(np.eye(3, 4), intrinsic, scene.height, scene.width)
    targets = torch.from_numpy(scene.targets).double().permute(0, 2, 3, 1).contiguous()

    def draw(positions: torch.Tensor, colours: torch.Tensor) -> torch.Tensor:
        mesh.set_vertices(positions)
        mesh.set_vertices_colors(colours)
        picture: torch.Tensor = renderer.render(camera)
        return picture

    def forward() -> FloatArray:
        with torch.no_grad():
            pictures: FloatArray = torch.stack([draw(*one) for one in zip(points, shades, strict=True)]).numpy()
        return pictures.transpose(0, 3, 1, 2)

    def step() -> Gradients:
        positions, colours = points.detach().requires_grad_(), shades.detach().requires_grad_()
        for index, target in enumerate(targets):
            functional.mse_loss(draw(positions[index], colours[index]), target, reduction="sum").backward()
        return Gradients(_gradient(positions), _gradient(colours))

    return Renderer(forward, step)


def _gradient(tensor: torch.Tensor) -> FloatArray:
    assert tensor.grad is not None
    gradient: FloatArray = tensor.grad.numpy()
    return gradient


def contenders() -> list[Contender]:
    bare = Contender(
        name="DEODR core, silhouettes given",
        what="its compiled functions alone",
        prepare=bare_core,
        use_cores=use_cores,
        second_core="processes",
    )
    complete = replace(
        bare,
        name="DEODR core",
        what="its compiled functions, and its function that finds the silhouettes of each picture",
        prepare=core_with_silhouettes,
    )
    classes = replace(
        bare,
        name="DEODR torch",
        what="its torch classes; they also project, and compute normals that this scene does not need",
        prepare=torch_classes,
        space="camera",
    )
    return [bare, complete, classes]
