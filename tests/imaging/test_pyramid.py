"""The pyramid as a linear map, against the paper's likelihood as the renderer's oracle has it."""

import numpy as np
import pytest
import torch

from imaging.pyramid import pyramid
from trainer.rendering import reference


@pytest.mark.parametrize(("height", "width"), [(36, 48), (9, 7), (1, 5), (3, 1), (2, 2)])
def test_half_the_squared_distance_is_the_likelihood(height: int, width: int) -> None:
    random = np.random.default_rng(height * width)
    first, second = random.uniform(0, 1, (2, 3, height, width)).astype(np.float32)
    made = pyramid(np.stack((first, second)))
    expected = reference.log_likelihood(torch.tensor(first).double(), torch.tensor(second).double())
    assert -0.5 * np.square(made[0] - made[1], dtype=np.float64).sum() == pytest.approx(float(expected), rel=1e-5)
