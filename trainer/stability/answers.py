"""What a model answers to pictures, one by one, and how right and how sure it is."""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray

from trainer.data.picture import rotation_about_y
from trainer.evaluation.metrics import (
    CORRECT_WITHIN,
    accuracy,
    azimuth_error,
    bootstrap,
    iou,
    median_error,
    symmetric_azimuth_error,
)
from trainer.evaluation.pictures import Pictures, Validation, threads
from trainer.evaluation.protocol import fit_alignment
from trainer.evaluation.subject import Prediction, Subject, predict
from trainer.evaluation.voxels import occupy
from trainer.stability.explanation import (
    MOST_STRANGE,
    Errors,
    Yardstick,
    errors_of,
    out_of_class_scores,
    rerender_errors,
)
from trainer.stability.uploads import upload

SURE = 0.9
"""A confidence from which on an answer counts as sure of itself."""
_ROUNDS = 300


class Examinee(NamedTuple):
    """A model, and what was fitted for it on validation pictures."""

    name: str
    subject: Subject
    offset: float
    """Azimuth offset of its canonical frame, radians: true ≈ predicted + offset."""
    yardstick: Yardstick


class Answers(NamedTuple):
    """To N pictures, as a model gives them."""

    overlaps: Float[ndarray, "N"]
    """IoU at 32³; not a number where nobody looked."""
    errors: Float[ndarray, "N"]
    """Of the azimuth, up to the object's own symmetry, radians."""
    plain_errors: Float[ndarray, "N"]
    """Of the azimuth, radians."""
    confidences: Float[ndarray, "N"]
    """How probable the most probable bin of the azimuth is said to be."""
    rerender_errors: Float[ndarray, "N"]
    scores: Float[ndarray, "N"]
    """Out of class."""
    objects: Float[ndarray, "N"]

    @property
    def wrong(self) -> Bool[ndarray, "N"]:
        """Azimuths that are more than 30° off."""
        return np.asarray(self.errors > CORRECT_WITHIN)

    @property
    def refused(self) -> Bool[ndarray, "N"]:
        """What the service would not answer."""
        return np.asarray(self.scores > MOST_STRANGE)

    @property
    def deceptive(self) -> Bool[ndarray, "N"]:
        """Wrong, sure, and not refused: what nobody would notice."""
        return np.asarray(self.wrong & (self.confidences >= SURE) & ~self.refused)

    def of(self, chosen: Bool[ndarray, "N"]) -> "Answers":
        """Some of them."""
        return Answers(*(values[chosen] for values in self))


def examinee(name: str, subject: Subject, validation: Validation, held_out: Yardstick | None) -> Examinee:
    """The model with its offset; where its bundle does not say what held-out pictures cost it, they are measured.

    Raises CheckpointError where it answers no numbers, DataError where it explains all pictures equally well.
    """
    return Examinee(
        name, subject, fit_alignment(subject, validation).offset, held_out or _measured(subject, validation)
    )


def _measured(subject: Subject, validation: Validation) -> Yardstick:
    codes = validation.codes
    sent = upload(codes, subject.scene, keep_framed=False)
    return Yardstick(
        errors_of(rerender_errors(subject, predict(subject, codes), codes)),
        errors_of(rerender_errors(subject, predict(subject, sent.codes), sent.codes, sent.fitted)),
    )


def answers(examined: Examinee, pictures: Pictures, shapes: bool = True) -> Answers:
    """What a model says of pictures, as the judge compares it; without `shapes`, which take the most time, no IoU."""
    subject, prediction = examined.subject, predict(examined.subject, pictures.codes)
    errors = rerender_errors(subject, prediction, pictures.codes)
    return _compared(examined, pictures, prediction, errors, examined.yardstick.framed, shapes)


def answers_to_uploads(examined: Examinee, pictures: Pictures) -> Answers:
    """The same for pictures that are sent, of those that are not refused at once; without IoU."""
    subject, sent = examined.subject, upload(pictures.codes, examined.subject.scene)
    if len(sent.numbers) == 0:
        return Answers(*(np.empty(0) for _ in Answers._fields))
    kept = replace(
        pictures, codes=sent.codes, azimuths=pictures.azimuths[sent.numbers], objects=pictures.objects[sent.numbers]
    )
    prediction = predict(subject, sent.codes)
    errors = rerender_errors(subject, prediction, sent.codes, sent.fitted)
    told = _compared(examined, kept, prediction, errors, examined.yardstick.framed, shapes=False)
    fitted_scores = out_of_class_scores(errors, examined.yardstick.fitted)
    return told._replace(scores=np.where(sent.fitted, fitted_scores, told.scores))


def _compared(
    examined: Examinee,
    pictures: Pictures,
    prediction: Prediction,
    rerendered: Float[ndarray, "N"],
    held_out: Errors,
    shapes: bool,
) -> Answers:
    azimuths = prediction.azimuths.double().numpy() + examined.offset
    orders = np.array([truth.order for truth in pictures.truth])[pictures.objects]
    overlaps = _overlaps(examined, pictures, prediction) if shapes else np.full(len(azimuths), np.nan)
    return Answers(
        overlaps,
        symmetric_azimuth_error(azimuths, pictures.azimuths, orders),
        azimuth_error(azimuths, pictures.azimuths),
        prediction.probabilities.amax(1).double().numpy(),
        rerendered,
        out_of_class_scores(rerendered, held_out),
        pictures.objects,
    )


def _overlaps(examined: Examinee, pictures: Pictures, prediction: Prediction) -> Float[ndarray, "N"]:
    turned = prediction.vertices.double().numpy() @ rotation_about_y(-examined.offset).T
    faces = examined.subject.faces.numpy()

    def overlap(number: int) -> float:
        return float(iou(occupy(turned[number], faces).full, pictures.truth[pictures.objects[number]].voxels))

    with ThreadPoolExecutor(threads()) as pool:
        return np.array(list(pool.map(overlap, range(len(turned)))))


def figures_of(told: Answers) -> dict[str, Any]:
    """Figures of all answers together, by the names of the judge's where it has them; lists are 95 % intervals."""
    overlap = bootstrap(told.overlaps, told.objects, np.random.default_rng(0), rounds=_ROUNDS)
    right = bootstrap(told.errors, told.objects, np.random.default_rng(0), accuracy, _ROUNDS)
    return {
        "pictures": len(told.errors),
        "iou": _rounded(overlap.value),
        "iou_interval": [_rounded(overlap.low), _rounded(overlap.high)],
        "symmetric_azimuth_accuracy": _rounded(right.value),
        "symmetric_azimuth_accuracy_interval": [_rounded(right.low), _rounded(right.high)],
        "azimuth_accuracy": _rounded(accuracy(told.plain_errors)),
        "symmetric_azimuth_error_degrees": _rounded(np.degrees(median_error(told.errors))),
        "azimuth_error_degrees": _rounded(np.degrees(median_error(told.plain_errors))),
        **trust_of(told),
        "sure_of_wrong": _share(told.confidences[told.wrong] >= SURE),
        "deceptive": _share(told.deceptive),
    }


def trust_of(told: Answers) -> dict[str, Any]:
    """What somebody sees who does not know the truth."""
    return {
        "confidence": _mean(told.confidences),
        "rerender_error": _mean(told.rerender_errors),
        "out_of_class_score": _rounded(float(np.median(told.scores))) if len(told.scores) else None,
        "refused": _share(told.refused),
        "sure": _share((told.confidences >= SURE) & ~told.refused),
    }


def upload_figures(told: Answers, count: int) -> dict[str, Any]:
    """Of `count` pictures that were sent, shares of all of them: what was refused at once, by its score, and answered
    right and wrong."""
    answered = ~told.refused
    return {
        "refused_at_once": _rounded(1 - len(told.errors) / count),
        "refused": _rounded(float(told.refused.sum()) / count),
        "right": _rounded(float((answered & ~told.wrong).sum()) / count),
        "wrong": _rounded(float((answered & told.wrong).sum()) / count),
        "deceptive": _rounded(float(told.deceptive.sum()) / count),
        "confidence": _mean(told.confidences[answered]),
    }


def joined(parts: Sequence[Answers]) -> Answers:
    """All answers one after the other."""
    return Answers(*(np.concatenate(values) for values in zip(*parts, strict=True)))


def _share(of: Bool[ndarray, "N"]) -> float | None:
    return _mean(of.astype(float))


def _mean(values: Float[ndarray, "N"]) -> float | None:
    return _rounded(float(np.mean(values))) if len(values) else None


def _rounded(value: float) -> float:
    # Adding nothing makes 0 of -0.
    return round(float(value), 4) + 0.0
