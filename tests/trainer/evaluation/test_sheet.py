"""Contact sheets: every tile in its place, in sRGB."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from imaging.srgb import encode
from trainer.errors import StorageError
from trainer.evaluation.sheet import tiled, write_sheet


def test_tiles_stand_in_rows_and_columns(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    pictures = rng.uniform(size=(2, 3, 20, 30, 3)).astype(np.float32)
    write_sheet(tmp_path / "sheet.png", [list(pictures[0]), list(pictures[1][:2])])
    sheet = np.asarray(Image.open(tmp_path / "sheet.png"))
    assert sheet.shape == (2 * 22 + 2, 3 * 32 + 2, 3)
    for row, column in [(0, 0), (0, 2), (1, 1)]:
        tile = sheet[2 + row * 22 :, 2 + column * 32 :][:20, :30]
        np.testing.assert_array_equal(tile, encode(pictures[row, column]))
    assert len(np.unique(sheet[24:44, 66:96].reshape(-1, 3), axis=0)) == 1  # the place that is left empty


def test_titles_stand_above_their_columns_and_are_cut_to_fit() -> None:
    black = np.zeros((20, 40, 3), np.float32)
    plain, titled = tiled([[black, black]]), tiled([[black, black]], ["", "a title that is far too long"])
    extra = titled.height - plain.height
    assert extra > 8
    band = np.asarray(titled)[:extra]
    assert (band[:, :42] == band[0, 0]).all()
    assert (band[:, 44:] != band[0, 0]).any()
    np.testing.assert_array_equal(np.asarray(titled)[extra:], np.asarray(plain))


def test_labels_stand_beside_their_rows() -> None:
    black = np.zeros((20, 40, 3), np.float32)
    plain, labelled = tiled([[black], [black]], ["a"]), tiled([[black], [black]], ["a"], ["", "IoU 0.50"])
    extra = labelled.width - plain.width
    assert extra > 40
    np.testing.assert_array_equal(np.asarray(labelled)[:, extra:], np.asarray(plain))
    margin = np.asarray(labelled)[:, :extra]
    assert (margin[16:39] == margin[0, 0]).all()
    assert (margin[39:] != margin[0, 0]).any()


def test_pictures_of_several_sizes_or_none_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="of one size"):
        tiled([[np.zeros((2, 2, 3)), np.zeros((3, 2, 3))]])
    with pytest.raises(ValueError, match="found none"):
        tiled([])
    (tmp_path / "file").write_text("x")
    with pytest.raises(StorageError):
        write_sheet(tmp_path / "file" / "sheet.png", [[np.zeros((2, 2, 3))]])
