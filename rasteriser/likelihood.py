"""The fused kernels: from screen vertices and colours straight to log-likelihoods and gradients.

One picture, its residual and its pyramid stay in a core's cache; no picture reaches main memory. The gradient kernel
draws again whatever it is asked a gradient for, and skips what has a weight of zero: to draw twice the few poses that
matter is cheaper than to keep the pictures of all.

A mesh may be seen under several lights, each with colours of its own. What is seen where is then found once; the lights
are so many more channels of one drawing, and the target's pyramid is the same for all.
"""

import numpy as np
import numpy.typing as npt
from numba import get_num_threads, prange

from rasteriser.compilation import kernel
from rasteriser.coverage import bounding_box
from rasteriser.drawing import find_visible, paint_visible, visible_gradient, workspace_for
from rasteriser.levels import box_above, clear_below, level_arrays, level_table
from rasteriser.pictures import CREASE, FloatArray, Gradients, checked, contiguous
from rasteriser.pyramid import picture_pyramid, pyramid_gradient, pyramid_log_likelihood
from rasteriser.topology import Topology
from rasteriser.vectors import WIDE


def log_likelihood(
    screen: FloatArray,
    colours: FloatArray,
    topology: Topology,
    pictures: FloatArray,
    crease: float = CREASE,
    binarise: float = 0.0,
) -> npt.NDArray[np.float64]:
    """Log-likelihoods [N] (Eqs. 1 to 4, ε = 1, constants left out) of pictures [B, C, H, W] given N = B · R meshes.

    Mesh n explains picture n // R, so the R hypotheses of a picture stand together. `colours` are [N, V, C], or
    [N, V, L, C] for L lights; then log p is [N, L]. Lights share their creases, if `crease` is finite. Where `binarise`
    is positive, it is the η of the paper's silhouette loss: both pictures' pixels p become p / (p + η) first. Raises as
    `draw` does.
    """
    nothing = Gradients(np.empty((0, 0, 0), np.float32), np.empty((0, 0, 0), np.float32))
    scales = np.zeros(colours.shape[:1] + colours.shape[2:-1])
    everything = np.ones(scales.shape, np.bool_)
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
    """log p and the gradients of its sum, weighed by `scales`, which have log p's shape. What has a scale of 0 is not
    drawn and costs nothing; its log p is given as 0. Options and errors are those of `log_likelihood`."""
    gradients = Gradients(np.zeros(screen.shape, np.float32), np.zeros(colours.shape, np.float32))
    scales = np.ascontiguousarray(scales, np.float64)
    return _evaluate(screen, colours, topology, pictures, crease, binarise, scales != 0.0, scales, gradients), gradients


def _evaluate(
    screen: FloatArray,
    colours: FloatArray,
    topology: Topology,
    pictures: FloatArray,
    crease: float,
    binarise: float,
    asked: npt.NDArray[np.bool_],
    scales: npt.NDArray[np.float64],
    gradients: Gradients,
) -> npt.NDArray[np.float64]:
    lights = colours.shape[2] if colours.ndim == 4 else 1
    _check_hypotheses(colours, pictures, scales)
    screen, colours = checked(screen, colours.reshape(*colours.shape[:2], lights * colours.shape[-1]), topology)
    pictures = np.ascontiguousarray(pictures, np.float32)
    if binarise > 0.0:
        pictures = pictures / (pictures + np.float32(binarise))
    table, mesh = level_table(pictures.shape[3], pictures.shape[2]), contiguous(topology)
    values, asked = np.zeros((len(screen), lights)), asked.reshape(-1, lights)
    totals = np.zeros(len(pictures))
    to_colours = gradients.colours.reshape(*gradients.colours.shape[:2], colours.shape[2])
    _log_likelihood_gradients(
        get_num_threads(), screen, colours, mesh, crease, binarise, pictures, table, np.flatnonzero(asked.any(1)),
        asked, scales.reshape(-1, lights), totals, values, gradients.screen, to_colours,
    )  # fmt: skip
    # Large squares may overflow although the picture is finite.
    if not (np.isfinite(totals).all() or np.isfinite(pictures).all()):
        raise ValueError("expected finite pictures, found NaN or infinity")
    return values.reshape(scales.shape)


def _check_hypotheses(colours: FloatArray, pictures: FloatArray, scales: npt.NDArray[np.float64]) -> None:
    if colours.ndim not in (3, 4) or colours.shape[-1] != pictures.shape[1]:
        found = f"{list(colours.shape)} for pictures {list(pictures.shape)}"
        raise ValueError(f"expected colours [N, V, C] or [N, V, L, C] with the pictures' channels, found {found}")
    if len(pictures) == 0 or len(colours) % len(pictures):
        found = f"{len(colours)} and {len(pictures)}"
        raise ValueError(f"expected a whole number of meshes for each picture, found {found}")
    if scales.shape != colours.shape[:1] + colours.shape[2:-1]:
        found = f"{list(scales.shape)} for colours {list(colours.shape)}"
        raise ValueError(f"expected a scale for each hypothesis, [N] or [N, L], found {found}")


@kernel(parallel=True, error_model="numpy")
def _log_likelihood_gradients(
    threads, screen, colours, topology, crease, binarise, pictures, table, wanted, asked, scales,
    totals_out, values_out, screen_out, colours_out,
):  # fmt: skip
    channels, height, width = pictures.shape[1:]
    per_picture, size, vertices = len(screen) // len(pictures), table[-1, 3], screen.shape[1]
    painted = colours.shape[2]
    for thread in prange(threads):
        workspace = workspace_for(vertices, topology, painted, width, height)
        scratch = (
            level_arrays(painted, size),
            np.empty((height // 2 + 5) * (width + WIDE) + 8 * WIDE, np.float32),
            np.empty((len(table), 4), np.int64),
            np.empty((painted, height, width) if binarise > 0.0 else (0, 0, 0), np.float32),
        )
        lights, paint = np.empty(asked.shape[1], np.int64), np.empty(vertices * painted, np.float32)
        # The hypotheses of a picture stand together: its pyramid is made when the first of them comes.
        target, total, known = level_arrays(channels, size), 0.0, -1
        for i in range(thread * len(wanted) // threads, (thread + 1) * len(wanted) // threads):
            n = wanted[i]
            if n // per_picture != known:
                known, total = n // per_picture, 0.0
                for c in range(channels):
                    total += picture_pyramid(pictures[known, c], table, target[c], scratch[1])
                totals_out[known] = total
            count = 0
            for light in range(len(lights)):
                # Where the jump of a colour decides what is a crease, those of all lights do.
                if asked[n, light] or 0.0 < crease < np.inf:
                    lights[count] = light
                    count += 1
            chosen = paint[: vertices * count * channels].reshape(vertices, count * channels)
            for v in range(vertices):
                for k in range(count):
                    for c in range(channels):
                        chosen[v, k * channels + c] = colours[n, v, lights[k] * channels + c]
            _log_likelihood_and_gradient(
                screen[n], chosen, topology, crease, binarise, target, total, table, workspace, scratch,
                lights[:count], scales[n], values_out[n],
            )  # fmt: skip
            if scales[n].any():
                screen_out[n] = workspace[11]
                for k in range(count):
                    into = lights[k] * channels
                    colours_out[n, :, into : into + channels] = workspace[12][:, k * channels : (k + 1) * channels]


@kernel(error_model="numpy")
def _log_likelihood_and_gradient(
    screen, colours, topology, crease, binarise, target, total, table, workspace, scratch, lights, scales, values
):
    """Writes log p of one picture under some lights, whose channels stand one after the other in colours [V, K · C],
    to values [L]; the picture is given as the pyramids target [C, T] of its channels and the sum of their squares.

    Unless all scales are 0, also leaves Σ scale · d log p in the workspace, and 0 as the value of lights without one.
    """
    levels, half, level_boxes, slopes = scratch
    levels = levels[: colours.shape[1]]
    channels, height, width = len(target), table[0, 0], table[0, 1]
    gradient = scales.any()
    box = bounding_box(screen, width, height)
    if box[2] <= box[0] or box[3] <= box[1]:
        workspace[11][:] = 0.0
        workspace[12][:] = 0.0
        for light in lights:
            values[light] = 0.0 if gradient and scales[light] == 0.0 else -0.5 * total
        return
    start, stride = table[0, 3], table[0, 2]
    if len(table) > 2:
        above = box_above(box, table[1, 0], table[1, 1])
        for c in range(len(levels)):
            clear_below(levels[c], start, table, 0, above)
    else:
        levels[:] = 0.0
    picture = levels[:, start : start + height * stride]
    picture = np.lib.stride_tricks.as_strided(
        picture, (len(levels), height, stride), (levels.strides[0], stride * levels.itemsize, levels.itemsize)
    )
    pieces = find_visible(screen, colours, topology, crease, workspace, box, width, height)
    paint_visible(workspace, pieces, width, picture)
    if binarise > 0.0:
        binarise_box(picture, box, np.float32(binarise), slopes)
    for k in range(len(lights)):
        value, scale = 0.0, scales[lights[k]]
        if gradient and scale == 0.0:
            picture[k * channels : (k + 1) * channels] = 0.0
            values[lights[k]] = 0.0
            continue
        for c in range(channels):
            mine = levels[k * channels + c]
            value += pyramid_log_likelihood(table, box, mine, target[c], 0.0, scale, level_boxes, half)
            if gradient:
                pyramid_gradient(table, level_boxes, mine, half)
        values[lights[k]] = value - 0.5 * total
    if gradient:
        if binarise > 0.0:
            multiply_box(picture, box, slopes)
        visible_gradient(screen, colours, topology, workspace, pieces, width, picture)


@kernel(error_model="numpy", _nrt=False)
def binarise_box(picture, box, eta, slopes):
    """Pixels p inside a box become p / (p + η), and slopes [C, H, W] the derivative of that."""
    left, top, right, bottom = box
    for c in range(picture.shape[0]):
        for iy in range(top, bottom):
            for ix in range(left, right):
                # Where contours alone are antialiased, what they take away may be more than there is.
                inverse = np.float32(1.0) / (max(picture[c, iy, ix], np.float32(0.0)) + eta)
                slopes[c, iy, ix] = eta * inverse * inverse if picture[c, iy, ix] >= 0.0 else np.float32(0.0)
                picture[c, iy, ix] = np.float32(1.0) - eta * inverse


@kernel(error_model="numpy", _nrt=False)
def multiply_box(picture, box, factors):
    left, top, right, bottom = box
    for c in range(picture.shape[0]):
        for iy in range(top, bottom):
            for ix in range(left, right):
                picture[c, iy, ix] *= factors[c, iy, ix]
