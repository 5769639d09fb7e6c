"""Labels beside points, each where it covers nothing else."""

from collections.abc import Iterable
from typing import Any, NamedTuple

from matplotlib.axes import Axes
from matplotlib.patheffects import withStroke
from matplotlib.transforms import Bbox

# Offsets from the point in typographic points, and how the text is aligned there: the nearest come first.
_PLACES: tuple[tuple[float, float, str, str], ...] = tuple(
    (horizontal * reach, vertical * reach, side, level)
    for reach in (6.0, 12.0, 20.0, 30.0, 42.0)
    for horizontal, vertical, side, level in (
        (1.0, 0.0, "left", "center"),
        (0.7, 0.7, "left", "bottom"),
        (0.7, -0.7, "left", "top"),
        (-0.7, 0.7, "right", "bottom"),
        (-0.7, -0.7, "right", "top"),
        (-1.0, 0.0, "right", "center"),
        (0.0, 1.0, "center", "bottom"),
        (0.0, -1.0, "center", "top"),
    )
)


class Label(NamedTuple):
    x: float
    y: float
    text: str
    style: dict[str, Any]
    """How matplotlib draws it."""
    needed: bool
    """Whether it is written even where there is no room."""


def write_labels(axes: Axes, labels: Iterable[Label], points: Iterable[tuple[float, float]]) -> None:
    """Writes labels in their order, each at the nearest place that covers neither `points` nor what is written, joined
    to its point by a thin line where that is far. Call it when the axes have their final limits."""
    figure = axes.get_figure(root=True)
    assert figure is not None
    figure.draw_without_rendering()
    renderer = figure.canvas.get_renderer()  # type: ignore[attr-defined]
    half = 3.0 * figure.dpi / 72
    taken = [Bbox(text.get_window_extent(renderer).frozen().get_points()) for text in axes.texts]
    taken += [
        Bbox([[x - half, y - half], [x + half, y + half]]) for x, y in axes.transData.transform(list(points)).tolist()
    ]
    inside = axes.get_window_extent(renderer)
    for label in labels:
        best: tuple[float, Any, Bbox] | None = None
        for right, up, side, level in _PLACES:
            line = {"arrowstyle": "-", "color": "#aaaaaa", "linewidth": 0.6} if abs(right) + abs(up) > 14 else None
            text = axes.annotate(
                label.text, (label.x, label.y), (right, up), textcoords="offset points", ha=side, va=level,
                arrowprops=line, path_effects=[withStroke(linewidth=2.5, foreground="white")], **label.style,
            )  # fmt: skip
            text.update_positions(renderer)
            extent = Bbox(text.get_window_extent(renderer).frozen().get_points())
            covered = sum(_overlap(extent, other) for other in taken) + extent.width * extent.height
            covered -= _overlap(extent, inside)
            if best is None or covered < best[0]:
                if best is not None:
                    best[1].remove()
                best = covered, text, extent
            else:
                text.remove()
            if best[0] < 1.0:
                break
        if best is None:
            continue
        if best[0] >= 1.0 and not label.needed:
            best[1].remove()
            continue
        taken.append(best[2])


def _overlap(one: Bbox, other: Bbox) -> float:
    """The area that both cover, square pixels."""
    width = min(one.x1, other.x1) - max(one.x0, other.x0)
    height = min(one.y1, other.y1) - max(one.y0, other.y0)
    return float(max(0.0, width) * max(0.0, height))
