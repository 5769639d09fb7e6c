"""From files to a model's pictures: the same object comes out the same, however it was photographed."""

import numpy as np
import pytest
from PIL import Image

import imaging.preparation
from imaging.cutout import cut_out
from imaging.errors import BackgroundError, PictureError
from imaging.framing import frame_of
from imaging.preparation import fit, prepare, prepare_all
from imaging.srgb import encode
from tests.imaging.conftest import Encoded
from tests.imaging.photographs import (
    Cutout,
    Plane,
    before,
    cutout,
    gradient,
    photographed,
    plain,
    shape,
    transparent,
    vignette,
)
from trainer.config import SceneConfig
from trainer.data.picture import draw

FRAME = frame_of(128, 96, 2.0, 30.0)
SMALL = frame_of(64, 48, 2.0, 30.0)
MANY = 10**7
CAR = cutout("car", 2, 0.9, 0.7)
CHAIR = cutout("chair", 3, 0.6, 0.8, (0.05, -0.03))


def difference(one: np.ndarray, other: np.ndarray) -> float:
    """Relative to all light."""
    return float(np.abs(one - other).sum() / other.sum())


@pytest.mark.parametrize("size", [0.25, 0.9], ids=["small in its picture", "large"])
@pytest.mark.parametrize("quality", [None, 90], ids=["PNG", "JPEG"])
def test_several_frames_share_work_and_get_what_each_gets_alone(
    size: float, quality: int | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    frames = [frame_of(64, 48, 2.0, 30.0, zoom) for zoom in (1.0, 1.1, 1.3, 1.31, 1.6)] + [FRAME]
    content = photographed(before(cutout("car", 2, 0.9, size), plain(1, 1, 1)), 0, quality)
    told = []
    monkeypatch.setattr(imaging.preparation, "cut_out", lambda picture: told.append(picture) or cut_out(picture))
    alone = [prepare(content, frame, MANY, True) for frame in frames]
    told_alone = len(told)
    for one, together in zip(alone, prepare_all(content, frames, MANY, True), strict=True):
        assert one.method == together.method == "background"
        np.testing.assert_array_equal(one.picture, together.picture)
    assert len(told) - told_alone < told_alone


@pytest.mark.parametrize("frame", [FRAME, SMALL], ids=["128 × 96", "64 × 48"])
@pytest.mark.parametrize("truth", [CAR, CHAIR], ids=["car", "chair"])
@pytest.mark.parametrize(
    ("background", "noise", "quality", "most"),
    [
        (plain(1, 1, 1), 0, None, 0.05),
        (plain(0, 0, 0), 0, None, 0.02),
        (plain(1, 1, 1), 2, 85, 0.08),
        (vignette(0.95), 2, 85, 0.08),
        (gradient((0.1, 0.2, 0.5), (0.05, 0.1, 0.2)), 4, 60, 0.15),
    ],
    ids=["white", "black", "JPEG", "a vignette", "a bad JPEG"],
)
def test_a_removed_background_is_as_good_as_transparency(
    truth: Cutout, frame: object, background: Plane, noise: float, quality: int | None, most: float
) -> None:
    told = prepare(transparent(truth), frame, MANY, False)  # type: ignore[arg-type]
    found = prepare(photographed(before(truth, background), noise, quality), frame, MANY, False)  # type: ignore[arg-type]
    assert (told.method, found.method) == ("alpha", "background")
    assert difference(found.picture, told.picture) < most


def test_the_object_stands_where_renderings_stand() -> None:
    """The frame's diagonal and drop, to a pixel, whatever the size and place in the photograph."""
    for size, place in ((0.5, (0.2, 0.1)), (0.95, (0.0, 0.0)), (0.3, (-0.3, -0.2))):
        prepared = prepare(transparent(cutout("car", 2, 0.9, size, place)), FRAME, MANY, False).picture
        rows, columns = np.nonzero(prepared.max(0) > 0.15)
        diagonal = np.hypot(np.ptp(rows) + 1, np.ptp(columns) + 1)
        assert diagonal == pytest.approx(FRAME.diagonal, abs=2)
        assert (rows.min() + rows.max() + 1) / 2 == pytest.approx(48 + FRAME.drop, abs=1)
        assert (columns.min() + columns.max() + 1) / 2 == pytest.approx(64, abs=1)


@pytest.mark.parametrize(("quality", "most"), [(None, 0.04), (90, 0.06)])
def test_a_small_object_keeps_the_detail_of_its_file(quality: int | None, most: float) -> None:
    """A quarter of the size, in a picture that is reduced by four for a first look."""
    large = np.zeros((3 * 480, 3 * 640, 3))
    small = cutout("car", 2, 0.9, 0.9)
    large[500:980, 700:1340] = small.colour
    coverage = np.zeros((3 * 480, 3 * 640))
    coverage[500:980, 700:1340] = small.coverage
    content = photographed(large + (1 - coverage[..., None]) * 0.9, 0, quality)
    expected = prepare(transparent(small), FRAME, MANY, False).picture
    assert difference(prepare(content, FRAME, MANY, False).picture, expected) < most


def test_turned_pictures_are_prepared_upright(encoded: Encoded) -> None:
    upright = Image.fromarray(encode(before(CAR, plain(1, 1, 1)).astype(np.float32)))
    exif = Image.Exif()
    exif[0x0112] = 6
    stored = upright.transpose(Image.Transpose.ROTATE_90)
    for file_format, most in (("PNG", 1e-6), ("JPEG", 0.03)):
        one = prepare(encoded(stored, file_format, exif=exif), FRAME, MANY, False).picture
        other = prepare(encoded(upright, file_format), FRAME, MANY, False).picture
        assert difference(one, other) < most


def test_every_kind_of_file_gives_the_same_picture(encoded: Encoded) -> None:
    grey = Image.fromarray(encode(before(CAR, plain(1, 1, 1)).astype(np.float32))).convert("L")
    expected = prepare(encoded(grey), FRAME, MANY, False).picture
    sixteen = Image.fromarray(np.asarray(grey).astype(np.uint16) * 257)
    kinds = {
        "colour": encoded(grey.convert("RGB")),
        "palette": encoded(grey.convert("P")),
        "sixteen bits": encoded(sixteen),
        "opaque": encoded(grey.convert("LA")),
        "BMP": encoded(grey, "BMP"),
        "GIF": encoded(grey, "GIF"),
        "WebP": encoded(grey.convert("RGB"), "WEBP", lossless=True),
    }
    for name, content in kinds.items():
        found = prepare(content, FRAME, MANY, False)
        assert found.method == "background", name
        np.testing.assert_allclose(found.picture, expected, atol=1e-3, err_msg=name)


def test_a_picture_that_is_hardly_transparent_has_a_background(encoded: Encoded) -> None:
    codes = encode(before(CAR, plain(1, 1, 1)).astype(np.float32))
    veiled = np.dstack((codes, np.full(codes.shape[:2], 200, np.uint8)))
    found = prepare(encoded(Image.fromarray(veiled, "RGBA")), FRAME, MANY, False)
    assert found.method == "background"
    expected = prepare(encoded(Image.fromarray(codes)), FRAME, MANY, False).picture
    assert difference(found.picture, expected) < 0.02


def test_shadows_that_are_transparent_do_not_count() -> None:
    """Half-transparent black beside the object: black on black, and not in the box."""
    shadow = np.zeros_like(CAR.coverage)
    shadow[380:420, 100:600] = 0.4
    shadowed = Cutout(CAR.colour, np.maximum(CAR.coverage, shadow))
    expected = prepare(transparent(CAR), FRAME, MANY, False).picture
    assert difference(prepare(transparent(shadowed), FRAME, MANY, False).picture, expected) < 0.02


@pytest.mark.parametrize("quality", [None, 90])
def test_renderings_in_the_frame_are_taken_as_they_are(quality: int | None) -> None:
    for seed in range(8):
        rendering = draw(shape("car", seed), 0.8 * seed, 0.0, SceneConfig())[0]
        content = photographed(rendering, 0, quality)
        for frame in (FRAME, SMALL):
            kept = prepare(content, frame, MANY, keep_framed=True)
            assert kept.method == "framed"
            np.testing.assert_array_equal(kept.picture, fit(content, frame, MANY).picture)
    np.testing.assert_allclose(
        fit(photographed(rendering), FRAME, MANY).picture, rendering.transpose(2, 0, 1), atol=0.005
    )


def test_other_pictures_on_black_are_framed() -> None:
    content = photographed(before(cutout("car", 2, 0.9, 0.4), plain(0, 0, 0)))
    assert prepare(content, FRAME, MANY, keep_framed=True).method == "background"


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (transparent(Cutout(0 * CAR.colour, 0 * CAR.coverage)), r"found 0\.0% that is not transparent"),
        (transparent(cutout("car", 2, 0.9, 3.0)), r"found 9\d\.\d% that is not transparent"),
        (photographed(np.pad(np.ones((12, 9, 3)), ((9, 9), (9, 9), (0, 0)))), "of at least 16 pixels across, found"),
        (photographed(plain(0.5, 0.5, 0.5)), "expected an object that stands out from its background"),
    ],
    ids=["all transparent", "all covered", "tiny", "all background"],
)
def test_pictures_without_an_object_are_refused(content: bytes, sentence: str) -> None:
    with pytest.raises(BackgroundError, match=sentence):
        prepare(content, FRAME, MANY, False)


def test_any_noise_is_prepared_or_refused() -> None:
    """Whatever the pixels: a finite picture of the right size, or a sentence."""
    rng = np.random.default_rng(0)
    prepared = 0
    sentences = []
    for trial in range(150):
        height, width = rng.integers(1, 200, 2)
        colours = rng.uniform(size=(rng.integers(1, 5), 3)) ** 2
        cells = rng.integers(0, len(colours), (rng.integers(1, 9), rng.integers(1, 9)))
        indices = np.ix_(np.arange(height) * len(cells) // height, np.arange(width) * len(cells[0]) // width)
        linear = colours[cells[indices]]
        if trial % 3:
            linear[: height // 4], linear[-height // 4 :] = colours[0], colours[0]
            linear[:, : width // 4], linear[:, -width // 4 :] = colours[0], colours[0]
        content = photographed(linear, rng.choice([0, 3]), rng.choice([None, 70]), trial)
        try:
            picture = prepare(content, SMALL, MANY, bool(trial % 2)).picture
        except PictureError as error:
            sentences.append(str(error))
            continue
        prepared += 1
        assert picture.shape == (3, 48, 64)
        assert np.isfinite(picture).all()
        assert picture.min() >= 0
        assert picture.max() <= 1
    assert prepared > 20
    assert all(sentence.startswith("expected ") and ", found " in sentence for sentence in sentences)
