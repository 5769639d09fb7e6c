"""Folders of pictures: exact reduction, honest about what is missing, faithful to the scene."""

import dataclasses
import io
import math
from pathlib import Path

import numpy as np
import pytest
import torch
from PIL import Image

from trainer.config import SceneConfig
from trainer.data.decoding import decode_picture, scaled_to_fit
from trainer.data.images import load_image_folder
from trainer.data.metadata import Row, write_metadata
from trainer.data.picture import draw
from trainer.data.plan import RenderSettings
from trainer.data.render import render_folder
from trainer.data.shapes.catalogue import make_shape
from trainer.data.srgb import decode_table, encode
from trainer.errors import DataError


def save(path: Path, codes: np.ndarray, mode: str | None = None, **options: object) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(np.asarray(codes, np.uint8), mode).save(path, **options)


def linear(code: float) -> float:
    return code / 255 / 12.92 if code <= 10 else ((code / 255 + 0.055) / 1.055) ** 2.4


def test_srgb_codes_survive_the_way_to_linear_and_back() -> None:
    np.testing.assert_array_equal(encode(decode_table()), np.arange(256))
    np.testing.assert_allclose(decode_table(), [linear(code) for code in range(256)], rtol=1e-5)
    np.testing.assert_array_equal(encode(np.array([-1.0, 0.0, 1.0, 7.0, np.nan], np.float32)), [0, 0, 255, 255, 0])


def test_a_picture_of_the_right_size_is_taken_as_it_is(tmp_path: Path) -> None:
    codes = np.random.default_rng(0).integers(0, 256, (6, 8, 3))
    save(tmp_path / "a.png", codes)
    images = load_image_folder(tmp_path, 8, 6)
    np.testing.assert_array_equal(images.pictures[0], codes.transpose(2, 0, 1))
    batch = images.batch(np.array([0, 0]))
    assert batch.shape == (2, 3, 6, 8)
    assert batch.dtype == torch.float32
    expected = np.vectorize(linear)(codes).transpose(2, 0, 1)
    np.testing.assert_allclose(batch[1].numpy(), expected, rtol=1e-5)
    torch.testing.assert_close(images.batch(torch.tensor([0])), batch[:1])


def test_reduction_is_the_mean_of_linear_light(tmp_path: Path) -> None:
    codes = np.zeros((4, 4, 3))
    codes[:2, :2] = [[[255, 0, 0], [0, 0, 0]], [[0, 0, 0], [255, 255, 0]]]
    save(tmp_path / "a.png", codes)
    picture = decode_picture(tmp_path / "a.png", 2, 2)
    assert not isinstance(picture, str)
    # Half and a quarter of full light are the codes 188 and 137, not 128 and 64.
    np.testing.assert_array_equal(picture[:, 0, 0], (188, 137, 0))
    assert not picture[:, 1].any()


@pytest.mark.parametrize(
    ("size", "target"), [((7, 5), (3, 2)), ((9, 12), (4, 4)), ((3, 2), (8, 6)), ((10, 10), (128, 96))]
)
def test_scaling_keeps_the_light_and_where_it_comes_from(size: tuple[int, int], target: tuple[int, int]) -> None:
    rng = np.random.default_rng(1)
    source = rng.uniform(size=(size[1], size[0], 3)).astype(np.float32)
    scaled = scaled_to_fit(source, *target)
    scale = min(target[0] / size[0], target[1] / size[1])
    np.testing.assert_allclose(scaled.sum((0, 1)), source.sum((0, 1)) * scale**2, rtol=1e-4)
    np.testing.assert_allclose(scaled_to_fit(source[::-1, ::-1], *target), scaled[::-1, ::-1], atol=1e-6)
    # What was constant is constant, except where the picture ends within a pixel.
    flat = scaled_to_fit(np.ones_like(source), *target)[..., 0]
    left, top = (target[0] - scale * size[0]) / 2, (target[1] - scale * size[1]) / 2
    np.testing.assert_allclose(flat, np.outer(_covered(target[1], top), _covered(target[0], left)), atol=1e-5)


def _covered(pixels: int, margin: float) -> np.ndarray:
    starts = np.arange(pixels)
    return np.clip(np.minimum(starts + 1, pixels - margin) - np.maximum(starts, margin), 0, 1)


def test_another_aspect_is_padded_evenly_with_black(tmp_path: Path) -> None:
    save(tmp_path / "a.png", np.full((8, 4, 3), 255))
    save(tmp_path / "b.png", np.full((4, 16, 3), 255))
    tall, wide = load_image_folder(tmp_path, 8, 8).pictures[:, 0] / 255
    expected = np.zeros((8, 8))
    expected[:, 2:6] = 1
    np.testing.assert_array_equal(tall, expected)
    expected = np.zeros((8, 8))
    expected[3:5] = 1
    np.testing.assert_array_equal(wide, expected)


def test_transparency_is_black_whatever_colour_it_hides(tmp_path: Path) -> None:
    codes = np.full((2, 2, 4), 255)
    codes[..., 3] = [[0, 255], [128, 0]]
    save(tmp_path / "a.png", codes, "RGBA")
    picture = load_image_folder(tmp_path, 2, 2).pictures[0, 0]
    np.testing.assert_array_equal(picture, [[0, 255], [int(encode(np.array([128 / 255], np.float32))[0]), 0]])
    palette = Image.fromarray(np.array([[0, 1], [1, 0]], np.uint8), "P")
    palette.putpalette([255, 255, 255, 255, 0, 0])
    palette.save(tmp_path / "a.png", transparency=0)
    np.testing.assert_array_equal(load_image_folder(tmp_path, 2, 2).pictures[0, 0], [[0, 255], [255, 0]])


def test_grey_sixteen_bit_and_turned_pictures_are_read_as_meant(tmp_path: Path) -> None:
    save(tmp_path / "1.png", np.array([[0, 100], [200, 255]]))
    Image.fromarray(np.array([[0, 100 * 257], [200 * 257, 65535]], np.uint16)).save(tmp_path / "2.png")
    pictures = load_image_folder(tmp_path, 2, 2).pictures
    np.testing.assert_array_equal(pictures[0], pictures[1])
    np.testing.assert_array_equal(pictures[0, 2], [[0, 100], [200, 255]])
    turned = Image.fromarray(np.repeat(np.array([[[10], [90]]], np.uint8), 3, -1))
    exif = turned.getexif()
    exif[0x0112] = 6  # a quarter turn clockwise
    turned.save(tmp_path / "3.png", exif=exif)
    np.testing.assert_array_equal(load_image_folder(tmp_path, 1, 2).pictures[2, 0], [[10], [90]])


def test_what_is_rendered_is_loaded_with_everything_known(tmp_path: Path) -> None:
    render_folder(tmp_path, RenderSettings("car"), SceneConfig(32, 24), 3, 2, 1, show_progress=False)
    images = load_image_folder(tmp_path, 32, 24)
    assert len(images) == 6
    np.testing.assert_array_equal(images.instances, [0, 0, 1, 1, 2, 2])
    assert images.instance_names == ("car-0000000", "car-0000001", "car-0000002")
    assert images.names[3] == "car/car-0000001-01.png"
    assert images.azimuths is not None
    assert images.light_azimuths is not None
    assert not images.light_azimuths.any()
    assert images.scene == SceneConfig(32, 24)
    for index in (0, 5):
        mesh = make_shape("car", int(images.instances[index]))
        truth = draw(mesh, float(images.azimuths[index]), 0.0, images.scene)[0]
        np.testing.assert_allclose(images.batch(np.array([index]))[0].permute(1, 2, 0), truth, atol=0.005)


@pytest.mark.parametrize("size", [(64, 48), (32, 48), (64, 32), (48, 48)])
def test_the_scene_still_fits_after_padding(tmp_path: Path, size: tuple[int, int]) -> None:
    """What was rendered at one size and loaded at another is what the loaded scene draws at that size."""
    render_folder(tmp_path, RenderSettings("car", supersampling=8), SceneConfig(128, 96), 1, 1, 1, show_progress=False)
    images = load_image_folder(tmp_path, *size)
    assert (images.scene.width, images.scene.height) == size
    assert images.azimuths is not None
    truth = draw(make_shape("car", 0), float(images.azimuths[0]), 0.0, images.scene, 16)[0]
    loaded = images.batch(np.array([0]))[0].permute(1, 2, 0).numpy()
    assert truth.max() > 0.5
    assert np.abs(loaded - truth).max() < 0.08
    assert np.abs(loaded - truth).mean() < 0.001


def test_a_folder_without_anything_else_will_do(tmp_path: Path) -> None:
    for name in ("x/b.PNG", "a.jpg", "c.webp"):
        save(tmp_path / name, np.full((4, 4, 3), 200))
    (tmp_path / "notes.txt").write_text("not a picture")
    images = load_image_folder(tmp_path, 4, 4)
    assert images.names == ("a.jpg", "c.webp", "x/b.PNG")
    np.testing.assert_array_equal(images.instances, [0, 1, 2])
    assert images.azimuths is None
    assert images.scene == SceneConfig(width=4, height=4)


def test_azimuths_are_known_for_all_or_not_at_all(tmp_path: Path) -> None:
    for name in ("a.png", "b.png"):
        save(tmp_path / name, np.zeros((2, 2, 3)))
    write_metadata(tmp_path, [Row("a.png", "one", 270.0, None), Row("b.png", "one", -90.0, 0.0)])
    images = load_image_folder(tmp_path, 2, 2)
    np.testing.assert_allclose(images.azimuths, [-math.pi / 2] * 2)
    assert images.light_azimuths is None
    np.testing.assert_array_equal(images.instances, [0, 0])


def test_broken_pictures_are_counted_named_and_skipped(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    for index in range(5):
        save(tmp_path / f"{index}.png", np.full((2, 2, 3), index))
    buffer = io.BytesIO()
    Image.fromarray(np.random.default_rng(0).integers(0, 256, (64, 64, 3), np.uint8)).save(buffer, "PNG")
    (tmp_path / "1.png").write_bytes(buffer.getvalue()[:2000])
    (tmp_path / "3.png").write_bytes(b"")
    images = load_image_folder(tmp_path, 2, 2)
    assert images.names == ("0.png", "2.png", "4.png")
    np.testing.assert_array_equal(images.pictures[:, 0, 0, 0], [0, 2, 4])
    assert len(images.skipped) == 2
    (record,) = caplog.records
    assert record.message.startswith(f"skipped 2 of 5 pictures that cannot be read; first: {tmp_path / '1.png'}")


def test_metadata_and_folder_that_disagree_are_reported(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    for name in ("a.png", "b.png"):
        save(tmp_path / name, np.zeros((2, 2, 3)))
    write_metadata(tmp_path, [Row("a.png", "a", None, None), Row("gone.png", "c", None, None)])
    assert load_image_folder(tmp_path, 2, 2).names == ("a.png",)
    absent, unnamed = (record.message for record in caplog.records)
    assert "metadata.csv names 1 pictures that are not there; first: gone.png" in absent
    assert "skipped 1 pictures that" in unnamed
    assert unnamed.endswith("does not name; first: b.png")
    write_metadata(tmp_path, [Row("images/a.png", "a", None, None)])
    with pytest.raises(DataError, match=r"names none of the 2 pictures .* such as a.png, found images/a.png"):
        load_image_folder(tmp_path, 2, 2)


def test_folders_without_pictures_are_refused(tmp_path: Path) -> None:
    with pytest.raises(DataError, match=r"expected a folder of pictures at .* found nothing"):
        load_image_folder(tmp_path / "nowhere", 2, 2)
    with pytest.raises(DataError, match=r"expected pictures .* found none"):
        load_image_folder(tmp_path, 2, 2)
    (tmp_path / "a.png").write_bytes(b"nothing")
    with pytest.raises(DataError, match=r"none of the 1 pictures .* can be read; first: .*a.png"):
        load_image_folder(tmp_path, 2, 2)
    with pytest.raises(DataError, match="found a file"):
        load_image_folder(tmp_path / "a.png", 2, 2)


def test_a_picture_of_too_many_pixels_is_not_decoded(tmp_path: Path) -> None:
    path = tmp_path / "bomb.png"
    Image.new("1", (10_000, 6_000)).save(path)
    found = decode_picture(path, 8, 6)
    assert isinstance(found, str)
    assert "expected at most 50,000,000 pixels, found 10000 x 6000" in found


def test_an_image_set_cannot_be_changed(tmp_path: Path) -> None:
    save(tmp_path / "a.png", np.zeros((2, 2, 3)))
    images = load_image_folder(tmp_path, 2, 2)
    with pytest.raises(dataclasses.FrozenInstanceError):
        images.names = ()  # type: ignore[misc]
