"""The fused kernels: from screen vertices and colours straight to log-likelihoods and gradients.

One picture, its residual and its pyramid stay in a core's cache; no picture reaches main memory. The gradient kernel
draws again whatever it is asked a gradient for, and skips what has a weight of zero: to draw twice the few poses that
matter is cheaper than to keep the pictures of all.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from numba import get_num_threads, njit, prange

from rasteriser.antialias import add_contours, contours_gradient
from rasteriser.coverage import bounding_box, rasterise, set_up_edges, set_up_faces
from rasteriser.pyramid import pyramid_gradient, pyramid_log_likelihood
from rasteriser.shading import add_interior, faces_gradient, interior_gradient
from rasteriser.topology import Topology

FloatArray = npt.NDArray[np.float32]


class Gradients(NamedTuple):
    """Of pictures or log-likelihoods of N meshes."""

    screen: FloatArray
    """[N, V, 3] with respect to x, y and inverse depth."""
    colours: FloatArray
    """[N, V, C]."""


@njit(cache=True, nogil=True, error_model="numpy")
def _workspace(vertex_count, topology, picture_shape):
    """Scratch memory of one thread: what a mesh looks like (7 arrays), gradients (3), residual and pyramid (3)."""
    channels, height, width = picture_shape
    face_count, edge_count = len(topology[0]), len(topology[1])
    return (
        np.empty((edge_count, 3)),
        np.empty((face_count, 1 + channels, 3)),
        np.empty((face_count, 3), np.int8),
        np.empty((height + 2, width + 2)),
        np.empty((height + 2, width + 2), np.int32),
        np.empty(height + width + 8),
        np.empty(height + width + 8, np.int8),
        np.empty((face_count, 1 + channels, 3)),
        np.empty((vertex_count, 3)),
        np.empty((vertex_count, channels)),
        np.empty(picture_shape, np.float32),
        np.empty(2 * height * width + 2 * (height + width) + 8, np.float32),
        np.empty(height * width + height + width + 8, np.float32),
    )


@njit(cache=True, nogil=True, error_model="numpy")
def _draw(screen, colours, topology, workspace, picture):
    """Adds the antialiased picture of one mesh to picture [C, H, W]; returns the box that it lies in."""
    faces, edges, edge_faces, face_edges = topology
    lines, planes, sides, nearest, visible, cuts, kinds = workspace[:7]
    set_up_edges(screen, edges, lines)
    set_up_faces(screen, colours, faces, face_edges, lines, planes, sides)
    box = bounding_box(screen, picture.shape[2], picture.shape[1])
    rasterise(screen, faces, face_edges, lines, planes, sides, box, nearest, visible)
    add_interior(planes, visible, box, picture)
    add_contours(screen, colours, edges, edge_faces, face_edges, lines, planes, sides, visible, cuts, kinds, picture)
    return box


@njit(cache=True, nogil=True, error_model="numpy")
def _draw_gradient(screen, colours, topology, workspace, box, picture_gradient):
    """Adjoint of `_draw`, right after it; leaves the gradients of vertices and colours in the workspace."""
    faces, edges, edge_faces, face_edges = topology
    lines, planes, sides, _, visible, cuts, kinds = workspace[:7]
    plane_gradients, screen_gradient, colour_gradient = workspace[7:10]
    plane_gradients[:] = 0.0
    screen_gradient[:] = 0.0
    colour_gradient[:] = 0.0
    interior_gradient(planes, visible, box, picture_gradient, plane_gradients)
    contours_gradient(
        screen, colours, edges, edge_faces, face_edges, lines, planes, sides, visible, cuts, kinds, picture_gradient,
        plane_gradients, screen_gradient, colour_gradient,
    )  # fmt: skip
    faces_gradient(screen, colours, faces, planes, sides, plane_gradients, screen_gradient, colour_gradient)


@njit(cache=True, nogil=True, error_model="numpy")
def _log_likelihood_and_gradient(screen, colours, topology, picture, workspace, scale):
    """log p of one picture [C, H, W]; where scale is not 0, also scale · d log p, left in the workspace."""
    channels, height, width = picture.shape
    residual, levels, half = workspace[10:13]
    pixels = height * width
    for c in range(channels):
        for y in range(height):
            for x in range(width):
                residual[c, y, x] = -picture[c, y, x]
    box = _draw(screen, colours, topology, workspace, residual)
    total = 0.0
    for c in range(channels):
        channel = residual[c].reshape(pixels)
        levels[:pixels] = channel
        total += pyramid_log_likelihood(height, width, levels, half)
        if scale != 0.0:
            pyramid_gradient(height, width, levels, half, scale)
            channel[:] = levels[:pixels]
    if scale != 0.0:
        _draw_gradient(screen, colours, topology, workspace, box, residual)
    return total


@njit(cache=True, nogil=True, parallel=True, error_model="numpy")
def _log_likelihoods(threads, screen, colours, topology, pictures, per_picture, out):
    count = screen.shape[0]
    for thread in prange(threads):
        workspace = _workspace(screen.shape[1], topology, pictures.shape[1:])
        for n in range(thread, count, threads):
            picture = pictures[n // per_picture]
            out[n] = _log_likelihood_and_gradient(screen[n], colours[n], topology, picture, workspace, 0.0)


@njit(cache=True, nogil=True, parallel=True, error_model="numpy")
def _log_likelihood_gradients(
    threads, screen, colours, topology, pictures, per_picture, scales, values_out, screen_out, colours_out
):
    wanted = np.flatnonzero(scales)
    values_out[:] = 0.0
    screen_out[:] = 0.0
    colours_out[:] = 0.0
    for thread in prange(threads):
        workspace = _workspace(screen.shape[1], topology, pictures.shape[1:])
        for i in range(thread, len(wanted), threads):
            n = wanted[i]
            picture = pictures[n // per_picture]
            values_out[n] = _log_likelihood_and_gradient(screen[n], colours[n], topology, picture, workspace, scales[n])
            screen_out[n] = workspace[8]
            colours_out[n] = workspace[9]


@njit(cache=True, nogil=True, parallel=True, error_model="numpy")
def _pictures(threads, screen, colours, topology, out):
    count = screen.shape[0]
    for thread in prange(threads):
        workspace = _workspace(screen.shape[1], topology, out.shape[1:])
        for n in range(thread, count, threads):
            _draw(screen[n], colours[n], topology, workspace, out[n])


@njit(cache=True, nogil=True, parallel=True, error_model="numpy")
def _picture_gradients(threads, screen, colours, topology, picture_gradients, screen_out, colours_out):
    count = screen.shape[0]
    for thread in prange(threads):
        workspace = _workspace(screen.shape[1], topology, picture_gradients.shape[1:])
        scratch = np.empty(picture_gradients.shape[1:], np.float32)
        for n in range(thread, count, threads):
            box = _draw(screen[n], colours[n], topology, workspace, scratch)
            _draw_gradient(screen[n], colours[n], topology, workspace, box, picture_gradients[n])
            screen_out[n] = workspace[8]
            colours_out[n] = workspace[9]


def draw(screen: FloatArray, colours: FloatArray, topology: Topology, width: int, height: int) -> FloatArray:
    """Antialiased pictures [N, C, H, W] on black of N meshes that share one topology.

    `screen` [N, V, 3] holds x, y in pixels and inverse depth; `colours` [N, V, C] are linear.

    Raises:
        ValueError: shapes that do not fit, or vertices that are not finite; the message names the first bad mesh.
    """
    screen, colours = _checked(screen, colours, topology)
    out = np.zeros((len(screen), colours.shape[2], height, width), np.float32)
    _pictures(get_num_threads(), screen, colours, _contiguous(topology), out)
    return out


def draw_gradient(
    screen: FloatArray, colours: FloatArray, topology: Topology, picture_gradients: FloatArray
) -> Gradients:
    """Adjoint of `draw` for gradients [N, C, H, W] of the pictures. Raises as `draw` does."""
    screen, colours = _checked(screen, colours, topology)
    gradients = Gradients(np.empty_like(screen), np.empty_like(colours))
    upstream = np.ascontiguousarray(picture_gradients, np.float32)
    _picture_gradients(get_num_threads(), screen, colours, _contiguous(topology), upstream, *gradients)
    return gradients


def log_likelihood(
    screen: FloatArray, colours: FloatArray, topology: Topology, pictures: FloatArray
) -> npt.NDArray[np.float64]:
    """Log-likelihoods [N] (Eqs. 1 to 4, ε = 1, constants left out) of pictures [B, C, H, W] given N = B · R meshes.

    Mesh n explains picture n // R, so the R hypotheses of a picture stand together. Raises as `draw` does.
    """
    screen, colours = _checked(screen, colours, topology)
    out = np.empty(len(screen))
    per_picture = _hypotheses(len(screen), len(pictures))
    pictures = np.ascontiguousarray(pictures, np.float32)
    _log_likelihoods(get_num_threads(), screen, colours, _contiguous(topology), pictures, per_picture, out)
    return out


def log_likelihood_gradient(
    screen: FloatArray, colours: FloatArray, topology: Topology, pictures: FloatArray, scales: npt.NDArray[np.float64]
) -> tuple[npt.NDArray[np.float64], Gradients]:
    """log p_n [N], and the gradients of Σ_n scales_n · log p_n. Meshes whose scale is 0 cost nothing, and their log p
    is given as 0. Raises as `draw` does."""
    screen, colours = _checked(screen, colours, topology)
    values = np.empty(len(screen))
    gradients = Gradients(np.empty_like(screen), np.empty_like(colours))
    per_picture = _hypotheses(len(screen), len(pictures))
    pictures = np.ascontiguousarray(pictures, np.float32)
    scales = np.ascontiguousarray(scales, np.float64)
    mesh, threads = _contiguous(topology), get_num_threads()
    _log_likelihood_gradients(threads, screen, colours, mesh, pictures, per_picture, scales, values, *gradients)
    return values, gradients


def _checked(screen: FloatArray, colours: FloatArray, topology: Topology) -> tuple[FloatArray, FloatArray]:
    if screen.ndim != 3 or screen.shape[2] != 3 or colours.ndim != 3 or colours.shape[:2] != screen.shape[:2]:
        found = f"{list(screen.shape)} and {list(colours.shape)}"
        raise ValueError(f"expected screen [N, V, 3] and colours [N, V, C] of the same N and V, found {found}")
    if len(topology.faces) and not 0 <= topology.faces.min() <= topology.faces.max() < screen.shape[1]:
        raise ValueError(f"expected faces that name vertices 0 to {screen.shape[1] - 1}, found {topology.faces.max()}")
    finite = np.isfinite(screen).all((1, 2)) & np.isfinite(colours).all((1, 2))
    if not finite.all():
        first = int(np.flatnonzero(~finite)[0])
        raise ValueError(f"expected finite vertices and colours, found NaN or infinity first in mesh {first}")
    return np.ascontiguousarray(screen, np.float32), np.ascontiguousarray(colours, np.float32)


def _contiguous(topology: Topology) -> tuple[npt.NDArray[np.int32], ...]:
    return tuple(np.ascontiguousarray(part) for part in topology)


def _hypotheses(meshes: int, pictures: int) -> int:
    if pictures == 0 or meshes % pictures:
        raise ValueError(f"expected a whole number of meshes for each picture, found {meshes} and {pictures}")
    return meshes // pictures
