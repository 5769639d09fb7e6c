"""The charts of a benchmark's report, one message each."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("agg")

from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.ticker import FixedLocator, LogLocator, NullFormatter

Report = dict[str, Any]
OURS, PEERS = ("#0b6e4f", "#2a9d8f", "#7a3e9d", "#b58fc9", "#4c6ef5"), ("#c1121f", "#e76f51", "#f4a261", "#8d99ae")
KERNELS, FUSED, COMPOSED = "chiaro kernels", "chiaro fused likelihood", "chiaro composed likelihood"


def write_charts(report: Report, file: Path) -> None:
    """Every chart whose figures the report holds, in one picture."""
    charts: list[Callable[[Axes, Report], None]] = []
    if report.get("cases"):
        charts += [_rates("forward"), _rates("forward+backward"), _against_peer, _gain_of_fusing]
    if report.get("scaling"):
        charts += [
            _sweep("pictures", "pictures per call", per_picture=False),
            _sweep("pixels", "pixels per picture", per_picture=True),
            _sweep("faces", "faces per mesh", per_picture=True),
        ]
    if report.get("memory"):
        charts.append(_memory)
    columns = min(len(charts), 4)
    rows = -(-len(charts) // max(columns, 1))
    if not charts:
        return
    figure, axes = plt.subplots(rows, columns, figsize=(6.4 * columns, 4.9 * rows), squeeze=False, layout="constrained")
    for axis, chart in zip(axes.flat, charts, strict=False):
        chart(axis, report)
    for axis in axes.flat[len(charts) :]:
        axis.remove()
    versions = ", ".join(
        f"{name} {report['versions'][name]}" for name in ("DEODR", "mitsuba") if name in report["versions"]
    )
    figure.suptitle(
        f"{report['machine']['cpu']}, {report['machine']['cores']} cores; {report['date'][:10]}; {versions}"
    )
    figure.savefig(file, dpi=110)
    plt.close(figure)


def _rates(mode: str) -> Callable[[Axes, Report], None]:
    """Bars of pictures per second, most cores dark, one core light."""

    def chart(axis: Axes, report: Report) -> None:
        colours = _colours(report)
        cases = [case for case in report["cases"] if case["mode"] == mode]
        chosen = [case for case in cases if (case["faces"], case["width"]) == (192, 128)] or cases[:1]
        most = max(chosen, key=lambda case: case["cores"])
        rates = most["pictures_per_second"]
        names = sorted(rates, key=lambda name: rates[name]["median"])
        for case in chosen:
            here = [name for name in names if name in case["pictures_per_second"]]
            values = [case["pictures_per_second"][name] for name in here]
            medians = [value["median"] for value in values]
            # Cores side by side within a name's row.
            height = 0.8 / len(chosen)
            offset = (chosen.index(case) - (len(chosen) - 1) / 2) * height
            axis.barh(
                [names.index(name) + offset for name in here],
                medians,
                height=height,
                xerr=[
                    [value["median"] - value["lowest"] for value in values],
                    [value["highest"] - value["median"] for value in values],
                ],
                color=[colours[name] for name in here],
                alpha=1.0 if case is most else 0.45,
            )
            for name, median, top in zip(here, medians, [value["highest"] for value in values], strict=True):
                axis.annotate(
                    f"{median:,.0f}", (top, names.index(name) + offset), (4, 0), textcoords="offset points",
                    va="center", fontsize=7,
                )  # fmt: skip
        axis.set_yticks(range(len(names)), names)
        _logarithmic(axis.xaxis, steps=(1.0,))
        axis.margins(x=0.15)
        axis.set_xlabel("pictures per second (median; lines: range of the repeats)")
        cores = " and ".join(str(case["cores"]) for case in chosen)
        size = f"{most['faces']} faces, {most['width']} × {most['height']} pixels"
        axis.set_title(f"{mode}: {size}\n{cores} cores (most cores: dark)", fontsize=10)

    return chart


def _against_peer(axis: Axes, report: Report) -> None:
    """Our kernels over the fastest peer, by faces; a line for each picture size."""
    cores = max(case["cores"] for case in report["cases"])
    styles = {"forward": "--", "forward+backward": "-"}
    sizes = sorted({(case["width"], case["height"]) for case in report["cases"]})
    for colour, (width, height) in zip(OURS, sizes, strict=False):
        for mode, style in styles.items():
            chosen = [
                case
                for case in report["cases"]
                if (case["width"], case["mode"], case["cores"]) == (width, mode, cores)
                and KERNELS in case["times_as_fast_as_fastest_peer"]
            ]
            axis.plot(
                [case["faces"] for case in chosen],
                [case["times_as_fast_as_fastest_peer"][KERNELS] for case in chosen],
                style, color=colour, marker="o", label=f"{width} × {height}, {mode}",
            )  # fmt: skip
    axis.axhline(1.0, color="#777777", linewidth=0.8)
    _logarithmic(axis.xaxis, sorted({case["faces"] for case in report["cases"]}))
    _logarithmic(axis.yaxis, steps=(1.0, 1.5, 2.0, 3.0, 5.0, 7.0))
    axis.set_xlabel("faces per mesh")
    axis.set_ylabel("rate of our kernels / rate of the fastest peer")
    axis.set_title(f"our kernels against the fastest peer\nsame scene, L2 loss, {cores} cores", fontsize=10)
    axis.legend(fontsize=7)


def _gain_of_fusing(axis: Axes, report: Report) -> None:
    """The fused likelihood over the same likelihood composed in torch, by picture size."""
    cores = max(case["cores"] for case in report["cases"])
    styles = {"forward": "--", "forward+backward": "-"}
    for colour, faces in zip(OURS, sorted({case["faces"] for case in report["cases"]}), strict=False):
        for mode, style in styles.items():
            chosen = [
                case
                for case in report["cases"]
                if (case["faces"], case["mode"], case["cores"]) == (faces, mode, cores)
                and {FUSED, COMPOSED} <= case["pictures_per_second"].keys()
            ]
            rates = [case["pictures_per_second"] for case in chosen]
            axis.plot(
                [case["width"] * case["height"] for case in chosen],
                [rate[FUSED]["median"] / rate[COMPOSED]["median"] for rate in rates],
                style, color=colour, marker="o", label=f"{faces:,} faces, {mode}",
            )  # fmt: skip
    axis.axhline(1.0, color="#777777", linewidth=0.8)
    _logarithmic(axis.xaxis, sorted({case["width"] * case["height"] for case in report["cases"]}))
    axis.set_ylim(bottom=0)
    axis.set_xlabel("pixels per picture")
    axis.set_ylabel("rate fused / rate composed in torch")
    axis.set_title(f"what fusing the likelihood gains\n{cores} cores", fontsize=10)
    axis.legend(fontsize=7)


def _sweep(quantity: str, label: str, per_picture: bool) -> Callable[[Axes, Report], None]:
    """Milliseconds against one quantity; a line for each contender and number of cores."""

    def chart(axis: Axes, report: Report) -> None:
        points = report["scaling"][quantity]
        styles = dict(zip(sorted({point["cores"] for point in points}), ("--", "-", ":"), strict=False))
        for name, colour in zip(points[0]["milliseconds_per_call"], (OURS[0], OURS[2]), strict=False):
            for cores, style in styles.items():
                chosen = [point for point in points if point["cores"] == cores]
                times = [
                    point["milliseconds_per_call"][name]["median"] / (point["pictures"] if per_picture else 1)
                    for point in chosen
                ]
                axis.plot(
                    [point[quantity] for point in chosen], times, style, color=colour, marker="o",
                    label=f"{name}, {cores} {'core' if cores == 1 else 'cores'}",
                )  # fmt: skip
        fixed = {
            "faces": f"{points[0]['faces']} faces",
            "pixels": f"{points[0]['width']} × {points[0]['height']} pixels",
            "pictures": f"{points[0]['pictures']} pictures per call",
        }
        _logarithmic(axis.xaxis, sorted({point[quantity] for point in points}))
        _logarithmic(axis.yaxis)
        axis.set_xlabel(label)
        axis.set_ylabel(f"milliseconds per {'picture' if per_picture else 'call'}")
        others = ", ".join(text for name, text in fixed.items() if name != quantity)
        axis.set_title(f"cost against {quantity}, forward+backward\n{others}", fontsize=10)
        axis.legend(fontsize=7)

    return chart


def _memory(axis: Axes, report: Report) -> None:
    """Growth of the resident set against pictures, beside the size of the gradients."""
    memory = report["memory"]
    for (name, figures), colour in zip(memory["contenders"].items(), (OURS[2], OURS[3]), strict=False):
        pictures = [point["pictures"] for point in figures["points"]]
        slope = figures["growth_bytes_per_picture"] / 1e3
        axis.plot(
            pictures, [point["growth_bytes"] / 1e6 for point in figures["points"]], color=colour, marker="o",
            label=f"{name}: {slope:,.1f} kB per picture",
        )  # fmt: skip
    figures = memory["contenders"][FUSED]
    gradients = [point["gradients_bytes"] / 1e6 for point in figures["points"]]
    pictures = [point["pictures"] for point in figures["points"]]
    each = figures["gradients_bytes_per_picture"] / 1e3
    axis.plot(pictures, gradients, "k:", label=f"the gradients themselves: {each:,.1f} kB per picture")
    _logarithmic(
        axis.xaxis, sorted({point["pictures"] for one in memory["contenders"].values() for point in one["points"]})
    )
    _logarithmic(axis.yaxis, steps=(1.0,))
    axis.set_xlabel("pictures per call")
    axis.set_ylabel("growth of the resident set, MB")
    size = f"{memory['faces']} faces, {memory['width']} × {memory['height']} pixels"
    axis.set_title(f"memory of forward+backward, 1 core\n{size}", fontsize=10)
    axis.legend(fontsize=7)


def _logarithmic(axis: Axis, ticks: Sequence[float] = (), steps: Sequence[float] = (1.0, 2.0, 5.0)) -> None:
    """A logarithmic axis with plain numbers at `ticks` or, without any, at `steps` of each decade."""
    if axis is axis.axes.xaxis:
        axis.axes.set_xscale("log")
    else:
        axis.axes.set_yscale("log")
    axis.set_major_locator(FixedLocator(ticks) if ticks else LogLocator(subs=steps))
    axis.set_major_formatter(lambda value, _: f"{value:,.10g}")
    axis.set_minor_formatter(NullFormatter())


def _colours(report: Report) -> dict[str, str]:
    """A colour for each contender: green and violet ours, red and grey the peers'."""
    ours = [name for name, one in report["contenders"].items() if one["ours"]]
    peers = [name for name, one in report["contenders"].items() if not one["ours"]]
    return dict(zip(ours, OURS, strict=False)) | dict(zip(peers, PEERS, strict=False))
