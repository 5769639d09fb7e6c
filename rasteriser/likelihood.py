"""The fused kernels: from screen vertices and colours straight to log-likelihoods and gradients.

One picture, its residual and its pyramid stay in a core's cache; no picture reaches main memory. The gradient kernel
draws again whatever it is asked a gradient for, and skips what has a weight of zero: to draw twice the few poses that
matter is cheaper than to keep the pictures of all.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from numba import get_num_threads, njit, prange

from rasteriser.antialias import add_pieces, pieces_gradient
from rasteriser.coverage import LANES, bounding_box, rasterise, set_up_edges, set_up_faces
from rasteriser.grid import grid_over, sort_into_cells
from rasteriser.pieces import find_pieces
from rasteriser.pyramid import (
    box_above,
    clear_below,
    level_table,
    picture_pyramid,
    pyramid_gradient,
    pyramid_log_likelihood,
)
from rasteriser.segments import cuts_between, find_segments
from rasteriser.shading import add_interior, faces_gradient, interior_gradient
from rasteriser.topology import Topology

FloatArray = npt.NDArray[np.float32]

CREASE = 0.0
"""Jump in the colour's change per pixel from which an edge inside the surface is antialiased, as contours are."""


class Gradients(NamedTuple):
    """Of pictures or log-likelihoods of N meshes."""

    screen: FloatArray
    """[N, V, 3] with respect to x, y and inverse depth."""
    colours: FloatArray
    """[N, V, C]."""


@njit(cache=True, nogil=True, error_model="numpy")
def _workspace(vertex_count, topology, channels, width, height):
    """Scratch memory of one thread: what is known of edges, faces and pixels (8 arrays), gradients (3), lanes."""
    face_count, edge_count = len(topology[0]), len(topology[1])
    return (
        np.empty((edge_count, 3)),
        np.empty((face_count, 1 + 2 * channels, 3)),
        np.empty((face_count, 3), np.int8),
        np.empty((edge_count, 2), np.int8),
        np.empty((face_count, 6)),
        np.empty((height, width + LANES)),
        np.empty((height, width + LANES), np.int32),
        np.empty(face_count, np.bool_),
        np.empty((face_count, 1 + 2 * channels, 3)),
        np.empty((vertex_count, 3)),
        np.empty((vertex_count, channels)),
        np.empty(LANES),
    )


@njit(cache=True, nogil=True, error_model="numpy")
def _draw(screen, colours, topology, crease, workspace, box, width, picture):
    """Adds the antialiased picture of one mesh to picture [C, H, W + LANES], inside its box.

    Returns the pieces of contour, crease and crossing, for `_draw_gradient`.
    """
    faces, edges, edge_faces, face_edges = topology
    lines, planes, sides, edge_sides, boxes, nearest, visible, seen = workspace[:8]
    channels, height = picture.shape[0], picture.shape[1]
    set_up_edges(screen, edges, lines)
    set_up_faces(screen, colours, faces, edge_faces, face_edges, lines, planes, sides, edge_sides, boxes)
    rasterise(face_edges, lines, planes, sides, boxes, box, width, nearest, visible, seen)
    add_interior(planes, boxes, seen, visible, width, workspace[11], picture)

    grid = grid_over(box, len(faces))
    spans, starts, items = sort_into_cells(boxes, len(faces), grid)
    ends, segment_codes, count = find_segments(
        screen, faces, edges, edge_faces, face_edges, lines, planes, sides, edge_sides, boxes, channels, crease,
        width, height, grid, spans, starts, items,
    )  # fmt: skip
    heads, links, link_places, link_count = cuts_between(ends, count, box)
    points, codes, found = find_pieces(
        edges, face_edges, lines, planes, sides, grid, starts, items, ends, segment_codes, count,
        heads, links, link_places, link_count, width, height,
    )  # fmt: skip
    add_pieces(planes, boxes, points, codes, found, picture)
    return segment_codes, points, codes, found


@njit(cache=True, nogil=True, error_model="numpy")
def _draw_gradient(screen, colours, topology, workspace, pieces, box, picture_gradient):
    """Adjoint of `_draw`, right after it; leaves the gradients of vertices and colours in the workspace."""
    faces, edges = topology[0], topology[1]
    lines, planes, sides, _, boxes, nearest, visible = workspace[:7]
    plane_gradients, screen_gradient, colour_gradient = workspace[8:11]
    segment_codes, points, codes, found = pieces
    plane_gradients[:] = 0.0
    screen_gradient[:] = 0.0
    colour_gradient[:] = 0.0
    interior_gradient(planes, box, nearest, visible, picture_gradient, plane_gradients)
    pieces_gradient(
        screen, edges, lines, planes, boxes, segment_codes, points, codes, found, picture_gradient,
        plane_gradients, screen_gradient,
    )  # fmt: skip
    faces_gradient(screen, colours, faces, planes, sides, plane_gradients, screen_gradient, colour_gradient)


@njit(cache=True, nogil=True, error_model="numpy", _nrt=False)
def binarise_box(picture, box, eta, slopes):
    """Pixels p inside a box become p / (p + η), and slopes [C, H, W] the derivative of that."""
    left, top, right, bottom = box
    for c in range(picture.shape[0]):
        for iy in range(top, bottom):
            for ix in range(left, right):
                # Rounding may leave a black pixel a hair below zero.
                inverse = np.float32(1.0) / (max(picture[c, iy, ix], np.float32(0.0)) + eta)
                slopes[c, iy, ix] = eta * inverse * inverse
                picture[c, iy, ix] = np.float32(1.0) - eta * inverse


@njit(cache=True, nogil=True, error_model="numpy", _nrt=False)
def multiply_box(picture, box, factors):
    left, top, right, bottom = box
    for c in range(picture.shape[0]):
        for iy in range(top, bottom):
            for ix in range(left, right):
                picture[c, iy, ix] *= factors[c, iy, ix]


@njit(cache=True, nogil=True, error_model="numpy")
def _log_likelihood_and_gradient(
    screen, colours, topology, crease, binarise, target, total, table, workspace, scratch, scale
):
    """log p of one picture, given as the pyramids target [C, T] of its channels and the sum of their squares.

    Where scale is not 0, also scale · d log p, left in the workspace.
    """
    levels, half, level_boxes, slopes = scratch
    channels, height, width = len(target), table[0, 0], table[0, 1]
    box = bounding_box(screen, width, height)
    if box[2] <= box[0] or box[3] <= box[1]:
        workspace[9][:] = 0.0
        workspace[10][:] = 0.0
        return -0.5 * total
    start, stride = table[0, 3], table[0, 2]
    if len(table) > 2:
        above = box_above(box, table[1, 0], table[1, 1])
        for c in range(channels):
            clear_below(levels[c], start, table, 0, above)
    else:
        levels[:] = 0.0
    picture = levels[:, start : start + height * stride]
    picture = np.lib.stride_tricks.as_strided(
        picture, (channels, height, stride), (levels.strides[0], stride * levels.itemsize, levels.itemsize)
    )
    pieces = _draw(screen, colours, topology, crease, workspace, box, width, picture)
    if binarise > 0.0:
        binarise_box(picture, box, np.float32(binarise), slopes)
    value = 0.0
    for c in range(channels):
        value += pyramid_log_likelihood(table, box, levels[c], target[c], 0.0, level_boxes, half)
        if scale != 0.0:
            pyramid_gradient(table, level_boxes, levels[c], half, scale)
    if scale != 0.0:
        if binarise > 0.0:
            multiply_box(picture, box, slopes)
        _draw_gradient(screen, colours, topology, workspace, pieces, box, picture)
    return value - 0.5 * total


@njit(cache=True, nogil=True, parallel=True, error_model="numpy")
def _log_likelihood_gradients(
    threads, screen, colours, topology, crease, binarise, pictures, table, wanted, scales,
    values_out, screen_out, colours_out,
):  # fmt: skip
    channels, height, width = pictures.shape[1:]
    per_picture, size = len(screen) // len(pictures), table[-1, 3]
    for thread in prange(threads):
        workspace = _workspace(screen.shape[1], topology, channels, width, height)
        scratch = (
            np.zeros((channels, size), np.float32),
            np.empty((height // 2 + 4) * (width + LANES), np.float32),
            np.empty((len(table), 4), np.int64),
            np.empty((channels, height, width) if binarise > 0.0 else (0, 0, 0), np.float32),
        )
        # The hypotheses of a picture stand together: its pyramid is made when the first of them comes.
        target, total, known = np.empty((channels, size), np.float32), 0.0, -1
        for i in range(thread * len(wanted) // threads, (thread + 1) * len(wanted) // threads):
            n = wanted[i]
            if n // per_picture != known:
                known, total = n // per_picture, 0.0
                for c in range(channels):
                    total += picture_pyramid(pictures[known, c], table, target[c], scratch[1])
            values_out[n] = _log_likelihood_and_gradient(
                screen[n], colours[n], topology, crease, binarise, target, total, table, workspace, scratch, scales[n]
            )
            if scales[n] != 0.0:
                screen_out[n] = workspace[9]
                colours_out[n] = workspace[10]


@njit(cache=True, nogil=True, parallel=True, error_model="numpy")
def _pictures(threads, screen, colours, topology, crease, width, out):
    count, channels, height = len(screen), out.shape[1], out.shape[2]
    for thread in prange(threads):
        workspace = _workspace(screen.shape[1], topology, channels, width, height)
        picture = np.zeros((channels, height, width + LANES), np.float32)
        for n in range(thread, count, threads):
            picture[:] = 0.0
            box = bounding_box(screen[n], width, height)
            _draw(screen[n], colours[n], topology, crease, workspace, box, width, picture)
            out[n] = picture[:, :, :width]


@njit(cache=True, nogil=True, parallel=True, error_model="numpy")
def _pictures_of_each(screen, colours, topology, offsets, crease, width, out):
    faces, edges, edge_faces, face_edges = topology
    channels, height = out.shape[1], out.shape[2]
    for n in prange(len(out)):
        v0, f0, e0 = offsets[n, 0], offsets[n, 1], offsets[n, 2]
        v1, f1, e1 = offsets[n + 1, 0], offsets[n + 1, 1], offsets[n + 1, 2]
        mesh = (faces[f0:f1], edges[e0:e1], edge_faces[e0:e1], face_edges[f0:f1])
        workspace = _workspace(v1 - v0, mesh, channels, width, height)
        picture = np.zeros((channels, height, width + LANES), np.float32)
        box = bounding_box(screen[v0:v1], width, height)
        _draw(screen[v0:v1], colours[v0:v1], mesh, crease, workspace, box, width, picture)
        out[n] = picture[:, :, :width]


@njit(cache=True, nogil=True, parallel=True, error_model="numpy")
def _picture_gradients(threads, screen, colours, topology, crease, width, upstream, screen_out, colours_out):
    count, channels, height = len(screen), upstream.shape[1], upstream.shape[2]
    for thread in prange(threads):
        workspace = _workspace(screen.shape[1], topology, channels, width, height)
        picture = np.zeros((channels, height, width + LANES), np.float32)
        for n in range(thread, count, threads):
            box = bounding_box(screen[n], width, height)
            pieces = _draw(screen[n], colours[n], topology, crease, workspace, box, width, picture)
            picture[:, :, :width] = upstream[n]
            _draw_gradient(screen[n], colours[n], topology, workspace, pieces, box, picture)
            screen_out[n] = workspace[9]
            colours_out[n] = workspace[10]


def draw(
    screen: FloatArray, colours: FloatArray, topology: Topology, width: int, height: int, crease: float = CREASE
) -> FloatArray:
    """Antialiased pictures [N, C, H, W] on black of N meshes that share one topology.

    `screen` [N, V, 3] holds x, y in pixels and inverse depth; `colours` [N, V, C] are linear. Edges inside the surface
    are antialiased where the colour's change per pixel jumps by `crease` or more, and so are lines where faces
    interpenetrate: 0 is exact; if it is infinite, only contours are antialiased, which takes a third of the time.

    Raises:
        ValueError: shapes that do not fit, or vertices that are not finite; the message names the first bad mesh.
    """
    screen, colours = _checked(screen, colours, topology)
    out = np.empty((len(screen), colours.shape[2], height, width), np.float32)
    _pictures(get_num_threads(), screen, colours, _contiguous(topology), crease, width, out)
    return out


def draw_each(
    meshes: Sequence[tuple[FloatArray, FloatArray, Topology]], width: int, height: int, crease: float = CREASE
) -> FloatArray:
    """Antialiased pictures [N, C, H, W] on black of meshes that share nothing: `screen` [V, 3], `colours` [V, C] and
    topology of each. Otherwise as `draw`.

    Raises:
        ValueError: as `draw` does; or the meshes differ in their number of channels.
    """
    checked = [
        _checked(np.asarray(screen)[None], np.asarray(colours)[None], topology) for screen, colours, topology in meshes
    ]
    channels = {colours.shape[2] for _, colours in checked}
    if len(channels) > 1:
        raise ValueError(f"expected one number of colour channels in all meshes, found {sorted(channels)}")
    out = np.empty((len(meshes), max(channels, default=0), height, width), np.float32)
    if not meshes:
        return out
    parts = [_contiguous(topology) for _, _, topology in meshes]
    packed = tuple(np.concatenate([part[k] for part in parts]) for k in range(4))
    sizes = [(screen.shape[1], len(part[0]), len(part[1])) for (screen, _), part in zip(checked, parts, strict=True)]
    offsets = np.cumsum([(0, 0, 0), *sizes], axis=0)
    screens, paints = (np.concatenate([one[which][0] for one in checked]) for which in range(2))
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
    screen, colours = _checked(screen, colours, topology)
    gradients = Gradients(np.empty_like(screen), np.empty_like(colours))
    upstream = np.ascontiguousarray(picture_gradients, np.float32)
    threads, width = get_num_threads(), upstream.shape[3]
    _picture_gradients(threads, screen, colours, _contiguous(topology), crease, width, upstream, *gradients)
    return gradients


def log_likelihood(
    screen: FloatArray,
    colours: FloatArray,
    topology: Topology,
    pictures: FloatArray,
    crease: float = CREASE,
    binarise: float = 0.0,
) -> npt.NDArray[np.float64]:
    """Log-likelihoods [N] (Eqs. 1 to 4, ε = 1, constants left out) of pictures [B, C, H, W] given N = B · R meshes.

    Mesh n explains picture n // R, so the R hypotheses of a picture stand together. Where `binarise` is positive, it is
    the η of the paper's silhouette loss: both pictures' pixels p become p / (p + η) first. Raises as `draw` does.
    """
    screen, colours = _checked(screen, colours, topology)
    nothing = Gradients(np.empty((0, 0, 0), np.float32), np.empty((0, 0, 0), np.float32))
    everything, scales = np.arange(len(screen)), np.zeros(len(screen))
    return _evaluate(screen, colours, topology, pictures, crease, binarise, everything, scales, nothing)


def log_likelihood_gradient(
    screen: FloatArray,
    colours: FloatArray,
    topology: Topology,
    pictures: FloatArray,
    scales: npt.NDArray[np.float64],
    crease: float = CREASE,
    binarise: float = 0.0,
) -> tuple[npt.NDArray[np.float64], Gradients]:
    """log p_n [N], and the gradients of Σ_n scales_n · log p_n. Meshes whose scale is 0 cost nothing, and their log p
    is given as 0. Options and errors are those of `log_likelihood`."""
    screen, colours = _checked(screen, colours, topology)
    gradients = Gradients(np.zeros_like(screen), np.zeros_like(colours))
    scales = np.ascontiguousarray(scales, np.float64)
    wanted = np.flatnonzero(scales)
    return _evaluate(screen, colours, topology, pictures, crease, binarise, wanted, scales, gradients), gradients


def _evaluate(
    screen: FloatArray,
    colours: FloatArray,
    topology: Topology,
    pictures: FloatArray,
    crease: float,
    binarise: float,
    wanted: npt.NDArray[np.int64],
    scales: npt.NDArray[np.float64],
    gradients: Gradients,
) -> npt.NDArray[np.float64]:
    _check_hypotheses(len(screen), len(pictures))
    pictures = np.ascontiguousarray(pictures, np.float32)
    if binarise > 0.0:
        pictures = pictures / (pictures + np.float32(binarise))
    table, values, mesh = (
        level_table(pictures.shape[3], pictures.shape[2]),
        np.zeros(len(screen)),
        _contiguous(topology),
    )
    _log_likelihood_gradients(
        get_num_threads(), screen, colours, mesh, crease, binarise, pictures, table, wanted, scales, values, *gradients
    )
    return values


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


def _check_hypotheses(meshes: int, pictures: int) -> None:
    if pictures == 0 or meshes % pictures:
        raise ValueError(f"expected a whole number of meshes for each picture, found {meshes} and {pictures}")
