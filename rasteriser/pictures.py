"""Antialiased pictures of many meshes at once, and the adjoint of that."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from numba import get_num_threads, prange

from rasteriser.compilation import kernel
from rasteriser.coverage import bounding_box
from rasteriser.drawing import find_visible, paint_visible, visible_gradient, workspace_for
from rasteriser.topology import Topology
from rasteriser.vectors import WIDE

FloatArray = npt.NDArray[np.float32]

CREASE = 0.0
"""Jump in the colour's change per pixel from which an edge inside the surface is antialiased, as contours are."""
HARD = -1.0
"""As `crease`: nothing is antialiased, contours neither. A pixel has the colour at its centre."""


class Gradients(NamedTuple):
    """Of pictures or log-likelihoods of N meshes."""

    screen: FloatArray
    """[N, V, 3] with respect to x, y and inverse depth."""
    colours: FloatArray
    """[N, V, C]."""


def draw(
    screen: FloatArray, colours: FloatArray, topology: Topology, width: int, height: int, crease: float = CREASE
) -> FloatArray:
    """Antialiased pictures [N, C, H, W] on black of N meshes that share one topology.

    `screen` [N, V, 3] holds x, y in pixels and inverse depth; `colours` [N, V, C] are linear. Edges inside the surface
    are antialiased where the colour's change per pixel jumps by `crease` or more, and so are lines where faces
    interpenetrate: 0 is exact; if it is infinite, only contours are antialiased, which is several times as fast; if it
    is HARD, nothing is, which is several times as fast again, but no function that could be followed downhill.

    Raises:
        ValueError: shapes that do not fit, or vertices that are not finite; the message names the first bad mesh.
    """
    screen, colours = checked(screen, colours, topology)
    out = np.empty((len(screen), colours.shape[2], height, width), np.float32)
    _pictures(get_num_threads(), screen, colours, contiguous(topology), crease, width, out)
    return out


def draw_each(
    meshes: Sequence[tuple[FloatArray, FloatArray, Topology]], width: int, height: int, crease: float = CREASE
) -> FloatArray:
    """Antialiased pictures [N, C, H, W] on black of meshes that share nothing: `screen` [V, 3], `colours` [V, C] and
    topology of each. Otherwise as `draw`.

    Raises:
        ValueError: as `draw` does; or the meshes differ in their number of channels.
    """
    singles = [
        checked(np.asarray(screen)[None], np.asarray(colours)[None], topology, number)
        for number, (screen, colours, topology) in enumerate(meshes)
    ]
    channels = {colours.shape[2] for _, colours in singles}
    if len(channels) > 1:
        raise ValueError(f"expected one number of colour channels in all meshes, found {sorted(channels)}")
    out = np.empty((len(meshes), max(channels, default=0), height, width), np.float32)
    if not meshes:
        return out
    parts = [contiguous(topology) for _, _, topology in meshes]
    packed = tuple(np.concatenate([part[k] for part in parts]) for k in range(4))
    sizes = [(screen.shape[1], len(part[0]), len(part[1])) for (screen, _), part in zip(singles, parts, strict=True)]
    offsets = np.cumsum([(0, 0, 0), *sizes], axis=0)
    screens, paints = (np.concatenate([one[which][0] for one in singles]) for which in range(2))
    _pictures_of_each(screens, paints, packed, offsets, crease, width, out)
    return out


def draw_gradient(
    screen: FloatArray,
    colours: FloatArray,
    topology: Topology,
    picture_gradients: FloatArray,
    crease: float = CREASE,
) -> Gradients:
    """Adjoint of `draw` for gradients [N, C, H, W] of the pictures. Raises as `draw` does."""
    screen, colours = checked(screen, colours, topology)
    gradients = Gradients(np.empty_like(screen), np.empty_like(colours))
    upstream = np.ascontiguousarray(picture_gradients, np.float32)
    if upstream.ndim != 4 or upstream.shape[:2] != (len(screen), colours.shape[2]):
        found = f"{list(upstream.shape)} for screen {list(screen.shape)} and colours {list(colours.shape)}"
        raise ValueError(f"expected gradients [N, C, H, W] of the pictures of all meshes and channels, found {found}")
    threads, width = get_num_threads(), upstream.shape[3]
    _picture_gradients(threads, screen, colours, contiguous(topology), crease, width, upstream, *gradients)
    return gradients


def checked(
    screen: FloatArray, colours: FloatArray, topology: Topology, number: int = 0
) -> tuple[FloatArray, FloatArray]:
    """Both as the kernels take them; the first mesh is called `number` in errors."""
    if screen.ndim != 3 or screen.shape[2] != 3 or colours.ndim != 3 or colours.shape[:2] != screen.shape[:2]:
        found = f"{list(screen.shape)} and {list(colours.shape)}"
        raise ValueError(f"expected screen [N, V, 3] and colours [N, V, C] of the same N and V, found {found}")
    if len(topology.faces) and not 0 <= topology.faces.min() <= topology.faces.max() < screen.shape[1]:
        found = f"{topology.faces.min()} to {topology.faces.max()}"
        raise ValueError(f"expected faces that name vertices 0 to {screen.shape[1] - 1}, found {found}")
    with np.errstate(over="ignore"):
        screen, colours = np.ascontiguousarray(screen, np.float32), np.ascontiguousarray(colours, np.float32)
    finite = np.isfinite(screen).all((1, 2)) & np.isfinite(colours).all((1, 2))
    if not finite.all():
        first = number + int(np.flatnonzero(~finite)[0])
        raise ValueError(f"expected finite vertices and colours, found NaN or infinity first in mesh {first}")
    return screen, colours


def contiguous(topology: Topology) -> tuple[npt.NDArray[np.int32], ...]:
    return tuple(np.ascontiguousarray(part) for part in topology)


@kernel(parallel=True, error_model="numpy")
def _pictures(threads, screen, colours, topology, crease, width, out):
    count, channels, height = len(screen), out.shape[1], out.shape[2]
    for thread in prange(threads):
        workspace = workspace_for(screen.shape[1], topology, channels, width, height)
        picture = np.zeros((channels, height, width + WIDE), np.float32)
        for n in range(thread, count, threads):
            _draw(screen[n], colours[n], topology, crease, workspace, width, picture, out[n])


@kernel(parallel=True, error_model="numpy")
def _pictures_of_each(screen, colours, topology, offsets, crease, width, out):
    faces, edges, edge_faces, face_edges = topology
    channels, height = out.shape[1], out.shape[2]
    for n in prange(len(out)):
        v0, f0, e0 = offsets[n, 0], offsets[n, 1], offsets[n, 2]
        v1, f1, e1 = offsets[n + 1, 0], offsets[n + 1, 1], offsets[n + 1, 2]
        mesh = (faces[f0:f1], edges[e0:e1], edge_faces[e0:e1], face_edges[f0:f1])
        workspace = workspace_for(v1 - v0, mesh, channels, width, height)
        picture = np.zeros((channels, height, width + WIDE), np.float32)
        _draw(screen[v0:v1], colours[v0:v1], mesh, crease, workspace, width, picture, out[n])


@kernel(error_model="numpy")
def _draw(screen, colours, topology, crease, workspace, width, picture, out):
    """Writes one picture to out [C, H, W]; `picture` [C, H, W + WIDE] is scratch, zero before and after."""
    box = bounding_box(screen, width, out.shape[1])
    pieces = find_visible(screen, colours, topology, crease, workspace, box, width, out.shape[1])
    paint_visible(workspace, pieces, width, picture)
    out[:] = 0.0
    copy_box(picture, box, out)
    left, top, right, bottom = box
    picture[:, top:bottom, left:right] = 0.0


@kernel(parallel=True, error_model="numpy")
def _picture_gradients(threads, screen, colours, topology, crease, width, upstream, screen_out, colours_out):
    count, channels, height = len(screen), upstream.shape[1], upstream.shape[2]
    for thread in prange(threads):
        workspace = workspace_for(screen.shape[1], topology, channels, width, height)
        gradient = np.zeros((channels, height, width + WIDE), np.float32)
        for n in range(thread, count, threads):
            left, top, right, bottom = box = bounding_box(screen[n], width, height)
            pieces = find_visible(screen[n], colours[n], topology, crease, workspace, box, width, height)
            # Whole vectors are read at the right: no numbers of another picture may stand there.
            copy_box(upstream[n], (left, top, min(right + WIDE, width), bottom), gradient)
            visible_gradient(screen[n], colours[n], topology, workspace, pieces, width, gradient)
            screen_out[n] = workspace[11]
            colours_out[n] = workspace[12]


@kernel(error_model="numpy", _nrt=False)
def copy_box(source, box, target):
    """Of all channels of [C, H, W or more]."""
    left, top, right, bottom = box
    for channel in range(source.shape[0]):
        for row in range(top, bottom):
            given, into = source[channel, row, left:right], target[channel, row, left:right]
            for column in range(right - left):
                into[column] = given[column]
