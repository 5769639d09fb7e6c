"""Whether another exposure explains a picture."""

import numpy as np
import pytest

from imaging.exposure import exposure, unexplained_light


def test_an_exposure_is_believed_where_it_explains_twice_as_much() -> None:
    drawn = np.full((3, 4, 4), 0.5, np.float32)
    other = drawn * np.where(np.arange(16).reshape(4, 4) % 2, 1.4, 0.6)
    assert exposure(0.4 * drawn, drawn) == pytest.approx(0.4)
    assert exposure(0.01 * drawn, drawn) == pytest.approx(1 / 16)
    assert exposure(0.3 * other, drawn) == pytest.approx(0.3)
    assert exposure(0.9 * other, drawn) == 1
    assert exposure(drawn, 0 * drawn) == exposure(0 * drawn, 0 * drawn) == 1


def test_what_another_exposure_explains_counts_twice() -> None:
    drawn = np.full((3, 4, 4), 0.5, np.float32)
    other = drawn * np.where(np.arange(16).reshape(4, 4) % 2, 1.2, 0.8)
    alone = 0.04 / 1.04
    assert unexplained_light(other, drawn) == pytest.approx(alone)
    assert unexplained_light(0.3 * other, drawn) == pytest.approx(2 * alone)
    assert unexplained_light(0.95 * other, drawn) < 2 * alone
    assert unexplained_light(drawn, 0 * drawn) == pytest.approx(1)
