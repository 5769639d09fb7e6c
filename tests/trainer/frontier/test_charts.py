"""Charts: every point is drawn, what matters is labelled, and no label covers another."""

from dataclasses import replace
from itertools import combinations
from pathlib import Path

import pytest
from PIL import Image

from tests.trainer.frontier.reports import REPORT, measured

pytest.importorskip("matplotlib", reason="charts need matplotlib: pip install 'chiaro[bench]'")

from matplotlib import pyplot as plt
from matplotlib.text import Annotation
from matplotlib.transforms import Bbox

from trainer.frontier.charts import write_charts
from trainer.frontier.labels import Label, write_labels


def test_every_chart_is_written(tmp_path: Path) -> None:
    files = write_charts(REPORT, tmp_path)
    assert {file.name for file in files} == {
        f"frontier-{name}.png"
        for name in ("latency", "training", "size", "memory", "azimuth", "picture", "chair", "factors")
    }
    for file in files:
        with Image.open(file) as picture:
            assert min(picture.size) > 300
            assert len(set(picture.convert("L").resize((64, 64)).tobytes())) > 5


def test_what_is_the_same_is_drawn_the_same(tmp_path: Path) -> None:
    one, other = write_charts(REPORT, tmp_path / "one"), write_charts(REPORT, tmp_path / "other")
    assert [file.read_bytes() for file in one] == [file.read_bytes() for file in other]
    more = replace(REPORT, points=(*REPORT.points, measured("best", "size", 0.9, 1.5)))
    assert (tmp_path / "one/frontier-latency.png").read_bytes() != next(
        file for file in write_charts(more, tmp_path / "more") if file.name == "frontier-latency.png"
    ).read_bytes()


def test_labels_cover_neither_each_other_nor_points() -> None:
    figure, axes = plt.subplots(figsize=(8, 6))
    points = [(0.1 * x, 0.1 * y) for x in range(2, 9, 2) for y in range(2, 9, 2)]
    axes.set_xlim(0, 1)
    axes.set_ylim(0, 1)
    write_labels(axes, [Label(x, y, f"{x:.1f}, {y:.1f}", {"fontsize": 8}, False) for x, y in points], points)
    figure.draw_without_rendering()
    texts = [child for child in axes.get_children() if isinstance(child, Annotation)]
    assert len(texts) == len(points)
    boxes = [Bbox(text.get_window_extent().get_points()).shrunk(0.99, 0.99) for text in texts]
    assert not any(one.overlaps(other) for one, other in combinations(boxes, 2))
    for x, y in axes.transData.transform(points):
        assert not any(box.contains(x, y) for box in boxes)
    plt.close(figure)


def test_a_label_without_room_is_left_out_unless_it_is_needed() -> None:
    figure, axes = plt.subplots(figsize=(2, 2))
    spot = [(0.5, 0.5)] * 40
    labels = [Label(x, y, "a rather long label", {"fontsize": 9}, number == 39) for number, (x, y) in enumerate(spot)]
    write_labels(axes, labels, spot)
    texts = [child for child in axes.get_children() if isinstance(child, Annotation)]
    assert 1 <= len(texts) < 40
    plt.close(figure)
