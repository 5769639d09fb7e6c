"""The chart of the service's report: how long clients wait, and how many pictures are answered."""

from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("agg")

from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.ticker import FixedLocator, NullLocator, ScalarFormatter

OURS, LIGHTER, FLOOR = "#0b6e4f", "#2a9d8f", "#8d99ae"


def write_charts(report: dict[str, Any], file: Path) -> None:
    """Latency and throughput by the number of clients, beside the graphs alone."""
    figure, (latency, throughput) = plt.subplots(1, 2, figsize=(12.8, 4.9), layout="constrained")
    loads = report["loads"]
    clients = [load["clients"] for load in loads]

    latency.plot(clients, [load["service"]["p99_ms"] for load in loads], "o-", color=LIGHTER, label="service, p99")
    latency.plot(clients, [load["service"]["p50_ms"] for load in loads], "o-", color=OURS, label="service, p50")
    floor = [load["graphs_one_thread"]["p50_ms"] for load in loads]
    latency.plot(clients, floor, "s--", color=FLOOR, label="graphs alone, one thread, p50")
    latency.set_yscale("log")
    latency.yaxis.set_major_formatter(ScalarFormatter())
    latency.set_ylabel("milliseconds a picture")
    latency.set_title("How long a client waits")

    answered = [load["service"]["per_second"] for load in loads]
    throughput.plot(clients, answered, "o-", color=OURS, label="service")
    floor = [load["graphs_all_threads"]["per_second"] for load in loads]
    throughput.plot(clients, floor, "s--", color=FLOOR, label=f"graphs alone, {report['threads']} threads")
    throughput.set_ylim(bottom=0)
    throughput.set_ylabel("pictures per second")
    throughput.set_title("How many pictures are answered")

    for axis in (latency, throughput):
        _by_clients(axis, clients)
    figure.suptitle(
        f"{report['machine']['cpu']}, {report['machine']['cores']} cores; {report['date'][:10]}; "
        f"onnxruntime {report['versions']['onnxruntime']}; ready in {report['seconds_to_ready']['median']:.1f} s"
    )
    figure.savefig(file, dpi=110)
    plt.close(figure)


def _by_clients(axis: Axes, clients: list[int]) -> None:
    axis.set_xscale("log", base=2)
    axis.xaxis.set_major_locator(FixedLocator(clients))
    axis.xaxis.set_minor_locator(NullLocator())
    axis.xaxis.set_major_formatter(ScalarFormatter())
    axis.set_xlabel("clients at the same time")
    axis.grid(alpha=0.3)
    axis.legend()
