"""The page of the models that ship: what each reaches, how it was trained, and what it looks like."""

from collections.abc import Mapping
from typing import Any

PAGE = (
    "# The models",
    "",
    "Made by `scripts/models.py` (`make models`), and each alone by its commands below: where one has `--run FIRST`,",
    "the next is told the poses that it finds. Where the last makes a run of a BUNDLE, that is what came out then, and",
    "its encoder was taught the last phase anew (`scripts/reteach.py`, those of some twice) when that phase had learnt",
    "of other cameras, and when it had learnt of longer looks; trainings of today have it as it is. IoU at 32³; median",
    "azimuth error, and share of azimuths within 30°, both up to the object's own symmetry. Beside them the guesses",
    "that are to be beaten: the class's mean shape, and the nearest neighbour of the picture. On unseen procedural",
    "objects, and on real meshes, which only serve as a test.",
    "Minutes of training are those of one core, or of a GPU, that others used, too.",
    "",
)


def page(models: Mapping[str, Mapping[str, Any]], folders: Mapping[str, str]) -> str:
    """Markdown of the figures of `models`; `folders` has those whose pictures are not beside the page, and where."""
    titles = ["IoU", "mean", "nearest", "error", "within 30°"]
    columns = ["model", "shape", *titles, *(f"real: {title}" for title in titles), "kB", "minutes"]
    lines = [*PAGE, f"| {' | '.join(columns)} |", f"|{'---|' * len(columns)}"]
    for model, one in models.items():
        real = _row(one["real_meshes"]) if "real_meshes" in one else ["–"] * 5
        cells = [model, one["parameterisation"], *_row(one["test"]), *real, f"{one['bundle_bytes'] / 1000:.0f}"]
        cells.append(" + ".join(f"{round(run['seconds'] / 60)} ({run['on']})" for run in one["trainings"]))
        lines.append(f"| {' | '.join(cells)} |")
    made = []
    for model, one in models.items():
        made += ["", f"# {model}", one["pictures"], *(run["command"] for run in one["trainings"])]
    lines += ["", "```sh", *made[1:], "```"]
    for model in models:
        folder = folders.get(model, "")
        lines += ["", f"**{model}**: unseen pictures and what the model makes of them; objects that it invents, and"]
        lines += ["what is between them", ""]
        lines += [f"![Reconstructions]({folder}{model}.png) ![Samples]({folder}{model}-samples.png)"]
        lines += [f"![Between samples]({folder}{model}-between.png)"]
    return "\n".join([*lines, ""])


def _row(figures: Mapping[str, Any]) -> list[str]:
    overlaps = [f"{figures[name]:.2f}" for name in ("iou", "mean_shape_iou", "nearest_neighbour_iou")]
    error, accuracy = figures["symmetric_azimuth_error_degrees"], figures["symmetric_azimuth_accuracy"]
    return [*overlaps, f"{error:.1f}°", f"{accuracy:.2f}"]
