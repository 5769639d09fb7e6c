"""`python -m trainer stability`: pages, charts and figures of all parts; what is there is kept."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from tests.trainer.command_line import answer
from tests.trainer.new_model import new_model, save_model
from trainer.commands import stability
from trainer.stability import examination
from trainer.stability.budget import BUDGETS, severities_of
from trainer.stability.conditions import CONDITIONS
from trainer.stability.edges import TITLES
from trainer.training.checkpoint import FILE_NAME

ASKED = tuple(condition for condition in CONDITIONS if condition.name in ("jpeg", "lights-turned"))
PAIRS = [(what, how) for what in ("picture", "gradient") for how in ("exact", "contours")]


@pytest.fixture
def model(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A model that nobody has trained; hardly anything is asked of it."""
    monkeypatch.setitem(
        BUDGETS, "small", replace(BUDGETS["small"], objects=4, views=1, validation_objects=24, others=1)
    )
    monkeypatch.setattr(examination, "CONDITIONS", ASKED)
    save_model(tmp_path / "new" / FILE_NAME, new_model())
    return tmp_path / "new"


def test_a_model_is_examined_once(
    model: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(stability, "find_spec", lambda name: None)
    (tmp_path / "page.md").write_text("{models[new][clean][pictures]} pictures\n")
    options = ["stability", "--checkpoint", model, "--parts", "pictures", "--output", tmp_path / "out"]
    status, _, errors = answer(capsys, *options)
    assert status == 0, errors
    assert "no charts: they need matplotlib" in errors
    folder = tmp_path / "out" / "small"
    results = json.loads((folder / "stability.json").read_text())
    found = results["models"]["new"]
    assert list(found["conditions"]) == ["jpeg", "lights-turned"]
    for condition in ASKED:
        points = found["conditions"][condition.name]["points"]
        assert [point["severity"] for point in points] == list(severities_of(BUDGETS["small"], condition.severities))
        untouched = {name: points[0][name] for name in found["clean"]}
        assert untouched == found["clean"]
        for point in points:
            sent = point["upload"]
            parts = sent["refused_at_once"] + sent["refused"] + sent["right"] + sent["wrong"]
            assert parts == pytest.approx(1, abs=1e-3)
    assert len(found["other_classes"]) == 12
    assert found["held_out_measured"]
    page = (folder / "stability.md").read_text()
    assert "## conditions, new" in page
    assert "## trainings" not in page

    monkeypatch.setattr(stability, "examine", None)
    status, _, errors = answer(capsys, *options, "--page", tmp_path / "page.md")
    assert status == 0, errors
    assert (folder / "stability.md").read_text() == "4 pictures\n"


def test_the_rasteriser_alone(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    point = {"angle_degrees": 5, "scenes": 1, **{f"{what}_error_{how}": 0.5 for what, how in PAIRS}}
    monkeypatch.setattr(
        stability, "edge_figures", lambda scenes: {kind: {"title": TITLES[kind], "points": [point]} for kind in TITLES}
    )
    status, _, errors = answer(capsys, "stability", "--parts", "rasteriser", "--output", tmp_path)
    assert status == 0, errors
    assert json.loads((tmp_path / "small" / "stability.json").read_text())["models"] == {}
    assert (
        "| a plate, by its angle to the camera | 5° | 0.50 | 0.50 | 50.0 % | 50.0 % |"
        in (tmp_path / "small" / "stability.md").read_text()
    )


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (["--parts", "trainings", "--regimes", "batch-5"], "Expected --regimes out of usual, batch-8,"),
        (["--seeds", "101"], "Expected --seeds from 0 to 100, found 101."),
        (["--page", "nowhere.md"], "The page nowhere.md cannot be read"),
        (["--bundle", "nowhere"], "Expected a bundle at nowhere, found no manifest.json"),
        (["--checkpoint", "MODEL", "MODEL"], "Expected models in directories of different names, found new more than"),
    ],
)
def test_mistakes_are_told_before_anything_takes_long(
    model: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], options: list[str], sentence: str
) -> None:
    named = [str(model) if option == "MODEL" else option for option in options]
    status, _, errors = answer(capsys, "stability", *named, "--output", tmp_path / "out")
    assert status == 2
    assert sentence in errors
    assert not (tmp_path / "out").exists()


def test_without_models_nothing_is_examined(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    status, _, errors = answer(capsys, "stability", "--output", tmp_path / "out")
    assert status == 2
    assert "Expected --bundle DIR or --checkpoint RUN, found neither, and no models/ here." in errors
