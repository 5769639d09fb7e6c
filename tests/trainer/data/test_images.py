"""Folders of pictures: rendered ones as they are, people's own cut out and framed, honest about what is missing."""

import dataclasses
import io
import math
from pathlib import Path

import numpy as np
import pytest
import torch
from PIL import Image
from threadpoolctl import threadpool_info, threadpool_limits

from imaging.framing import frame_of
from imaging.preparation import prepare
from imaging.srgb import encode
from tests.imaging.photographs import before, boards, cutout, photographed, plain, transparent
from trainer.config import CameraConfig, SceneConfig
from trainer.data.decoding import Unusable, decode_picture, decoders
from trainer.data.images import Preparation, load_image_folder
from trainer.data.metadata import Row, write_metadata
from trainer.data.picture import draw
from trainer.data.plan import RenderSettings
from trainer.data.render import render_folder
from trainer.data.scene import write_scene
from trainer.data.shapes.catalogue import make_shape
from trainer.errors import DataError

CAR = cutout("car", 2, 0.9, 0.7)
FRAME = frame_of(64, 48, 2.0, 30.0)


def save(path: Path, codes: np.ndarray, mode: str | None = None, **options: object) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(np.asarray(codes, np.uint8), mode).save(path, **options)


def rendered(folder: Path, count: int, width: int = 4, height: int = 4) -> Path:
    """A folder in its scene's frame, with pictures of one code each."""
    write_scene(folder, SceneConfig(width, height))
    for index in range(count):
        save(folder / f"{index}.png", np.full((height, width, 3), 10 * index))
    return folder


def linear(code: float) -> float:
    return code / 255 / 12.92 if code <= 10 else ((code / 255 + 0.055) / 1.055) ** 2.4


def test_a_rendered_picture_of_the_right_size_is_taken_as_it_is(tmp_path: Path) -> None:
    codes = np.random.default_rng(0).integers(0, 256, (6, 8, 3))
    write_scene(tmp_path, SceneConfig(8, 6))
    save(tmp_path / "a.png", codes)
    images = load_image_folder(tmp_path, 8, 6)
    np.testing.assert_array_equal(images.pictures[0], codes.transpose(2, 0, 1))
    assert images.preparation == Preparation(framed=1)
    batch = images.batch(np.array([0, 0]))
    assert batch.shape == (2, 3, 6, 8)
    assert batch.dtype == torch.float32
    expected = np.vectorize(linear)(codes).transpose(2, 0, 1)
    np.testing.assert_allclose(batch[1].numpy(), expected, rtol=1e-5)
    torch.testing.assert_close(images.batch(torch.tensor([0])), batch[:1])


def test_reduction_is_the_mean_of_linear_light(tmp_path: Path) -> None:
    codes = np.zeros((4, 4, 3))
    codes[:2, :2] = [[[255, 0, 0], [0, 0, 0]], [[0, 0, 0], [255, 255, 0]]]
    write_scene(tmp_path, SceneConfig(4, 4))
    save(tmp_path / "a.png", codes)
    picture = load_image_folder(tmp_path, 2, 2).pictures[0]
    # Half and a quarter of full light are the codes 188 and 137, not 128 and 64.
    np.testing.assert_array_equal(picture[:, 0, 0], (188, 137, 0))
    assert not picture[:, 1].any()


def test_rendered_pictures_with_transparency_are_black_there(tmp_path: Path) -> None:
    codes = np.full((2, 2, 4), 255)
    codes[..., 3] = [[0, 255], [128, 0]]
    write_scene(tmp_path, SceneConfig(2, 2))
    save(tmp_path / "a.png", codes, "RGBA")
    half = int(encode(np.array([128 / 255], np.float32))[0])
    np.testing.assert_array_equal(load_image_folder(tmp_path, 2, 2).pictures[0, 0], [[0, 255], [half, 0]])


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
    assert images.preparation == Preparation(framed=6)
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


def test_peoples_own_pictures_are_cut_out_and_framed(tmp_path: Path) -> None:
    contents = {
        "x/b.PNG": transparent(CAR),
        "a.jpg": photographed(before(CAR, plain(1, 1, 1)), 2, 90),
        "c.png": photographed(before(CAR, plain(0, 0, 0))),
    }
    (tmp_path / "x").mkdir()
    for name, content in contents.items():
        (tmp_path / name).write_bytes(content)
    (tmp_path / "notes.txt").write_text("not a picture")
    images = load_image_folder(tmp_path, 64, 48)
    assert images.names == ("a.jpg", "c.png", "x/b.PNG")
    np.testing.assert_array_equal(images.instances, [0, 1, 2])
    assert images.azimuths is None
    assert images.scene == SceneConfig(width=64, height=48)
    assert images.preparation == Preparation(alpha=1, background=2)
    for name, picture in zip(images.names, images.pictures, strict=True):
        np.testing.assert_array_equal(picture, encode(prepare(contents[name], FRAME, 10**7, False).picture))
    light = images.batch(np.arange(3)).sum((1, 2, 3))
    torch.testing.assert_close(light, light[2].expand(3), rtol=0.05, atol=0)


def test_own_pictures_stand_where_the_scene_of_a_narrow_frame_shows_them(tmp_path: Path) -> None:
    """In a frame that is higher than wide the field of view is widened, so that every object has room."""
    (tmp_path / "a.png").write_bytes(transparent(CAR))
    images = load_image_folder(tmp_path, 48, 96)
    half = math.degrees(math.atan(2 * math.tan(math.radians(15))))
    assert images.scene.camera == CameraConfig(field_of_view_degrees=pytest.approx(2 * half))
    assert not images.pictures[0][:, :, [0, -1]].any()
    # But for the black above and below it is what a square frame shows.
    square = load_image_folder(tmp_path, 48, 48).pictures[0].astype(int)
    assert np.abs(images.pictures[0][:, 24:72] - square).mean() < 1.5
    assert square.mean() > 20


def test_refused_pictures_are_counted_and_named(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    for index in range(3):
        (tmp_path / f"{index}.jpg").write_bytes(photographed(before(CAR, plain(1, 1, 1)), 2, 90))
    (tmp_path / "3.png").write_bytes(photographed(before(CAR, boards())))
    (tmp_path / "4.png").write_bytes(photographed(plain(1, 1, 1)))
    (tmp_path / "5.png").write_bytes(b"")
    images = load_image_folder(tmp_path, 64, 48)
    assert images.names == ("0.jpg", "1.jpg", "2.jpg")
    assert images.skipped == (
        f"{tmp_path}/5.png cannot be read as a picture (expected a picture, found an empty file)",
    )
    first, second = images.preparation.refused
    assert first == f"{tmp_path}/3.png: expected a plain background, found many colours or a texture along the border"
    assert second.startswith(f"{tmp_path}/4.png: expected an object that stands out from its background, found one on")
    unreadable, refused = (record.message for record in caplog.records)
    assert unreadable.startswith("skipped 1 of 6 pictures that cannot be read; first: ")
    assert refused.startswith(
        f"refused 2 of 6 pictures whose object cannot be told from its background; first: {tmp_path}/3.png"
    )


def test_a_folder_of_nothing_but_refused_pictures_is_refused(tmp_path: Path) -> None:
    for index in range(3):
        (tmp_path / f"{index}.png").write_bytes(photographed(before(CAR, boards(index))))
    with pytest.raises(DataError, match=r"none of the 3 pictures in .* can be used; first: .*0.png: expected a plain"):
        load_image_folder(tmp_path, 64, 48)


def test_azimuths_are_known_for_all_or_not_at_all(tmp_path: Path) -> None:
    rendered(tmp_path, 2)
    write_metadata(tmp_path, [Row("0.png", "one", 270.0, None), Row("1.png", "one", -90.0, 0.0)])
    images = load_image_folder(tmp_path, 2, 2)
    np.testing.assert_allclose(images.azimuths, [-math.pi / 2] * 2)
    assert images.light_azimuths is None
    np.testing.assert_array_equal(images.instances, [0, 0])


def test_own_pictures_may_have_instances_and_azimuths(tmp_path: Path) -> None:
    for index in range(2):
        (tmp_path / f"{index}.png").write_bytes(transparent(cutout("car", 2, float(index))))
    (tmp_path / "metadata.csv").write_text("file_name,instance,azimuth_degrees\n0.png,mine,0\n1.png,mine,57.29578\n")
    images = load_image_folder(tmp_path, 64, 48)
    assert images.instance_names == ("mine",)
    np.testing.assert_allclose(images.azimuths, [0, 1], atol=1e-6)


def test_broken_pictures_are_counted_named_and_skipped(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    rendered(tmp_path, 5)
    buffer = io.BytesIO()
    Image.fromarray(np.random.default_rng(0).integers(0, 256, (64, 64, 3), np.uint8)).save(buffer, "PNG")
    (tmp_path / "1.png").write_bytes(buffer.getvalue()[:2000])
    (tmp_path / "3.png").write_bytes(b"")
    images = load_image_folder(tmp_path, 2, 2)
    assert images.names == ("0.png", "2.png", "4.png")
    np.testing.assert_array_equal(images.pictures[:, 0, 0, 0], [0, 20, 40])
    assert len(images.skipped) == 2
    (record,) = caplog.records
    assert record.message.startswith(f"skipped 2 of 5 pictures that cannot be read; first: {tmp_path / '1.png'}")


def test_metadata_and_folder_that_disagree_are_reported(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    rendered(tmp_path, 2)
    write_metadata(tmp_path, [Row("0.png", "a", None, None), Row("gone.png", "c", None, None)])
    assert load_image_folder(tmp_path, 2, 2).names == ("0.png",)
    absent, unnamed = (record.message for record in caplog.records)
    assert "metadata.csv names 1 pictures that are not there; first: gone.png" in absent
    assert "skipped 1 pictures that" in unnamed
    assert unnamed.endswith("does not name; first: 1.png")
    write_metadata(tmp_path, [Row("images/0.png", "a", None, None)])
    with pytest.raises(DataError, match=r"names none of the 2 pictures .* such as 0.png, found images/0.png"):
        load_image_folder(tmp_path, 2, 2)


def test_folders_without_pictures_are_refused(tmp_path: Path) -> None:
    with pytest.raises(DataError, match=r"expected a folder of pictures at .* found nothing"):
        load_image_folder(tmp_path / "nowhere", 2, 2)
    with pytest.raises(DataError, match=r"expected pictures .* found none"):
        load_image_folder(tmp_path, 2, 2)
    (tmp_path / "a.png").write_bytes(b"nothing")
    with pytest.raises(DataError, match=r"none of the 1 pictures .* can be used; first: .*a.png"):
        load_image_folder(tmp_path, 2, 2)
    with pytest.raises(DataError, match="found a file"):
        load_image_folder(tmp_path / "a.png", 2, 2)


def test_a_picture_of_too_many_pixels_is_not_decoded(tmp_path: Path) -> None:
    path = tmp_path / "bomb.png"
    Image.new("1", (10_000, 6_000)).save(path)
    for framed in (False, True):
        found = decode_picture(path, FRAME, framed)
        assert isinstance(found, Unusable)
        assert not found.refused
        assert "expected at most 50000000 pixels, found 10000 × 6000" in found.sentence


def test_an_image_set_cannot_be_changed(tmp_path: Path) -> None:
    images = load_image_folder(rendered(tmp_path, 1), 2, 2)
    with pytest.raises(dataclasses.FrozenInstanceError):
        images.names = ()  # type: ignore[misc]


def test_pictures_are_decoded_side_by_side_while_blas_s_own_threads_rest() -> None:
    def blas_threads(_: int) -> set[int]:
        return {library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"}

    with threadpool_limits(2, "blas"):
        with decoders() as pool:
            assert set.union(*pool.map(blas_threads, range(4))) == {1}
        assert blas_threads(0) == {2}
