"""Contact sheets show the best, the middle and the worst objects, in that order."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from imaging.srgb import decode_table
from tests.trainer.evaluation.conftest import knowing, subject_of
from trainer.data.shapes.solid import Mesh
from trainer.evaluation.contact import ROWS, ranked, write_sheets
from trainer.evaluation.pictures import Pictures
from trainer.evaluation.protocol import judge


def test_objects_are_ranked_by_the_picture_in_the_middle_of_their_own() -> None:
    overlaps = np.array([0.9, 0.1, 0.5, 0.2, 0.3, 0.8, 0.7])
    objects = np.array([0, 0, 0, 1, 1, 2, 2])
    # Object 1: 0.2 of 0.2 and 0.3; object 0: 0.5 of 0.1, 0.5, 0.9; object 2: 0.7 of 0.7 and 0.8.
    np.testing.assert_array_equal(ranked(overlaps, objects), [3, 2, 6])


def test_four_sheets_are_written(tested: Pictures, shapes: list[Mesh], tmp_path: Path) -> None:
    subject = subject_of(knowing(shapes, 0.0, tested))
    judgement = judge(subject, tested, None)
    write_sheets(tmp_path, subject, tested, judgement)
    assert {path.name for path in tmp_path.iterdir()} == {"best.png", "median.png", "worst.png", "sheet.png"}
    best, worst, sheet = (np.asarray(Image.open(tmp_path / f"{name}.png")) for name in ("best", "worst", "sheet"))
    # Three objects: the best sheet is the worst one upside down.
    height = 3 * 30 + 2
    assert len(best) == len(worst) == 16 + 3 * height + 2
    assert len(sheet) == 16 + ROWS * height + 2
    tiles = [best[18 + row * height :, 58:][:90, :120] for row in range(3)]
    upside_down = [worst[18 + row * height :, 58:][:90, :120] for row in reversed(range(3))]
    np.testing.assert_array_equal(tiles, upside_down)
    first = tested.codes[ranked(judgement.overlaps, tested.objects)[-1]]
    shown = decode_table()[tiles[0][1::3, 1::3]]
    assert np.abs(shown - decode_table()[first.transpose(1, 2, 0)]).max() == pytest.approx(0, abs=0.01)
