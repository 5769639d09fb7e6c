"""What docs/results.md says of what made the difference is what the committed figures say: seeds, one change at a time,
and time beside the paper's objective."""

import itertools
import re
import statistics

import pytest

from tests.test_results_document import figures, rows, section


@pytest.mark.parametrize("category", ["car", "chair"])
def test_seeds(category: str) -> None:
    cells = [cell["metrics"] for cell in figures(f"docs/results/seeds-{category}.json")["cells"]]
    overlaps, right = (sorted(cell[name] for cell in cells) for name in ("iou", "azimuth_accuracy"))
    near = sum(overlap > overlaps[-1] - 0.05 for overlap in overlaps)
    said = (
        f"of {category}s end with an IoU of {overlaps[0]:.2f} to {overlaps[-1]:.2f} and {right[0]:.2f} to "
        f"{right[-1]:.2f} of the azimuths within 30°, {near} of {len(cells)} within 0.05 of the best"
    )
    assert said in section("What made the difference")


def test_the_best_of_three_starts() -> None:
    single, best = (
        [
            cell["metrics"]
            for cell in sorted(figures(f"docs/results/{name}.json")["cells"], key=lambda cell: cell["seed"])
        ]
        for name in ("seeds-chair", "seeds-chair-starts")
    )
    said = section("What made the difference")
    overlaps, right = (sorted(cell[name] for cell in best) for name in ("iou", "azimuth_accuracy"))
    near = sum(overlap > overlaps[-1] - 0.05 for overlap in overlaps)
    assert (
        f"ten trainings of chairs end with an IoU of {overlaps[0]:.2f} to {overlaps[-1]:.2f} and {right[0]:.2f} to "
        f"{right[-1]:.2f} of the azimuths within 30°, {near} of 10 within 0.05 of the best"
    ) in said
    means = [
        statistics.mean(cell[name] for cell in cells)
        for name in ("iou", "azimuth_accuracy")
        for cells in (best, single)
    ]
    assert f"the mean IoU is {means[0]:.3f} instead of {means[1]:.3f}" in said
    assert f"within 30° {means[2]:.2f} instead of {means[3]:.2f}" in said


def test_the_bound_tells_early_which_start_will_fail() -> None:
    bounds = {start["seed"]: start["bound"] for start in figures("docs/results/starts.json")["bounds"]}
    cells = figures("docs/results/seeds-chair.json")["cells"]
    overlaps = {cell["seed"]: cell["metrics"]["iou"] for cell in cells}
    enough = max(overlaps.values()) - 0.05
    said = section("What made the difference")
    failing = sorted(bounds[seed] for seed, overlap in overlaps.items() if overlap <= enough)
    others = sorted(bounds[seed] for seed, overlap in overlaps.items() if overlap > enough)
    assert (
        f"have −{-failing[-1]:.0f} to −{-failing[0]:.0f} nats then, the others −{-others[-1]:.0f} to −{-others[0]:.0f}"
    ) in said
    for starts, told in ((3, "Of all {} choices of three of these ten, {} leave"), (2, "the {} choices of two, {}.")):
        choices = list(itertools.combinations(overlaps, starts))
        well = sum(overlaps[max(choice, key=lambda seed: bounds[seed])] > enough for choice in choices)
        assert told.format(len(choices), well) in said
    tubs = sorted(start["bound"] for start in figures("docs/results/starts.json")["bathtubs"]["bounds"])
    assert f"(−{-tubs[-1]:.0f} nats; the others −{-tubs[-2]:.0f} to −{-tubs[0]:.0f})" in said
    # Those went on that the bound says.
    went_on = [start["seed"] for start in figures("docs/results/starts.json")["bounds"] if start["went_on"]]
    assert went_on == [max(range(first, first + 3), key=lambda seed: bounds[seed]) for first in range(0, 30, 3)]


def test_seeds_whose_codes_are_kept_from_telling_poses() -> None:
    found = []
    for name in ("seeds-chair-independent", "seeds-chair"):
        cells = sorted(figures(f"docs/results/{name}.json")["cells"], key=lambda cell: cell["seed"])
        assert [cell["seed"] for cell in cells] == list(range(10))
        found.append([[cell["metrics"][key] for cell in cells] for key in ("iou", "azimuth_accuracy")])
    (kept, kept_right), (free, free_right) = found
    less = [one - other for one, other in zip(kept, free, strict=True)]
    said = (
        f"the IoU is {statistics.mean(kept):.3f} instead of {statistics.mean(free):.3f} (the mean difference is "
        f"{statistics.mean(less):.3f} ± {statistics.stdev(less) / 10**0.5:.3f}, one standard error), the azimuths "
        f"within 30° {statistics.mean(kept_right):.2f} instead of {statistics.mean(free_right):.2f}"
    )
    assert said in section("What made the difference")


CELLS = figures("docs/results/ablation.json")["cells"]


@pytest.mark.parametrize("row", sorted({cell["row"] for cell in CELLS}))
def test_one_change_at_a_time(row: str) -> None:
    def mean(name: str, *classes: str) -> float:
        return statistics.mean(
            float(cell["metrics"][name]) for cell in CELLS if cell["row"] == row and cell["class"] in classes
        )

    every = ("car", "chair", "airplane", "sofa")
    told = rows(section("What made the difference"))[row]
    assert told[:5] == [
        *(
            f"{mean('iou', one):.2f} / {mean('azimuth_error_degrees', one):.0f}° / {mean('azimuth_accuracy', one):.2f}"
            for one in every
        ),
        f"{mean('iou', *every):.2f}, {mean('azimuth_accuracy', *every):.2f}",
    ]
    overlap = {(cell["row"], cell["class"], cell["seed"]): cell["metrics"]["iou"] for cell in CELLS}
    less = [overlap[key] - overlap["recipe", *key[1:]] for key in overlap if key[0] == row]
    found = [float(number) for number in re.findall(r"[-+\d.]+", told[5])]
    expected = [] if row == "recipe" else [statistics.mean(less), min(less), max(less)]
    assert found == [pytest.approx(number, abs=0.006) for number in expected]


def test_how_soon_ours_is_better_than_the_paper_s_objective() -> None:
    said, classes = section("What made the difference"), figures("docs/results/learning.json")["classes"]
    car, chair = classes["car"]["curves"], classes["chair"]["curves"]
    best = (
        max(point["iou"] for point in car["the paper's"]),
        max(point["azimuth_accuracy"] for point in car["the paper's"]),
    )
    first = next(p for p in car["ours"] if p["iou"] > best[0] and p["azimuth_accuracy"] > best[1])
    whole = car["the paper's"][-1]["core_seconds"]
    assert (
        f"({first['iou']:.2f}) and poses ({first['azimuth_accuracy']:.2f} within 30°) after "
        f"{first['core_seconds']:.0f} s than the paper's ever was in {whole:.0f} s ({best[0]:.2f}, and {best[1]:.2f}): "
        f"**{whole / first['core_seconds']:.0f} times sooner**"
    ) in said
    mine, theirs = chair["ours"][-1], chair["the paper's"][-1]
    assert (
        f"{mine['core_seconds']:.0f} s ours has the paper's IoU of {theirs['core_seconds']:.0f} s "
        f"({mine['iou']:.2f} both, {mine['iou']:.3f} and {theirs['iou']:.3f}) and {mine['azimuth_accuracy']:.2f} of "
        f"the azimuths instead of {theirs['azimuth_accuracy']:.2f}"
    ) in said.replace("\n", " ")
