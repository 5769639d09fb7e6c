"""Budgets are plans that could begin, and what a plan says wrongly is named."""

from dataclasses import replace
from pathlib import Path

import pytest

from trainer.errors import ConfigError
from trainer.frontier.plan import BUDGETS, DEFAULT, load_plan
from trainer.frontier.trainings import study_of, tasks_of
from trainer.presets import load_preset
from trainer.training.checks import check_settings

SCALE = """
[scale]
preset = "fast"
instances = 12
test_instances = 3
test_views = 2
width = 48
height = 36
steps = 6
"""
POINTS = """
[[factors]]
name = "default"
title = "The default"
points = [{ name = "default", label = "default" }]
"""


@pytest.mark.parametrize("budget", BUDGETS)
def test_every_training_of_a_budget_could_begin(budget: str) -> None:
    plan = load_plan(budget)
    study = study_of(plan, Path("somewhere"))
    for task in tasks_of(plan):
        check_settings(study.config(task.cell))
    # Two trainings that differ have directories that do.
    assert len({study.run_directory(task.cell) for task in tasks_of(plan)}) == len(tasks_of(plan))
    assert plan.point(DEFAULT).variant.config.model == load_preset(plan.scale.preset).model


def test_the_full_budget_varies_everything_that_was_asked_for() -> None:
    plan = load_plan("full")
    start = plan.point(DEFAULT).variant.config
    varied = {
        "size": lambda config: (config.width, config.height),
        "width": lambda config: config.model.encoder_channels,
        "segments": lambda config: config.model.segments,
        "blocks": lambda config: (config.model.parameterisation, config.model.blocks),
        "latent": lambda config: config.model.latent,
        "bins": lambda config: config.model.azimuth_bins,
        "precision": lambda config: config.precision,
        "edges": lambda config: (config.loss.antialias, config.loss.antialias_e_step),
        "steps": lambda config: config.optimiser.steps,
    }
    for name, value in varied.items():
        others = [point.variant.config for point in plan.points if point.factor.name == name]
        assert others, name
        assert len({value(config) for config in (start, *others)}) == 1 + len(others), name
    assert {point.choice.bundle for point in plan.points} == {"float32", "float16", "int8"}


def test_the_paper_s_point_has_the_paper_s_objective_and_architecture() -> None:
    config, paper = load_plan("full").point("paper").variant.config, load_preset("paper")
    assert (config.loss, config.model) == (paper.loss, paper.model)


def test_a_point_changes_what_it_says_and_shares_a_training_with_those_that_are_trained_alike(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(
        SCALE
        + POINTS
        + """
[[factors]]
name = "some"
title = "Some"
points = [
  { name = "more-steps", label = "more", changes = { optimiser = { steps = 9 } }, seeds = [0, 1] },
  { name = "small", label = "int8", bundle = "int8" },
]
"""
    )
    plan = load_plan(str(path))
    fast = load_preset("fast")
    expected = replace(fast, optimiser=replace(fast.optimiser, steps=6))
    assert plan.point(DEFAULT).variant.config == plan.point("small").variant.config == expected
    assert plan.point("small").variant.name == DEFAULT
    assert plan.point("more-steps").variant.config.optimiser.steps == 9
    assert [(task.cell.setting.name, task.cell.seed) for task in tasks_of(plan)] == [
        (DEFAULT, 0), ("more-steps", 0), ("more-steps", 1),
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (POINTS, "scale: the setting 'preset' is missing"),
        (SCALE, "expected the first point to be called default, since the others are compared with it, found none"),
        (SCALE + POINTS + POINTS, "expected points of different names, found default twice"),
        (SCALE.replace("fast", "fsat") + POINTS, "no preset 'fsat'; did you mean 'fast'?"),
        (SCALE.replace("width", "widht") + POINTS, "scale: there is no setting 'widht'; did you mean 'width'?"),
        (SCALE + POINTS.replace("label", "lable"), "default: there is no setting 'lable'; did you mean 'label'?"),
        (SCALE + POINTS.replace(" }]", ", changes = { wide = 3 } }]"), "default: there is no setting 'wide'"),
        (SCALE + POINTS.replace(" }]", ', bundle = "int4" }]'), "expected one of 'float32', 'float16', 'int8'"),
        (
            SCALE + POINTS.replace(" }]", ", seeds = [] }]"),
            "expected a class and a seed at least of default, found none",
        ),
        ("scale =", "expected a TOML file, found"),
    ],
)
def test_what_a_plan_says_wrongly_is_named(tmp_path: Path, content: str, sentence: str) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(content)
    with pytest.raises(ConfigError) as refusal:
        load_plan(str(path))
    assert sentence in str(refusal.value)


def test_a_budget_that_does_not_exist_is_named(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"Expected a budget, small or full, or a file .* found 'ful'"):
        load_plan("ful")
    with pytest.raises(ConfigError, match=r"absent\.toml cannot be read"):
        load_plan(str(tmp_path / "absent.toml"))
