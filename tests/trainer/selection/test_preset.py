"""A chosen setting survives its way through TOML."""

from dataclasses import replace
from pathlib import Path

import pytest

from trainer.config import LossConfig, ModelConfig, OptimiserConfig, TrainConfig
from trainer.presets import load_preset, preset_names
from trainer.selection.preset import as_toml


@pytest.mark.parametrize(
    "config",
    [
        TrainConfig(),
        *(load_preset(name) for name in preset_names()),
        replace(
            load_preset("fast"),
            seed=7,
            precision="bfloat16",
            model=ModelConfig(parameterisation="full-block", blocks=3, latent=5, encoder_channels=(4, 4, 4, 4, 4, 9)),
            loss=LossConfig(kind="silhouette", eta=1e-7, kl_weight=0.1 + 0.2),
            optimiser=OptimiserConfig(learning_rate=1e-22, gradient_clip=1e12),
        ),
    ],
)
def test_a_setting_is_read_again_as_it_was(config: TrainConfig, tmp_path: Path) -> None:
    (tmp_path / "preset.toml").write_text(as_toml(config, "why"))
    assert load_preset(str(tmp_path / "preset.toml")) == config


def test_only_what_is_unusual_is_written() -> None:
    config = replace(TrainConfig(), width=48, model=ModelConfig(light="varying"))
    assert as_toml(config, "why") == '# why\nwidth = 48\n\n[model]\nlight = "varying"\n'
