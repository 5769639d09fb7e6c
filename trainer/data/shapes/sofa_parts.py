"""The parts of a sofa: upholstered blocks, runs of seats with a back behind them, arms and legs.

A run is centred on x = 0 with its back at -z; what stands beside it is placed by whoever puts the sofa together.
"""

from typing import Literal, NamedTuple

import numpy as np
from jaxtyping import Float64
from numpy import ndarray

from trainer.data.shapes.solid import Mesh, Point, both_sides, box, cylinder, joined, loft, moved, prism, tube, turned

BackKind = Literal["plain", "cushions", "roll", "hump"]
ArmKind = Literal["block", "soft", "roll", "slope", "flare", "frame"]
LegKind = Literal["blocks", "splayed", "round", "sled"]
LEG_KINDS: tuple[LegKind, ...] = ("blocks", "splayed", "round", "sled")
ARM_KINDS: tuple[ArmKind, ...] = ("block", "soft", "roll", "slope", "flare", "frame")

# A rounded corner has three points, so that neighbouring faces meet at 30 degrees and are shaded as one surface.
_BENDS = np.radians([15.0, 45.0, 75.0])
_ANGLES = (_BENDS + np.arange(4)[:, None] * np.pi / 2).reshape(-1)
# Stretched, so that the flat sides in between lie where the size says.
_STRETCH = 1 / np.cos(_BENDS[0])
_OUTWARDS = _STRETCH * np.stack((np.cos(_ANGLES), np.sin(_ANGLES)), -1)
_CORNERS = np.sign(_OUTWARDS)


class Style(NamedTuple):
    """The measures that all parts share, metres."""

    depth: float
    """From the back's rear to the seat's front."""
    seat: float
    """Height of the seat."""
    top: float
    """Height of the back."""
    back: float
    """Thickness of the back's frame."""
    lift: float
    """From the floor to the body."""
    pad: float
    """Thickness of the seat cushions."""
    soft: float
    """Radius of the upholstered edges."""
    lean: float
    """Of the back, radians."""
    back_kind: BackKind

    @property
    def front(self) -> float:
        return self.depth / 2


def soft(size: Point, centre: Point = (0.0, 0.0, 0.0), radius: float = 0.03, crown: float = 0.0) -> Mesh:
    """A cuboid with rounded edges and corners, whose upper side rises by `crown` towards its middle."""
    x, y, z = size[0] / 2, size[1] / 2, size[2] / 2
    radius = min(radius, 0.98 * min(x, y, z))
    bends = np.concatenate((-_BENDS[::-1], _BENDS))[:, None, None]
    flat = radius * _STRETCH * np.cos(bends)
    outline = _CORNERS * (np.array((x, z)) - radius) + flat * _OUTWARDS
    heights = np.sign(bends) * (y - radius) + radius * _STRETCH * np.sin(bends)
    rings = np.empty((*outline.shape[:2], 3))
    rings[..., ::2], rings[..., 1] = outline, heights[..., 0]
    block = loft(rings)
    # The last vertex is the middle of the upper cap.
    block.vertices[-1, 1] += crown
    return moved(block, centre)


def rounded_rectangle(
    half_width: float, half_height: float, radius: float, centre: tuple[float, float] = (0.0, 0.0)
) -> Float64[ndarray, "12 2"]:
    """Its outline about a centre, three points a corner."""
    outline: Float64[ndarray, "12 2"] = (
        centre + _CORNERS * (np.array((half_width, half_height)) - radius) + radius * _OUTWARDS
    )
    return outline


def run(style: Style, length: float, seats: int, front: float = 0.0) -> list[Mesh]:
    """Base, seat cushions and back of a row of seats; the seats reach forward by `front` more than the style says."""
    s = style
    under = s.seat - s.pad
    base = soft((length, under - s.lift, s.depth + front), (0.0, (under + s.lift) / 2, front / 2), min(0.02, s.soft))
    parts = [base, *_seat_cushions(s, length, seats, front)]
    # High enough for the rear edge of a leaning back to stay above the floor.
    low = s.lift + 0.5 * s.back * np.sin(s.lean)
    height = s.top - low
    place = (0.0, low + height / 2, (s.back - s.depth) / 2)
    pivot = (0.0, low, (s.back - s.depth) / 2)
    match s.back_kind:
        case "roll":
            roll = 0.55 * s.back
            panel = soft((length, height - roll, s.back), (0.0, low + (height - roll) / 2, place[2]), s.soft)
            bolster = cylinder((-length / 2, s.top - roll, place[2]), (length / 2, s.top - roll, place[2]), roll, 16)
            parts.append(turned(joined(panel, bolster), 0, -s.lean, pivot))
        case "hump":
            parts.append(
                turned(moved(_hump(length, s.seat - 0.1, s.top, s.back), (0.0, 0.0, place[2])), 0, -s.lean, pivot)
            )
            parts.append(soft((length, s.seat - s.lift, s.back), (0.0, (s.seat + s.lift) / 2, place[2]), 0.02))
        case _:
            parts.append(turned(soft((length, height, s.back), place, s.soft), 0, -s.lean, pivot))
    if s.back_kind == "cushions":
        parts += _back_cushions(s, length, seats)
    return parts


def _seat_cushions(s: Style, length: float, seats: int, front: float) -> list[Mesh]:
    width, depth = length / seats, s.depth + front - 0.7 * s.back + 0.03
    z = (s.depth + front) / 2 + front / 2 + 0.03 - depth / 2
    return [
        soft(
            (width - 0.008, s.pad + 0.02, depth),
            ((index + 0.5) * width - length / 2, s.seat - s.pad / 2 - 0.01, z),
            min(s.soft, 0.45 * s.pad),
            0.12 * s.pad,
        )
        for index in range(seats)
    ]


def _back_cushions(s: Style, length: float, seats: int) -> list[Mesh]:
    width, height, thickness = length / seats, (s.top - s.seat) * 1.04, 0.16
    z = -s.depth / 2 + s.back + 0.36 * thickness
    cushions = []
    for index in range(seats):
        place = ((index + 0.5) * width - length / 2, s.seat + height / 2 - 0.01, z)
        cushion = soft((width - 0.012, height, thickness), place, 0.065)
        cushions.append(turned(cushion, 0, -s.lean - 0.12, (0.0, s.seat, z)))
    return cushions


def _hump(length: float, low: float, high: float, thickness: float) -> Mesh:
    """A back whose upper edge rises towards the middle and again a little at its ends."""
    rings = []
    for share in np.linspace(-1.0, 1.0, 17):
        top = high - 0.32 * (high - low) * (1 - np.cos(np.pi * share)) / 2
        edge = rounded_rectangle((top - low) / 2, thickness / 2, 0.48 * thickness)
        rings.append(np.stack((np.full(12, share * length / 2), edge[:, 0] + (top + low) / 2, edge[:, 1]), -1))
    return loft(np.stack(rings))


def arm(kind: ArmKind, s: Style, x: float, width: float, height: float, front: float = 0.0) -> Mesh:
    """The arm on the +x side of a run that ends at `x`; `height` is that of its upper side above the floor."""
    centre, depth, z = x + width / 2, s.depth + front, front / 2
    full = height - s.lift
    match kind:
        case "block" | "soft":
            radius = 0.02 if kind == "block" else 0.45 * width
            return soft((width, full, depth), (centre, s.lift + full / 2, z), radius)
        case "roll":
            roll = 0.56 * width
            panel = soft((0.8 * width, full - roll, depth), (x + 0.4 * width, s.lift + (full - roll) / 2, z), 0.02)
            out = x + 0.62 * width
            bolster = cylinder((out, height - roll, z - depth / 2), (out, height - roll, z + depth / 2), roll, 14)
            return joined(panel, bolster)
        case "slope":
            low = s.seat + 0.25 * (height - s.seat)
            rear, tip = -s.depth / 2, s.depth / 2 + front
            side = np.array(
                [(s.lift, rear), (height + 0.1, rear), (height, rear + 0.3 * depth), (low, tip), (s.lift, tip)]
            )
            return prism(side, x, x + width)
        case "flare":
            low = s.lift + width * np.sin(0.22)
            upright = soft((width, height - low, depth), (centre, (height + low) / 2, z), 0.4 * width)
            return turned(upright, 2, -0.22, (x, low, 0.0))
        case "frame":
            bar, rear, tip = 0.028, -s.depth / 2 + 0.06, s.depth / 2 + front - 0.05
            middle = x + 2 * bar
            loop = [(middle, 0.0, rear), (middle, height, rear), (middle, height, tip), (middle, 0.0, tip)]
            rest = soft((0.09, 0.04, depth), (middle, height + 0.01, z), 0.015)
            cross = box((4 * bar, 0.05, tip - rear), (x + bar, s.seat - s.pad - 0.04, (tip + rear) / 2))
            return joined(tube(loop, bar, square=True), rest, cross)


def legs(s: Style, kind: LegKind, half_x: float, rear: float, front: float) -> Mesh:
    """What holds the body `lift` above the floor: four feet or two sleds, or a plinth, where there is no room."""
    if s.lift < 0.05:
        return box((1.94 * half_x, s.lift + 0.03, front - rear - 0.06), (0.0, (s.lift + 0.03) / 2, (front + rear) / 2))
    inset, up = 0.09, s.lift + 0.03
    corners = [(half_x - inset, z) for z in (rear + inset, front - inset)]
    match kind:
        case "blocks":
            feet = [box((0.08, up, 0.08), (x, up / 2, z)) for x, z in corners]
        case "splayed":
            feet = [tube([(x + 0.04, 0.0, z + 0.04 * np.sign(z)), (x, up, z)], (0.018, 0.034), 8) for x, z in corners]
        case "round":
            feet = [cylinder((x, 0.0, z), (x, up, z), 0.05, 12) for x, z in corners]
        case "sled":
            x, (near, far) = half_x - inset, (corners[0][1], corners[1][1])
            feet = [tube([(x, up, near), (x, 0.02, near), (x, 0.02, far), (x, up, far)], 0.02, square=True)]
    return both_sides(joined(*feet))


def swept(
    section: Float64[ndarray, "N 2"],
    angles: Float64[ndarray, "S"],
    radius: tuple[float, float],
    scale: Float64[ndarray, "S"],
) -> Mesh:
    """A section of (outwards, y) points carried around an ellipse about the y axis; angle 0 lies at -z.

    `scale` stretches the section's heights at each angle, from its lowest point up.
    """
    low = section[:, 1].min()
    rings = []
    for angle, stretch in zip(angles, scale, strict=True):
        x, z = (radius[0] + section[:, 0]) * np.sin(angle), -(radius[1] + section[:, 0]) * np.cos(angle)
        rings.append(np.stack((x, low + (section[:, 1] - low) * stretch, z), -1))
    return loft(np.stack(rings))
