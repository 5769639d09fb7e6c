"""Do all contenders draw the same picture? Compared with our kernels before anything is timed."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from benchmarks.contender import Contender, FloatArray, Gradients
from benchmarks.ours import COMPOSED, FUSED, KERNELS
from benchmarks.scene import Scene

# A pixel that differs by more than this is reported as such; 0..1.
VISIBLE = 0.1
ENLARGED, SHOWN = 4, 4


def compare(contender: Contender, scene: Scene, folder: Path) -> dict[str, Any]:
    """Differences of pictures and directions of gradients against our kernels; writes ours, theirs, |difference|.

    The gradients are those of Σ (picture − black)², the same for every renderer up to its antialiasing.
    """
    black = _against_black(scene)
    ours, theirs = KERNELS.prepare(black), contender.prepare(black)
    picture, other = ours.forward(), theirs.forward()
    difference = np.abs(picture - other)
    seen = picture.max(1) > 0
    file = folder / f"{contender.name.lower().replace(',', '').replace(' ', '-')}.png"
    _write_sheet(picture[:SHOWN], other[:SHOWN], difference[:SHOWN], file)
    expected, found = ours.step(), theirs.step()
    return {
        "pictures_compared": scene.count,
        "mean_absolute_difference": float(difference.mean()),
        "mean_absolute_difference_on_object": float(difference.mean(1)[seen].mean()),
        f"share_of_pixels_that_differ_by_{VISIBLE}": float((difference.max(1) > VISIBLE).mean()),
        "cosine_of_colour_gradients": _cosine(expected.colours, found.colours),
        "cosine_of_position_gradients": _cosine(
            expected.positions[..., :2], _on_screen(found, contender, scene)[..., :2]
        ),
        "comparison": str(file.relative_to(folder.parent)),
    }


def compare_likelihoods(scene: Scene) -> dict[str, float]:
    """The fused log-likelihood against the composed one: largest relative difference, and directions of gradients."""
    ours, theirs = FUSED.prepare(scene), COMPOSED.prepare(scene)
    values, others = ours.forward(), theirs.forward()
    expected, found = ours.step(), theirs.step()
    return {
        "largest_relative_difference": float(np.abs(values / others - 1).max()),
        "cosine_of_colour_gradients": _cosine(expected.colours, found.colours),
        "cosine_of_position_gradients": _cosine(expected.positions, found.positions),
    }


def _against_black(scene: Scene) -> Scene:
    return replace(scene, targets=np.zeros_like(scene.targets))


def _on_screen(gradients: Gradients, contender: Contender, scene: Scene) -> FloatArray:
    """Gradients with respect to x and y in pixels, of a contender that has them at the camera."""
    if contender.space == "screen":
        return gradients.positions
    pixels_per_unit = scene.focal * scene.screen[..., 2:]
    return np.asarray(gradients.positions / pixels_per_unit)


def _cosine(a: FloatArray, b: FloatArray) -> float:
    return float((a * b).sum() / (np.linalg.norm(a) * np.linalg.norm(b)))


def _write_sheet(ours: FloatArray, theirs: FloatArray, difference: FloatArray, file: Path) -> None:
    """A column for each picture: ours, theirs, and the difference; enlarged, roughly sRGB."""
    rows = [np.concatenate(list(pictures.transpose(0, 2, 3, 1)), 1) for pictures in (ours, theirs, difference)]
    sheet = (255 * np.clip(np.concatenate(rows), 0, 1) ** (1 / 2.2)).astype(np.uint8)
    file.parent.mkdir(parents=True, exist_ok=True)
    image = Image.fromarray(sheet)
    image.resize((image.width * ENLARGED, image.height * ENLARGED), Image.Resampling.NEAREST).save(file)
