"""Contact sheets: linear pictures tiled into one PNG that a person can look at."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from PIL import Image, ImageDraw, ImageFont

from imaging.srgb import encode
from trainer.data.writing import write_png

_TITLE_HEIGHT, _LABEL_WIDTH, _GAP = 16, 56, 2
_BACKGROUND, _INK = (64, 64, 64), (255, 255, 255)


def write_sheet(
    path: Path,
    pictures: Sequence[Sequence[Float[ndarray, "H W 3"]]],
    titles: Sequence[str] = (),
    labels: Sequence[str] = (),
) -> None:
    """Writes [rows][columns] of linear RGB pictures of one size as a PNG in sRGB, `titles` above the columns, `labels`
    beside the rows.

    Rows may be shorter than the longest one. Raises ValueError where there is no picture or sizes differ, StorageError
    where the file cannot be written.
    """
    write_png(path, tiled(pictures, titles, labels))


def tiled(
    pictures: Sequence[Sequence[Float[ndarray, "H W 3"]]], titles: Sequence[str] = (), labels: Sequence[str] = ()
) -> Image.Image:
    """The sheet as a Pillow image."""
    sizes = {picture.shape for row in pictures for picture in row}
    if len(sizes) != 1:
        raise ValueError(f"expected pictures [H, W, 3] of one size, found {sorted(sizes) or 'none'}")
    height, width, _ = sizes.pop()
    columns = max(len(row) for row in pictures)
    left, top = (_LABEL_WIDTH if labels else 0), (_TITLE_HEIGHT if titles else 0)
    size = (left + columns * (width + _GAP) + _GAP, top + len(pictures) * (height + _GAP) + _GAP)
    sheet = Image.new("RGB", size, _BACKGROUND)
    for row, line in enumerate(pictures):
        for column, picture in enumerate(line):
            tile = Image.fromarray(encode(np.asarray(picture, np.float32)))
            sheet.paste(tile, (left + _GAP + column * (width + _GAP), top + _GAP + row * (height + _GAP)))
    pen, font = ImageDraw.Draw(sheet), ImageFont.load_default(size=11)
    for column, title in enumerate(titles):
        pen.text((left + _GAP + column * (width + _GAP), 2), _shortened(title, width, font), _INK, font)
    for row, label in enumerate(labels):
        pen.text((_GAP, top + _GAP + row * (height + _GAP)), _shortened(label, left - _GAP, font), _INK, font)
    return sheet


def _shortened(title: str, width: int, font: ImageFont.ImageFont | ImageFont.FreeTypeFont) -> str:
    """As much of a title as fits."""
    if font.getlength(title) <= width:
        return title
    while title and font.getlength(title + "…") > width:
        title = title[:-1]
    return title + "…"
