"""What the judge says: the figures, and how they are written for programs and for people."""

import typing
from dataclasses import dataclass
from typing import Any

from trainer.evaluation.metrics import Interval


@dataclass(frozen=True)
class FrameFigures:
    """Figures that depend on the canonical frame."""

    iou: Interval
    """At 32³."""
    azimuth_error_degrees: Interval
    """Median."""
    azimuth_accuracy: Interval
    """Share within 30°."""
    symmetric_azimuth_error_degrees: Interval
    """Median of the least error over the turns that leave the object as it is."""
    symmetric_azimuth_accuracy: Interval
    flipped: Interval
    """Share of azimuths that are wrong by more than 150°: taken for their own back."""
    azimuth_calibration_error: Interval
    """Expected calibration error of the most probable coarse bin, at the temperature that is fitted."""
    untempered_calibration_error: Interval
    """The same of the probabilities as the model tells them."""
    chamfer_distance: Interval
    """In diagonals of the object's bounding box."""
    normal_consistency: Interval


@dataclass(frozen=True)
class BaselineFigures:
    """What guesses score that know the shapes of the validation objects."""

    mean_shape_iou: Interval
    """Knows the class but not the picture: one mean shape."""
    nearest_neighbour_iou: Interval
    """Knows pictures and their shapes: the object of the validation picture that resembles most."""


@dataclass(frozen=True)
class Report:
    """Figures over all pictures, with 95 % bootstrap intervals over objects."""

    aligned: FrameFigures | None
    """After the one azimuth offset and the one temperature that are fitted on validation pictures; None without any."""
    unaligned: FrameFigures
    """In the model's own frame."""
    baselines: BaselineFigures | None
    """None where no shapes of validation objects are known."""
    light_error_degrees: Interval | None
    """Median, 0 to 180; None where the light stands still, or the model knows only one."""
    picture_error: Interval
    """Mean absolute difference of input and reconstruction, linear RGB 0..1."""
    inside_out: Interval
    """Share of what a reconstruction encloses around which its faces look inward."""
    azimuth_offset_degrees: float | None
    """What was fitted: true ≈ predicted + offset."""
    azimuth_temperature: float | None
    """What was fitted, too: the coarse bins' logarithms are divided by it."""
    symmetric_objects: dict[str, int]
    """How many objects have a rotational symmetry, by its order; `continuous` for solids of revolution."""
    pictures: int
    views_per_instance: int
    """How many pictures of an object the model saw together."""
    objects: int
    skipped_meshes: int
    """Mesh files that could not be read."""


def as_json(report: Report) -> dict[str, object]:
    """Flat figures under the names that `metrics.json` uses.

    Those of the model's own frame end in `_unaligned`. Each interval stands beside its figure as [low, high], its name
    ending in `_interval`. What is not known is null.
    """
    figures = _flat(FrameFigures, report.aligned) | _flat(FrameFigures, report.unaligned, "_unaligned")
    figures |= _flat(BaselineFigures, report.baselines) | _flat(Report, report)
    for group in ("aligned", "unaligned", "baselines"):
        del figures[group]
    return figures


def _flat(kind: type[Any], figures: Any, ending: str = "") -> dict[str, object]:
    flat: dict[str, object] = {}
    for name, hint in typing.get_type_hints(kind).items():
        value = getattr(figures, name, None)
        # Adding nothing makes 0 of -0.
        flat[name + ending] = round(value, 4) + 0.0 if isinstance(value, float) else value
        if hint in (Interval, Interval | None):
            flat[name + ending] = None if value is None else round(value.value, 4)
            flat[f"{name}{ending}_interval"] = None if value is None else [round(value.low, 4), round(value.high, 4)]
    return flat


# Name in the report, name for people, unit.
_FRAME_ROWS = (
    ("iou", "IoU at 32³", ""),
    ("azimuth_error_degrees", "azimuth error, median", "°"),
    ("azimuth_accuracy", "azimuth within 30°", ""),
    ("symmetric_azimuth_error_degrees", "azimuth error up to symmetry", "°"),
    ("symmetric_azimuth_accuracy", "within 30° up to symmetry", ""),
    ("flipped", "wrong by more than 150°", ""),
    ("azimuth_calibration_error", "azimuth's calibration error", ""),
    ("untempered_calibration_error", "calibration error as told", ""),
    ("chamfer_distance", "Chamfer distance", ""),
    ("normal_consistency", "normal consistency", ""),
)
_BASELINE_ROWS = (
    ("mean_shape_iou", "IoU of the mean shape", ""),
    ("nearest_neighbour_iou", "IoU of the nearest neighbour", ""),
)
_OTHER_ROWS = (
    ("light_error_degrees", "light error, median", "°"),
    ("picture_error", "picture error", ""),
    ("inside_out", "inside out", ""),
)
_NO_VALIDATION = (
    "No validation pictures were given, so neither azimuth offset nor temperature are fitted, and there are no "
    "baselines: name a folder with --validation."
)


def as_markdown(report: Report, category: str, skipped: tuple[str, ...] = ()) -> str:
    """A page with a table of all figures; `skipped` are sentences on meshes that could not be read."""
    fitted = ""
    if report.azimuth_offset_degrees is not None:
        offset = round(report.azimuth_offset_degrees, 1) + 0.0
        fitted = f" of {offset}° and a temperature of {report.azimuth_temperature:.2f}"
    lines = [
        f"# {category}: {report.objects} objects in {report.pictures} pictures{_together(report)}",
        "",
        f"| figure | after one azimuth offset{fitted} | without |",
        "|---|---|---|",
    ]
    for name, label, unit in _FRAME_ROWS:
        lines.append(f"| {label} | {_told(report.aligned, name, unit)} | {_told(report.unaligned, name, unit)} |")
    for group, rows in ((report.baselines, _BASELINE_ROWS), (report, _OTHER_ROWS)):
        lines += [f"| {label} | {_told(group, name, unit)} | |" for name, label, unit in rows]
    lines += [
        "",
        "Brackets are 95 % bootstrap intervals over objects. `docs/judge.md` says how each figure comes about.",
        "",
        f"Rotational symmetries: {_symmetries(report)}.",
    ]
    if report.aligned is None:
        lines += ["", _NO_VALIDATION]
    if skipped:
        lines += ["", f"{len(skipped)} mesh files could not be read and were left out:", ""]
        lines += [f"- {sentence}" for sentence in skipped]
    return "\n".join(lines) + "\n"


def as_text(report: Report, category: str) -> str:
    """The same for a terminal: what is known, line by line."""
    lines = [f"{report.objects} objects, {report.pictures} pictures of {category}{_together(report)}"]
    framed = report.unaligned if report.aligned is None else report.aligned
    for group, rows in ((framed, _FRAME_ROWS), (report.baselines, _BASELINE_ROWS), (report, _OTHER_ROWS)):
        told = [(label, _told(group, name, unit)) for name, label, unit in rows]
        lines += [f"{label:30}{figure}" for label, figure in told if figure != _UNKNOWN]
    lines.append(f"{'rotational symmetries':30}{_symmetries(report)}")
    if report.skipped_meshes:
        lines.append(f"{'skipped':30}{report.skipped_meshes} mesh files that cannot be read")
    if report.azimuth_offset_degrees is None:
        lines.append(_NO_VALIDATION)
    else:
        lines.append(f"{'canonical frame':30}turned by {round(report.azimuth_offset_degrees)}°")
        lines.append(f"{'temperature of the bins':30}{report.azimuth_temperature:.2f}")
    return "\n".join(lines)


_UNKNOWN = "–"


def _told(figures: FrameFigures | BaselineFigures | Report | None, name: str, unit: str) -> str:
    figure: Interval | None = getattr(figures, name, None)
    if figure is None:
        return _UNKNOWN
    digits = 1 if unit else 3
    return f"{figure.value:.{digits}f}{unit} [{figure.low:.{digits}f}, {figure.high:.{digits}f}]"


def _together(report: Report) -> str:
    return "" if report.views_per_instance == 1 else f", shown {report.views_per_instance} at once"


def _symmetries(report: Report) -> str:
    told = [
        f"{count} {order if order == 'continuous' else f'of order {order}'}"
        for order, count in report.symmetric_objects.items()
    ]
    return ", ".join(told) or "none"
