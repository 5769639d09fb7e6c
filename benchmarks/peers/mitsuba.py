"""Mitsuba 3 on its LLVM backend: rays against the mesh, colours emitted by the surface, moving edges sampled.

Picture by picture: its `batch` sensor draws many views at once, but the integrators that differentiate edges refuse it.
Four rays per pixel and, backwards, four samples per pixel on silhouettes: less is noise, more is slower.
"""

import os
from pathlib import Path

import drjit
import mitsuba
import numpy as np

from benchmarks.contender import Contender, FloatArray, Gradients, Renderer
from benchmarks.scene import Scene

VARIANT = "llvm_ad_rgb"
SAMPLES_PER_PIXEL = 4
POSITIONS, COLOURS = "mesh.vertex_positions", "mesh.vertex_colour"


def use_cores(cores: int) -> None:
    drjit.set_thread_count(cores)


def rays(scene: Scene) -> Renderer:
    """The default way to differentiate a scene: `render`, a loss in Dr.Jit, `backward`."""
    world = _world(scene)
    parameters = mitsuba.traverse(world)
    parameters.keep([POSITIONS, COLOURS])
    positions, colours = scene.camera_points.reshape(scene.count, -1), scene.colours.reshape(scene.count, -1)
    targets = [mitsuba.TensorXf(np.ascontiguousarray(target.transpose(1, 2, 0))) for target in scene.targets]

    def set_mesh(index: int) -> None:
        parameters[POSITIONS] = mitsuba.Float(positions[index])
        parameters[COLOURS] = mitsuba.Float(colours[index])

    def forward() -> FloatArray:
        pictures = np.empty((scene.count, scene.height, scene.width, 3), np.float32)
        for index, out in enumerate(pictures):
            set_mesh(index)
            parameters.update()
            out[:] = np.asarray(mitsuba.render(world, spp=SAMPLES_PER_PIXEL, seed=mitsuba.UInt32(index)))
        return pictures.transpose(0, 3, 1, 2)

    def step() -> Gradients:
        gradients = Gradients(np.empty_like(positions), np.empty_like(colours))
        for index, target in enumerate(targets):
            set_mesh(index)
            drjit.enable_grad(parameters[POSITIONS], parameters[COLOURS])
            parameters.update()
            picture = mitsuba.render(world, parameters, spp=SAMPLES_PER_PIXEL, seed=mitsuba.UInt32(index))
            drjit.backward(drjit.sum(drjit.square(picture - target)))
            gradients.positions[index] = drjit.grad(parameters[POSITIONS])
            gradients.colours[index] = drjit.grad(parameters[COLOURS])
        return Gradients(*(gradient.reshape(scene.colours.shape) for gradient in gradients))

    return Renderer(forward, step)


def _world(scene: Scene) -> "mitsuba.Scene":
    """The mesh as a light that looks as its vertices are coloured, its surface otherwise invisible."""
    glowing = mitsuba.Properties()
    glowing["emitter"] = mitsuba.load_dict(
        {"type": "area", "radiance": {"type": "mesh_attribute", "name": "vertex_colour"}}
    )
    glowing["bsdf"] = mitsuba.load_dict({"type": "null"})
    glowing["face_normals"] = True
    mesh = mitsuba.Mesh("mesh", scene.screen.shape[1], len(scene.faces), props=glowing)
    mesh.add_attribute("vertex_colour", 3, scene.colours[0].ravel())
    arrays = mitsuba.traverse(mesh)
    arrays["faces"] = scene.faces.ravel()
    arrays["vertex_positions"] = scene.camera_points[0].ravel()
    arrays.update()
    # In a camera's own frame x points to the left and y up: half a turn from right and down.
    upright = mitsuba.ScalarTransform4f().rotate([0, 0, 1], 180)
    world: mitsuba.Scene = mitsuba.load_dict(
        {
            "type": "scene",
            "mesh": mesh,
            "sensor": {
                "type": "perspective",
                "fov": scene.field_of_view_degrees,
                "fov_axis": "y",
                "near_clip": 0.01,
                "far_clip": 100.0,
                "to_world": upright,
                "sampler": {"type": "independent"},
                "film": {
                    "type": "hdrfilm",
                    "width": scene.width,
                    "height": scene.height,
                    "rfilter": {"type": "box"},
                    "pixel_format": "rgb",
                },
            },
            "integrator": {
                "type": "direct_projective",
                "sppc": SAMPLES_PER_PIXEL,
                "sppp": SAMPLES_PER_PIXEL,
                "sppi": 0,
            },
        }
    )
    return world


def contenders() -> list[Contender]:
    os.environ.setdefault("DRJIT_LIBLLVM_PATH", newest_llvm())
    mitsuba.set_variant(VARIANT)
    # One sum, so that a library that it cannot use fails here and not within a measurement.
    drjit.eval(drjit.arange(mitsuba.Float, 4) + 1)
    # It recommends a border for objects that enter or leave the picture; none does.
    mitsuba.set_log_level(mitsuba.LogLevel.Error)
    what = f"{VARIANT}, direct_projective, {SAMPLES_PER_PIXEL} samples per pixel, picture by picture"
    return [Contender(name="Mitsuba 3", what=what, prepare=rays, use_cores=use_cores, space="camera")]


def newest_llvm() -> str:
    """The path of LLVM's library. One from before version 16 ends the whole process where processors are newer."""
    found = {int(path.name.split(".")[2]): path for path in Path("/usr/lib").glob("*/libLLVM.so.[12]*")}
    if max(found, default=0) < 16:
        raise OSError("expected LLVM's library, version 16 or newer, found none (Debian: apt-get install libllvm19)")
    return str(found[max(found)])
