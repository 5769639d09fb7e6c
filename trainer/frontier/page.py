"""The figures of a frontier as people read them: everything on the page comes from the report."""

from collections.abc import Sequence
from itertools import product

from trainer.frontier.plan import Expense
from trainer.frontier.report import ACCURACIES, EXPENSES, Accuracy, Measured, Report, fronts
from trainer.frontier.verdicts import Alternative, Verdict, verdicts

BEGIN, END = "<!-- figures: written by trainer frontier -->", "<!-- end of figures -->"

_NAMES: dict[Expense, str] = {
    "latency_ms": "latency",
    "training_minutes": "training",
    "bundle_mb": "size",
    "memory_mb": "memory",
}

_TOLD: dict[Accuracy, tuple[str, str]] = {
    "iou": ("IoU", "{:.3f}"),
    "azimuth_error_degrees": ("Azimuth error", "{:.1f}°"),
    "picture_error": ("Picture error", "{:.4f}"),
}


def as_markdown(report: Report) -> str:
    """Conditions, a table of all points of each class, the fronts, and the verdicts on the default's choices."""
    lines = [BEGIN, "", _conditions(report), ""]
    for category in report.categories:
        lines += [f"## {category}: all points", "", *_table(report, category), ""]
        lines += [f"### {category}: the fronts", "", *_fronts(report, category), ""]
        lines += [f"### {category}: does the default lie on the front?", "", *_verdicts(report, category), ""]
    if report.skipped:
        lines += ["Not measured:", "", *(f"- {sentence}" for sentence in report.skipped), ""]
    return "\n".join([*lines, END]) + "\n"


def placed(page: str, figures: str) -> str:
    """A page with its figures in the place of those that it has, or at its end where it has none."""
    before, begin, rest = page.partition(BEGIN)
    if not begin:
        return f"{page.rstrip()}\n\n{figures}".lstrip()
    after = rest.partition(END)[2].removeprefix("\n")
    return before + figures + after


def _conditions(report: Report) -> str:
    scale, machine = report.scale, report.machine
    apart = [
        f"{category}, {report.noise(category, 'iou'):.3f} IoU, "
        f"{report.noise(category, 'azimuth_error_degrees'):.1f}° and "
        f"{report.noise(category, 'picture_error'):.4f} picture error"
        for category in report.categories
        if len(report.default(category).runs) > 1
    ]
    noise = (
        f"Seeds of the default lie apart by up to ({'; '.join(apart)}): what differs by less is not told apart here."
        if apart
        else "Each point is one training, and nothing tells how far seeds lie apart."
    )
    return (
        f"Budget `{report.budget}`, {report.date}: each point starts from the preset `{scale.preset}`; "
        f"{scale.instances:,} procedural objects in one picture each, judged on {scale.test_instances} others in "
        f"{scale.test_views} pictures each. {noise} {machine.cpu}, {machine.cores} cores that others used, too; torch "
        f"{machine.torch}, onnxruntime {machine.onnxruntime}."
    )


def _table(report: Report, category: str) -> list[str]:
    lines = [
        "| | | IoU | azimuth error | within 30° | picture error | latency, ms | multiply-adds, M | training, min | "
        "renderings, k | bundle, MB | memory, MB | on the front of |",
        "|---" * 13 + "|",
    ]
    on = {expense: fronts(report, report.of(category), "iou", expense).on for expense in EXPENSES}
    before = ""
    for point in report.of(category):
        title = point.factor_title if point.factor != before else ""
        before = point.factor
        where = ", ".join(_NAMES[expense] for expense in EXPENSES if point in on[expense]) or "–"
        lines.append(
            f"| {title} | {point.label} | {_iou(point)} | {point.azimuth_error_degrees:.1f}° | "
            f"{point.azimuth_accuracy:.2f} | {point.picture_error:.4f} | {point.latency_ms:.2f} | "
            f"{point.multiply_adds_millions:.1f} | {point.training_minutes:.2f} | {point.renderings_thousands:,.0f} | "
            f"{point.bundle_mb:.2f} | {point.memory_mb:.0f} | {where} |"
        )
    run = report.default(category).runs[0]
    for name, value in (("mean shape", run.mean_shape_iou), ("nearest neighbour", run.nearest_neighbour_iou)):
        lines.append(f"| Guesses | {name} | {value:.3f} |" + " – |" * 10)
    return lines


def _iou(point: Measured) -> str:
    if len(point.runs) == 1:
        low, high = point.runs[0].iou_interval
        return f"{point.iou:.3f} [{low:.2f}, {high:.2f}]"
    return f"{point.iou:.3f} ({', '.join(f'{run.iou:.3f}' for run in point.runs)})"


def _fronts(report: Report, category: str) -> list[str]:
    lines = []
    for accuracy, expense in product(ACCURACIES, EXPENSES):
        name, told = _TOLD[accuracy]
        found = fronts(report, report.of(category), accuracy, expense)
        on = " → ".join(f"{point.label} ({told.format(getattr(point, accuracy))})" for point in found.on)
        near = ", ".join(point.label for point in found.near) or "none"
        lines.append(f"- {name} against {_NAMES[expense]}, cheapest first: {on}. Within noise of it: {near}.")
    return lines


def _verdicts(report: Report, category: str) -> list[str]:
    lines = ["| factor | the default's choice | on the front | as good, or nearly, for less | better for more |"]
    lines.append("|---|---|---|---|---|")
    for verdict in verdicts(report, category, "iou"):
        better = "–" if verdict.better is None else f"{verdict.better.label} ({verdict.better.iou:.3f})"
        said = "yes" if not verdict.rivals else "within noise" if verdict.on_front else "no"
        lines.append(f"| {verdict.title} | {verdict.choice} | {said} | {_rivals(verdict)} | {better} |")
    return lines


def _rivals(verdict: Verdict) -> str:
    """Of each point, by how much it is better or worse and what share of the default's costs it has."""
    by_point: dict[str, list[Alternative]] = {}
    for rival in verdict.rivals:
        by_point.setdefault(rival.point.label, []).append(rival)
    told = [f"{label}: {rivals[0].gain:+.3f} IoU at {_shares(rivals)}" for label, rivals in by_point.items()]
    return "; ".join(told) or "–"


def _shares(rivals: Sequence[Alternative]) -> str:
    return ", ".join(f"{rival.share:.0%} of the {_NAMES[rival.expense]}" for rival in rivals)
