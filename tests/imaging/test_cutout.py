"""Objects cut out of photographs whose truth is known: opacity, colour, holes, shadows, and honest refusals."""

import numpy as np
import pytest

from imaging.cutout import cut_out
from imaging.decoding import decode
from imaging.errors import BackgroundError
from tests.imaging.photographs import (
    HEIGHT,
    WIDTH,
    Cutout,
    Plane,
    before,
    boards,
    cutout,
    foliage,
    gradient,
    paper,
    photographed,
    plain,
    room,
    vignette,
    with_contact_shadow,
)

CAR = cutout("car", 2, 0.9, 0.75)
CHAIR = cutout("chair", 3, 0.6, 0.8, (0.05, -0.03))
GREY_CAR = cutout("car", 2, 0.9, 0.75, (-0.1, 0.05), grey=True)
DISC = np.hypot(*(np.mgrid[0:HEIGHT, 0:WIDTH] - np.array([240, 300])[:, None, None])).clip(100, 101)
BACKGROUNDS = {
    "white": plain(1, 1, 1),
    "black": plain(0, 0, 0),
    "blue": plain(0.1, 0.2, 0.6),
    "a gradient": gradient((0.8, 0.85, 0.9), (0.2, 0.25, 0.3)),
    "a vignette": vignette(0.9),
    "paper": paper((0.35, 0.2, 0.1)),
}


def compared(photograph: bytes, truth: Cutout) -> tuple[float, float]:
    """(intersection over union of the opacities, error of the colours relative to all there is)."""
    picture = decode(photograph, 256, 192, 10**7)
    found = cut_out(picture)
    assert found.opacity is not None
    side = picture.factor
    opacity = truth.coverage.reshape(HEIGHT // side, side, WIDTH // side, side).mean((1, 3))
    colour = truth.colour.reshape(HEIGHT // side, side, WIDTH // side, side, 3).mean((1, 3)).transpose(2, 0, 1)
    top, left = round(found.rows[0] / side), round(found.columns[0] / side)
    height, width = found.opacity.shape
    whole, alone = np.zeros_like(opacity), np.zeros_like(colour)
    whole[top : top + height, left : left + width] = found.opacity
    alone[:, top : top + height, left : left + width] = found.colour
    overlap = np.minimum(whole, opacity).sum() / np.maximum(whole, opacity).sum()
    return float(overlap), float(np.abs(alone - colour).sum() / colour.sum())


@pytest.mark.parametrize("name", BACKGROUNDS)
@pytest.mark.parametrize("truth", [CAR, CHAIR], ids=["car", "chair"])
def test_plain_backgrounds_are_removed(truth: Cutout, name: str) -> None:
    overlap, error = compared(photographed(before(truth, BACKGROUNDS[name])), truth)
    # The chair's seat is of one colour with some of these backgrounds along a part of its edge.
    assert overlap > (0.97 if truth is CAR else 0.92)
    assert error < 0.08


@pytest.mark.parametrize("name", BACKGROUNDS)
@pytest.mark.parametrize("truth", [CAR, CHAIR], ids=["car", "chair"])
def test_noise_and_compression_cost_little(truth: Cutout, name: str) -> None:
    overlap, error = compared(photographed(before(truth, BACKGROUNDS[name]), noise=3, quality=60), truth)
    assert overlap > (0.95 if truth is CAR else 0.85)
    assert error < 0.2


@pytest.mark.parametrize("background", [plain(1, 1, 1), vignette(0.95)], ids=["white", "a vignette"])
@pytest.mark.parametrize("truth", [CAR, GREY_CAR], ids=["car", "grey car"])
def test_a_soft_shadow_is_background(truth: Cutout, background: Plane) -> None:
    shadowed = before(truth, with_contact_shadow(background, truth))
    overlap, _ = compared(photographed(shadowed, noise=2, quality=85), truth)
    assert overlap > 0.85


def test_what_stands_on_something_is_no_shadow() -> None:
    """A grey slab on a dark foot, which fades into white at its left as softly as a shadow."""
    rows, columns = np.mgrid[0:HEIGHT, 0:WIDTH]
    slab = ((columns - 180) / 60).clip(0, 1) * (columns < 440) * (rows >= 120) * (rows < 330)
    foot = (np.abs(columns - 320) < 130) & (rows >= 330) & (rows < 370)
    coverage = np.maximum(slab, foot)
    truth = Cutout(np.where(foot, 0.05, 0.6 * slab)[..., None].repeat(3, -1), coverage)
    assert compared(photographed(before(truth, plain(1, 1, 1))), truth)[0] > 0.9


def disc(colour: tuple[float, float, float]) -> Cutout:
    """An even disc with a smooth edge."""
    coverage = 101 - DISC
    return Cutout(coverage[..., None] * colour, coverage)


def with_hole(whole: Cutout, radius: float, blur: float) -> Cutout:
    """The object with a round hole whose edge is `blur` pixels wide."""
    rows, columns = np.mgrid[0:HEIGHT, 0:WIDTH]
    rest = ((np.hypot(rows - 220, columns - 320) - radius) / blur + 0.5).clip(0, 1)
    return Cutout(whole.colour * rest[..., None], whole.coverage * rest)


def test_no_halo_of_the_old_background_stays() -> None:
    """A dark disc before white: all around, nothing is brighter than the disc."""
    dark = disc((0.1, 0.05, 0.02))
    found = cut_out(decode(photographed(before(dark, plain(1, 1, 1))), 256, 192, 10**7))
    assert found.colour[0].max() < 0.13
    assert found.opacity is not None
    assert found.opacity.sum() == pytest.approx(dark.coverage.sum() / found.factor**2, rel=0.01)


def test_a_hole_shows_the_background_and_a_highlight_does_not() -> None:
    red = disc((0.5, 0.1, 0.1))
    holed = with_hole(red, 20, 1)
    assert compared(photographed(before(holed, plain(1, 1, 1))), holed)[0] > 0.98
    # A highlight is in its middle as bright as the background, and fades towards its rim, over many pixels.
    shine = 1 - with_hole(Cutout(red.colour, np.ones((HEIGHT, WIDTH))), 45, 50).coverage
    shiny = Cutout(red.colour + shine[..., None] * (1 - red.colour), red.coverage)
    assert compared(photographed(before(shiny, plain(1, 1, 1))), shiny)[0] > 0.98


def test_a_part_of_nearly_the_backgrounds_colour_is_no_hole() -> None:
    """Within the tolerance for noise, but off by more than the noise throughout."""
    red = disc((0.5, 0.1, 0.1))
    inner = 1 - with_hole(Cutout(red.colour, np.ones((HEIGHT, WIDTH))), 40, 1).coverage
    spotted = Cutout(red.colour + inner[..., None] * (0.88 - red.colour), red.coverage)
    assert compared(photographed(before(spotted, plain(0.9, 0.9, 0.9))), spotted)[0] > 0.98


def test_narrow_gaps_between_slats_are_holes() -> None:
    """Gaps of five pixels of the file, two and a half of those that are worked on."""
    slats = np.zeros((HEIGHT, WIDTH))
    slats[100:380, 200:440] = 1
    slats[130:350, 230:410] = np.arange(180) % 20 >= 5
    frame = Cutout(slats[..., None] * (0.3, 0.2, 0.1), slats)
    overlap, error = compared(photographed(before(frame, plain(0.9, 0.9, 0.9))), frame)
    assert overlap > 0.95
    assert error < 0.1


def test_a_thin_line_around_the_picture_is_no_object() -> None:
    framed = before(CAR, plain(1, 1, 1))
    framed[:4] = framed[-4:] = framed[:, :4] = framed[:, -4:] = 0
    assert compared(photographed(framed), CAR)[0] > 0.96


def test_an_object_may_touch_the_border() -> None:
    touching = cutout("car", 2, 0.9, 0.75, (-0.3, 0.0))
    assert touching.coverage[:, 0].any()
    assert compared(photographed(before(touching, plain(0.9, 0.9, 0.9)), 2, 85), touching)[0] > 0.95


def test_dust_is_no_object() -> None:
    dusty = np.array(before(CAR, plain(1, 1, 1)))
    rng = np.random.default_rng(0)
    for row, column in zip(rng.integers(5, HEIGHT - 9, 40), rng.integers(5, WIDTH - 9, 40), strict=True):
        dusty[row : row + 4, column : column + 4] *= 0.5
    assert compared(photographed(dusty), CAR)[0] > 0.96


@pytest.mark.parametrize("make", [boards, room, foliage])
@pytest.mark.parametrize("truth", [CAR, CHAIR], ids=["car", "chair"])
def test_busy_backgrounds_are_refused(truth: Cutout, make: object) -> None:
    for seed in range(3):
        busy = before(truth, make(seed))  # type: ignore[operator]
        for quality in (None, 60):
            with pytest.raises(BackgroundError, match="expected a plain background, found"):
                cut_out(decode(photographed(busy, 2, quality), 256, 192, 10**7))


@pytest.mark.parametrize(
    ("linear", "sentence"),
    [
        (plain(0.7, 0.7, 0.7), r"stands out from its background, found one on 0\.0% of the picture"),
        (before(cutout("car", 2, 0.9, 0.08), plain(1, 1, 1)), r"found one on 0\.\d% of the picture"),
        (before(cutout("car", 2, 0.9, 2.4), plain(1, 1, 1)), "expected "),
        (before(disc((0.5, 0.5, 0.5)), plain(0.51, 0.51, 0.51)), "expected an object that stands out"),
        (before(disc((0.5, 0.5, 0.5)), plain(0.515, 0.515, 0.515)), "expected an object that stands out"),
        (
            before(disc((0.5, 0.5, 0.5)), plain(0.535, 0.535, 0.535)),
            r"nearly the same colour along \d+% of its outline",
        ),
    ],
    ids=["nothing", "a speck", "cut off all around", "of its background's colour", "of nearly it", "of about it"],
)
def test_what_cannot_be_told_is_refused(linear: Plane, sentence: str) -> None:
    with pytest.raises(BackgroundError, match=sentence):
        cut_out(decode(photographed(linear), 256, 192, 10**7))


def test_an_object_that_fills_the_picture_is_refused() -> None:
    rows, columns = np.mgrid[0:HEIGHT, 0:WIDTH]
    inside = (np.abs(rows - 240) < 232) & (np.abs(columns - 320) < 312)
    linear = np.where(inside[..., None], (0.5, 0.2, 0.1), (1.0, 1.0, 1.0))
    with pytest.raises(BackgroundError, match="expected a plain background"):
        cut_out(decode(photographed(linear), 256, 192, 10**7))


@pytest.mark.parametrize("size", [(1, 1), (1, 400), (7, 300), (2, 2), (3, 9)])
def test_strips_and_crumbs_are_refused(size: tuple[int, int]) -> None:
    noise = np.random.default_rng(0).uniform(size=(*size, 3))
    with pytest.raises(BackgroundError, match="expected a"):
        cut_out(decode(photographed(noise), 256, 192, 10**7))


@pytest.mark.parametrize("size", [(61, 83), (200, 301), (479, 641), (97, 130)])
def test_sizes_that_nothing_divides(size: tuple[int, int]) -> None:
    """A disc stays where it was, to a pixel, and as large."""
    rows, columns = np.mgrid[0 : size[0], 0 : size[1]]
    radius = min(size) / 3.3
    coverage = (radius + 0.5 - np.hypot(rows - size[0] * 0.45, columns - size[1] * 0.55)).clip(0, 1)
    linear = before(Cutout(coverage[..., None] * (0.4, 0.1, 0.1), coverage), np.ones(3))
    found = cut_out(decode(photographed(linear), 64, 48, 10**7))
    assert found.opacity is not None
    widths, heights = np.diff(found.columns), np.diff(found.rows)
    areas = np.outer(heights, widths) * found.opacity
    assert areas.sum() == pytest.approx(np.pi * radius**2, rel=0.03)
    middle = (areas.sum(0) * (found.columns[:-1] + widths / 2)).sum() / areas.sum()
    assert middle == pytest.approx(size[1] * 0.55 + 0.5, abs=0.5)
