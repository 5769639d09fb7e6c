"""The re-render error and the score are those of the service, which computes them without torch."""

from pathlib import Path

import numpy as np
import pytest

from service.bundle import read_bundle
from service.explanation import MOST_STRANGE as SERVICE_MOST
from service.explanation import out_of_class_score, unexplained
from service.image import read_picture
from service.inference import decode, encode, load_engine
from service.manifest import Errors as ServiceErrors
from service.manifest import HeldOut
from trainer.data.png import encode_png
from trainer.errors import DataError
from trainer.evaluation.bundle import from_bundle
from trainer.evaluation.subject import predict
from trainer.stability.explanation import MOST_STRANGE, Errors, errors_of, out_of_class_scores, rerender_errors
from trainer.stability.models import contestants
from trainer.stability.objects import TEST_SEED, exhibits, photographs
from trainer.stability.uploads import upload

MODEL = Path(__file__).parents[3] / "models" / "car"


@pytest.mark.parametrize("category", ["car", "chair"])
@pytest.mark.parametrize("moved", [False, True])
def test_errors_are_those_of_the_service(moved: bool, category: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """It takes a few samples of each square, and here contours are exact: single chairs with thin legs cost it a fifth
    more or less. With many samples the errors are the same to a few percent."""
    bundle = MODEL.with_name(category)
    subject, engine = from_bundle(bundle), load_engine(read_bundle(bundle))
    codes = photographs(exhibits(category, TEST_SEED, 8), subject.scene)
    if moved:
        codes = np.roll(codes, 9 * subject.scene.width // 64, 3)
    sent, scene = upload(codes, subject.scene), subject.scene
    assert len(sent.numbers) > len(codes) / 2
    if scene.zoom == 1:
        assert sent.fitted.all() == sent.fitted.any() == moved
    # A model that looks closely sees some come near to the border: these are cut out although nobody has moved them.
    assert sent.fitted.all() == moved
    found = rerender_errors(subject, predict(subject, sent.codes), sent.codes, sent.fitted)
    own, exact = [], []
    for number, fitted in zip(sent.numbers, sent.fitted, strict=True):
        large = codes[number].repeat(4, 1).repeat(4, 2).transpose(1, 2, 0)
        prepared = read_picture(
            encode_png(large),
            scene.width,
            scene.height,
            10**8,
            scene.camera.distance,
            scene.camera.field_of_view_degrees,
        )
        assert (prepared.method != "framed") == fitted
        posterior = encode(engine, prepared.picture)
        surface = decode(engine, posterior.shape_mean)
        own.append(unexplained(engine, prepared, posterior, surface))
        with monkeypatch.context() as closer:
            closer.setattr("service.explanation._SAMPLES", 16)
            exact.append(unexplained(engine, prepared, posterior, surface))
    assert found == pytest.approx(own, rel=0.25)
    assert found.mean() == pytest.approx(np.mean(own), rel=0.05)
    assert found == pytest.approx(exact, rel=0.12)
    assert found.mean() == pytest.approx(np.mean(exact), rel=0.03)


def test_scores_are_those_of_the_service() -> None:
    errors = np.array([0.0, 0.04, 0.08, 0.12, 0.28])
    held_out = HeldOut(pictures=99, framed=ServiceErrors(0.04, 0.12), fitted=None)
    expected = [out_of_class_score(held_out, "framed", float(error)) for error in errors]
    assert out_of_class_scores(errors, Errors(0.04, 0.12)) == pytest.approx(expected)
    assert MOST_STRANGE == SERVICE_MOST


def test_a_bundle_says_what_held_out_pictures_cost_it() -> None:
    (car,) = contestants([MODEL], [])
    told = read_bundle(MODEL).manifest.held_out
    assert car.held_out is not None
    assert told is not None
    assert told.framed is not None
    assert tuple(car.held_out.framed) == (told.framed.median, told.framed.high)


def test_errors_that_are_all_alike_are_refused() -> None:
    assert errors_of(np.linspace(0, 1, 101)) == pytest.approx((0.5, 0.95))
    with pytest.raises(DataError, match=r"explained unequally well, found 5 with an error of 0\.3 each"):
        errors_of(np.full(5, 0.3))
