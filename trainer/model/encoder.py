"""enc_ω(x): the convolutional network of Appendix A, from a picture to a feature vector."""

import torch
from jaxtyping import Float
from torch import Tensor, nn


class Encoder(nn.Module):
    """Five convolutions and a fully connected layer, each with batch normalisation and ReLU.

    Convolutions keep the size ("same" padding), so that any picture of at least 16 × 16 pixels will do.
    """

    def __init__(self, channels: tuple[int, int, int, int, int, int], width: int, height: int) -> None:
        super().__init__()
        first, second, third, fourth, fifth, features = channels
        self.convolutions = nn.Sequential(
            *_block(3, first, kernel=3, stride=2),
            *_block(first, second, kernel=3),
            nn.MaxPool2d(2),
            *_block(second, third, kernel=3),
            nn.MaxPool2d(2),
            *_block(third, fourth, kernel=3),
            nn.MaxPool2d(2),
            *_block(fourth, fifth, kernel=4),
        )
        # The layout that convolutions on a CPU are fast in; torch's annotations do not know the option.
        self.convolutions.to(memory_format=torch.channels_last)  # type: ignore[call-overload]
        pixels = ((width + 1) // 2 // 8) * ((height + 1) // 2 // 8)
        self.features = nn.Sequential(
            nn.Flatten(), nn.Linear(fifth * pixels, features, bias=False), nn.BatchNorm1d(features), nn.ReLU()
        )

    def forward(self, images: Float[Tensor, "B 3 H W"]) -> Float[Tensor, "B features"]:
        encoded: Tensor = self.features(self.convolutions(images))
        return encoded


def _block(inputs: int, outputs: int, kernel: int, stride: int = 1) -> tuple[nn.Module, ...]:
    # Before an even kernel one row and column more are padded at the right and bottom than at the left and top.
    padding = nn.ZeroPad2d(((kernel - 1) // 2, kernel // 2, (kernel - 1) // 2, kernel // 2))
    convolution = nn.Conv2d(inputs, outputs, kernel, stride, bias=False)
    return padding, convolution, nn.BatchNorm2d(outputs), nn.ReLU()
