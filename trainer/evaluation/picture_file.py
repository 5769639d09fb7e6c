"""A picture file on its own, as a model sees it."""

from pathlib import Path

import torch
from jaxtyping import Float
from torch import Tensor

from imaging.srgb import decode_table
from trainer.config import SceneConfig
from trainer.data.decoding import Unusable, decode_picture
from trainer.data.images import fitted, frame_in
from trainer.data.lens import through_lens_of
from trainer.data.scene import read_scene
from trainer.errors import DataError


def read_picture(path: Path, scene: SceneConfig) -> Float[Tensor, "3 H W"]:
    """A picture in linear RGB on black, brought into the scene's frame as those of a folder are.

    It is framed already where its folder or the one above holds a `scene.json`, as renderings do; else its object is
    cut out. Raises DataError where the file or that scene cannot be read, or the object cannot be told.
    """
    frame = frame_in(scene)
    rendered = next(filter(None, map(read_scene, path.resolve().parents[:2])), None)
    if rendered:
        _, zoom = through_lens_of(scene, fitted(rendered, scene.width, scene.height))
        frame = frame._replace(zoom=zoom)
    found = decode_picture(path, frame, framed=rendered is not None)
    if isinstance(found, Unusable):
        raise DataError(
            f"{found.sentence}. Name a PNG, JPEG or WebP file of one object before a plain or transparent background."
        )
    return torch.from_numpy(decode_table()[found.codes])
