"""What an architecture costs, where that can be counted by hand."""

from trainer.config import ModelConfig, TrainConfig
from trainer.frontier.costs import architecture_of, multiply_adds
from trainer.frontier.plan import Choice, Factor, Point
from trainer.model.vae import Model
from trainer.tables.setting import Variant


def test_multiply_adds_are_counted() -> None:
    """Five convolutions at 16, 16, 8, 4 and 2 pixels a side; the features; five heads; the decoder's two layers."""
    config = ModelConfig(latent=3, hidden=5, segments=1, azimuth_bins=4, encoder_channels=(2, 3, 4, 5, 6, 7))
    convolutions = 16**2 * (3 * 9 * 2 + 2 * 9 * 3) + 8**2 * 3 * 9 * 4 + 4**2 * 4 * 9 * 5 + 2**2 * 5 * 16 * 6
    features = 6 * 2 * 2 * 7
    heads = 7 * (2 * 3 + 4 + 2)
    decoder = 3 * 5 + 5 * 3 * 8
    assert multiply_adds(Model(config, 32, 32)) == convolutions + features + heads + decoder


def test_points_that_differ_in_their_training_alone_share_an_architecture() -> None:
    def point(config: TrainConfig, bundle: str) -> Point:
        return Point(Factor("f", "F"), Choice("n", "l", bundle=bundle), Variant("v", config))  # type: ignore[arg-type]

    usual = architecture_of(point(TrainConfig(), "float32"))
    assert architecture_of(point(TrainConfig(seed=3), "float32")) == usual
    assert architecture_of(point(TrainConfig(width=64), "float32")) != usual
    assert architecture_of(point(TrainConfig(model=ModelConfig(latent=3)), "float32")) != usual
    assert architecture_of(point(TrainConfig(), "int8")) != usual
