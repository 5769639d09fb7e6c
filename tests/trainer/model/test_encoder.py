"""The encoder and its heads are those of Appendix A."""

import math

import pytest
import torch
from torch import nn

from trainer.config import ModelConfig
from trainer.model.encoder import Encoder
from trainer.model.posterior import PosteriorHeads
from trainer.model.vae import Model

# "3 × 3 convolution, 32 channels, stride = 2", and so on; None is a 2 × 2 max-pooling of stride 2.
APPENDIX_A = [(3, 32, 2), (3, 64, 1), None, (3, 96, 1), None, (3, 128, 1), None, (4, 128, 1)]


def test_layers_stand_as_in_appendix_a() -> None:
    encoder = Encoder(ModelConfig().encoder_channels, 128, 96)
    found: list[tuple[int, int, int] | None] = []
    layers = list(encoder.convolutions)
    for number, layer in enumerate(layers):
        if isinstance(layer, nn.Conv2d):
            assert layer.kernel_size[0] == layer.kernel_size[1]
            assert isinstance(layers[number + 1], nn.BatchNorm2d)
            assert isinstance(layers[number + 2], nn.ReLU)
            found.append((layer.kernel_size[0], layer.out_channels, layer.stride[0]))
        elif isinstance(layer, nn.MaxPool2d):
            assert (layer.kernel_size, layer.stride) == (2, 2)
            found.append(None)
    assert found == APPENDIX_A
    assert [type(layer) for layer in encoder.features] == [nn.Flatten, nn.Linear, nn.BatchNorm1d, nn.ReLU]


@pytest.mark.parametrize(("width", "height"), [(128, 96), (64, 48), (33, 17), (16, 16)])
def test_a_picture_of_any_size_becomes_128_features(width: int, height: int) -> None:
    encoder = Encoder(ModelConfig().encoder_channels, width, height).eval()
    with torch.no_grad():
        assert encoder(torch.rand(2, 3, height, width)).shape == (2, 128)


def test_a_decoder_is_two_layers_with_32_between_and_98_displacements() -> None:
    decoder = Model(ModelConfig(encoder_channels=(4, 4, 4, 4, 4, 4)), 32, 24).decoder
    sizes = [tuple(layer.weight.shape) for layer in decoder.modules() if isinstance(layer, nn.Linear)]
    assert sizes == [(32, 12), (3 * 98, 32)]


def test_fine_angles_keep_to_their_bins_and_deviations_are_positive() -> None:
    torch.manual_seed(0)
    heads = PosteriorHeads(16, 5, 12, 3)
    with torch.no_grad():
        posterior = heads(torch.randn(200, 16) * 100)
    light = posterior.light
    assert light is not None
    # Reached, in float32, where tanh is 1; the mean of z knows no bound.
    assert math.pi / 12 * 0.99 < posterior.azimuth_fine_mean.abs().max() <= math.pi / 12 + 1e-6
    assert math.pi / 6 * 0.99 < light.fine_mean.abs().max() <= math.pi / 6 + 1e-6
    assert posterior.shape_mean.abs().max() > 50
    for deviation in (posterior.shape_deviation, posterior.azimuth_fine_deviation, light.fine_deviation):
        assert deviation.min() > 0
    assert (posterior.azimuth_logits.shape, light.logits.shape) == ((200, 12), (200, 3))
