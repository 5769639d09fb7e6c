"""Every preset is a setting that a training accepts, and a wrong one is answered with the nearest right one."""

from dataclasses import replace
from pathlib import Path

import pytest

from trainer.config import TrainConfig
from trainer.errors import ConfigError
from trainer.presets import DEFAULT, load_preset, preset_names
from trainer.training.checks import check_settings

ROOT = Path(__file__).parents[2]


def test_the_presets_that_the_documentation_names_are_there() -> None:
    assert {"balanced", "detailed", "fast", "paper", "sharp", "told"} <= set(preset_names())


@pytest.mark.parametrize("name", preset_names())
def test_every_preset_is_a_training_that_could_begin(name: str) -> None:
    check_settings(load_preset(name))


@pytest.mark.parametrize(("name", "size", "steps"), [("fast", (48, 36), 300), ("balanced", (64, 48), 600)])
def test_short_presets_are_the_default_one_with_shorter_schedules_and_independent_codes(
    name: str, size: tuple[int, int], steps: int
) -> None:
    default, preset = load_preset(DEFAULT), load_preset(name)
    schedules = {
        "kl_cooling_steps": 100,
        "temperature_cooling_steps": 70,
        "encoder_prior_steps": 170,
        "e_step_centred_steps": 170,
    }
    assert all(getattr(default.loss, schedule) > short for schedule, short in schedules.items())
    width, height = size
    loss = replace(default.loss, **schedules, independence_weight=400)
    optimiser = replace(default.optimiser, steps=steps)
    assert preset == replace(default, width=width, height=height, loss=loss, optimiser=optimiser)


def test_what_the_ablation_is_trained_with_is_the_preset_fast_without_independent_codes() -> None:
    fast, brief = load_preset("fast"), load_preset(str(ROOT / "benchmarks/brief.toml"))
    assert brief == replace(fast, loss=replace(fast.loss, independence_weight=0))


def test_the_paper_s_preset_is_what_the_paper_says() -> None:
    preset = load_preset("paper")
    assert (preset.width, preset.height, preset.model) == (128, 96, TrainConfig().model)
    assert preset.loss.objective == "paper"
    assert preset.loss.kl_weight == preset.loss.kl_weight_start
    assert preset.loss.laplacian_weight == preset.loss.laplacian_weight_start == 0
    assert (preset.optimiser.learning_rate, preset.optimiser.gradient_clip) == (1e-3, 5)
    assert preset.optimiser.batch_size == 128
    # Appendix B's α : β is 500 : 1 in any unit of the likelihood; docs/paper.md says which one is taken here.
    assert preset.loss.prior_matching_weight / preset.loss.kl_weight == pytest.approx(500, rel=0.15)


def test_a_file_of_one_s_own_changes_what_it_names(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text("seed = 5\n[optimiser]\nsteps = 7\n")
    settings = load_preset(str(path))
    assert (settings.seed, settings.optimiser.steps) == (5, 7)
    assert settings.loss == TrainConfig().loss


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (
            "[optimiser]\nbatchsize = 3",
            "mine.toml: optimiser: there is no setting 'batchsize'; did you mean 'batch_size'?",
        ),
        ("widht = 3", "mine.toml: there is no setting 'widht'; did you mean 'width'?"),
        ("width = 'x'", "mine.toml: width: expected a whole number, found 'x'"),
        ("[loss]\nobjective = 'best'", "expected one of 'exact', 'paper', found 'best'"),
        ("width =", "mine.toml: expected a TOML file, found"),
    ],
)
def test_wrong_content_is_named(tmp_path: Path, content: str, message: str) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(content)
    with pytest.raises(ConfigError) as refusal:
        load_preset(str(path))
    assert message in str(refusal.value)


def test_an_absent_preset_or_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"no preset 'papre'; did you mean 'paper'\?"):
        load_preset("papre")
    with pytest.raises(ConfigError, match=r"absent\.toml cannot be read"):
        load_preset(str(tmp_path / "absent.toml"))
    (tmp_path / "binary.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ConfigError, match=r"binary\.toml cannot be read"):
        load_preset(str(tmp_path / "binary.toml"))
