"""A setting changes in a recipe what it says, and nothing else."""

import re
from dataclasses import replace
from pathlib import Path

import pytest

from trainer.config import TrainConfig
from trainer.errors import ConfigError
from trainer.presets import DEFAULT, load_preset, preset_names
from trainer.tables.setting import Setting, setting_for, setting_name, training_config
from trainer.tables.table import load_table, table_names
from trainer.training.checks import check_settings

ROOT = Path(__file__).parents[3]
ROWS = [
    (f"{name}/{row.name}", row.setting)
    for name in table_names()
    for row in load_table(name).rows
    if row.setting is not None
]


def test_the_default_is_the_recipe_itself() -> None:
    recipe = load_preset("sharp")
    assert training_config(Setting(), recipe) == recipe
    assert setting_name(Setting()) == "baseline"


@pytest.mark.parametrize(("name", "setting"), ROWS)
def test_every_row_is_a_training_that_could_begin_and_has_a_preset(name: str, setting: Setting) -> None:
    for category in ("car", "chair", "sofa"):
        own = setting_for(setting, category)
        for preset in preset_names():
            check_settings(training_config(own, load_preset(preset)))
        assert load_preset(f"{name}/{category}") == training_config(own, load_preset(DEFAULT))


def test_settings_that_differ_have_names_that_differ() -> None:
    settings = {
        replace(setting_for(setting, category), pose=pose)
        for _, setting in ROWS
        for category in ("car", "chair", "sofa")
        for pose in ("none", "azimuth")
    }
    assert len({setting_name(setting) for setting in settings}) == len(settings) > 20


def test_changes_are_lines_of_a_preset() -> None:
    lines = ("zoom = 1", "loss.kl_weight = 2", "loss.objective = 'paper'")
    recipe = load_preset("sharp")
    found = training_config(Setting(changes=lines), recipe)
    assert (found.zoom, found.loss.kl_weight, found.loss.objective) == (1, 2, "paper")
    assert replace(found, zoom=0, loss=recipe.loss) == recipe
    assert setting_name(Setting(changes=lines)) == "zoom-1_loss.kl_weight-2_loss.objective-paper"
    with pytest.raises(ConfigError, match="changes: loss: there is no setting 'kl_wieght'; did you mean 'kl_weight'"):
        training_config(Setting(changes=("loss.kl_wieght = 2",)), recipe)


def test_the_ablation_changes_the_default_preset() -> None:
    recipe, rows = load_preset("sharp"), {row.name: row.setting for row in load_table("ablation").rows}
    changed = {name: training_config(setting, recipe) for name, setting in rows.items() if setting is not None}
    assert changed["recipe"] == recipe
    assert all(config != recipe for name, config in changed.items() if name != "recipe")
    paper = load_preset("paper-small")
    optimiser = replace(paper.optimiser, steps=recipe.optimiser.steps)
    assert changed["paper"] == replace(paper, optimiser=optimiser)


def test_a_setting_changes_what_it_says() -> None:
    setting = Setting("full-block", "white", "varying", "shading", 3, 48, "azimuth")
    config = training_config(setting, load_preset("paper"))
    assert (config.model.parameterisation, config.model.light, config.model.latent) == ("full-block", "varying", 48)
    assert config.loss.pose_supervision == "azimuth"
    # "We instead sample 64 meshes and three poses per mesh" (section 5).
    assert (config.optimiser.batch_size, config.optimiser.views_per_instance) == (192, 3)
    assert setting_name(setting) == "full-block_white_varying_3-views_latent-48_pose-given"
    silhouette = training_config(Setting(loss="silhouette"), TrainConfig())
    assert replace(silhouette, loss=TrainConfig().loss) == TrainConfig()
    assert replace(silhouette.loss, kind="shading") == TrainConfig().loss


def test_a_recipe_of_several_views_gives_a_row_of_one_as_many_pictures_as_the_paper_s() -> None:
    optimiser = replace(TrainConfig().optimiser, views_per_instance=3, batch_size=192)
    recipe = replace(TrainConfig(), optimiser=optimiser)
    single = training_config(Setting(), recipe).optimiser
    assert (single.views_per_instance, single.batch_size) == (1, 128)
    assert training_config(Setting(views=3), recipe) == recipe


def test_what_a_setting_has_no_use_for_is_left_out_of_the_recipe() -> None:
    recipe = replace(
        TrainConfig(), model=replace(TrainConfig().model, segments=6, base="cup", light="varying", light_bins=5)
    )
    check_settings(recipe)
    blocks = training_config(Setting("ortho-block"), recipe)
    check_settings(blocks)
    assert (blocks.model.segments, blocks.model.base, blocks.model.light_bins) == (4, "cube", 3)
    kept = training_config(Setting(light="varying"), recipe)
    assert (kept.model.segments, kept.model.base, kept.model.light_bins) == (6, "cup", 5)
    uneven = replace(TrainConfig(), model=replace(TrainConfig().model, proportions=(1, 3, 10)))
    assert training_config(Setting("ortho-block"), uneven).model.proportions == (1, 1, 1)
    assert training_config(Setting(), uneven) == uneven


def test_the_best_parameterisation_is_the_class_s() -> None:
    best = Setting("best")
    found = {
        category: setting_for(best, category).parameterisation for category in ("car", "chair", "airplane", "sofa")
    }
    assert found == {"car": "subdivision", "chair": "full-block", "airplane": "subdivision", "sofa": "ortho-block"}


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        ("table-2/full-blok", "There is no row 'full-blok' in table-2; there are ortho-block, full-block, subdivision"),
        ("table-3/white", "Expected a class behind it, such as table-3/white/car, found none"),
        ("table-6/NMR (Kato 2018), white, silhouette, 2 views", "There is no row 'NMR"),
        ("table-3/white/chiar", "found 'chiar'; did you mean 'chair'?"),
        ("table-9/white", "There is no preset 'table-9/white'"),
    ],
)
def test_a_row_that_does_not_exist_is_named(name: str, sentence: str) -> None:
    with pytest.raises(ConfigError) as refusal:
        load_preset(name)
    assert sentence in str(refusal.value)


def test_a_table_that_does_not_exist_is_named() -> None:
    with pytest.raises(ConfigError, match="There is no table 'tabel-2'; did you mean 'table-2'"):
        load_table("tabel-2")


def test_the_documentation_names_every_row() -> None:
    told = (ROOT / "docs/paper.md").read_text()
    for name in table_names():
        (line,) = (line for line in told.splitlines() if line.startswith("|") and f"| `{name}` |" in line)
        rows = [row.name for row in load_table(name).rows if row.setting is not None]
        assert [f"`{row}`" for row in rows] == re.findall(r"`[^`]+`", line)[1:]
