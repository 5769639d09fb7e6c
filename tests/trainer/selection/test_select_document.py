"""docs/select.md tells what docs/results/select-*.json hold, and the JSONs are such as the command writes."""

import json
import math
from pathlib import Path
from typing import Any

import pytest

from trainer.config import TrainConfig
from trainer.mapping import from_mapping
from trainer.selection.bound import noise_variance
from trainer.selection.candidates import Candidate, config_of, parse_form
from trainer.selection.page import conditions, table_lines
from trainer.selection.size import size_of

ROOT = Path(__file__).parents[3]
PAGE = (ROOT / "docs/select.md").read_text()
RESULTS = sorted((ROOT / "docs/results").glob("select-*.json"))


def loaded(path: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(path.read_text())
    return found


def agreement_lines(found: dict[str, Any]) -> list[str]:
    """What the judge, who knows the true shapes, says of the same trainings."""
    lines = [
        "| candidate | steps | bound | IoU | azimuth error | within 30° |",
        "|---|---|---|---|---|---|",
    ]
    for candidate in found["candidates"]:
        if candidate["name"] not in found["judged"]:
            continue
        judged, last = found["judged"][candidate["name"]], candidate["rungs"][-1]
        low, high = judged["iou_interval"]
        lines.append(
            f"| {candidate['name']} | {last['step']} | {last['bound']['value']:.2f} | "
            f"{judged['iou']:.3f} [{low:.3f}, {high:.3f}] | {judged['azimuth_error_degrees']:.1f}° | "
            f"{judged['azimuth_accuracy']:.2f} |"
        )
    return lines


def test_mirrored_and_free_shapes_are_told_as_the_json_has_them() -> None:
    trainings = loaded(ROOT / "docs/results/mirror.json")["trainings"]
    assert len(trainings) == 24
    for one in trainings:
        form, symmetry = (f"**{one[key]}**" if one["chosen"] else one[key] for key in ("form", "symmetry"))
        line = (
            f"| {one['class']}, {one['seed']} | {form} | {symmetry} | {one['shape_parameters']:,} | "
            f"{one['bound']:.2f} | {one['behind_the_best']:.2f} ± {one['standard_error']:.2f} | {one['iou']:.3f} | "
            f"{one['azimuth_accuracy']:.2f} | {one['flipped']:.2f} |"
        )
        assert line in PAGE
        # The smallest within a standard error of the best: here always the best itself.
        assert one["chosen"] == (one["behind_the_best"] == 0)


def test_there_are_results() -> None:
    assert RESULTS


@pytest.mark.parametrize("path", RESULTS, ids=lambda path: path.stem)
def test_the_page_has_the_figures_of_the_json(path: Path) -> None:
    found = loaded(path)
    judged = agreement_lines(found) if found["judged"] else []
    for line in (conditions(found), *table_lines(found), *judged):
        assert line in PAGE


@pytest.mark.parametrize("path", RESULTS, ids=lambda path: path.stem)
def test_the_json_is_consistent(path: Path) -> None:
    found = loaded(path)
    recipe = from_mapping(TrainConfig, found["recipe"], path.name)
    assert math.isclose(found["noise_variance"], noise_variance(recipe.loss, recipe.width, recipe.height))
    steps = {candidate["name"]: candidate["rungs"][-1]["step"] for candidate in found["candidates"]}
    assert all(steps[name] == figures["step"] for name, figures in found["judged"].items())
    for candidate in found["candidates"]:
        model = Candidate(parse_form(candidate["form"]), candidate["latent"], candidate["light"], candidate["symmetry"])
        assert model.name == candidate["name"]
        assert candidate["parameters"] == size_of(config_of(model, recipe)).parameters
    finalists = [candidate for candidate in found["candidates"] if candidate["last_rung"] == len(found["rungs"])]
    close = [
        candidate for candidate in finalists
        if candidate["behind_the_best"]["value"] <= candidate["behind_the_best"]["standard_error"]
    ]  # fmt: skip
    assert min(close, key=lambda candidate: candidate["parameters"])["name"] == found["chosen"]
    assert max(finalists, key=lambda candidate: candidate["rungs"][-1]["bound"]["value"])["name"] == found["best"]
