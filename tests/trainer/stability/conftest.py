"""A few cars, a model that nobody has trained, and what it says of them."""

from dataclasses import replace

import numpy as np
import pytest

from tests.trainer.new_model import HEIGHT, WIDTH, new_model
from trainer.config import SceneConfig, TrainConfig
from trainer.evaluation.pictures import Truth, Validation
from trainer.evaluation.subject import Subject, from_checkpoint
from trainer.stability.answers import Examinee, examinee
from trainer.stability.conditions import Sitting
from trainer.stability.objects import TEST_SEED, VALIDATION_SEED, exhibits, photographs, truths
from trainer.training.checkpoint import Checkpoint

SCENE = SceneConfig(WIDTH, HEIGHT)


@pytest.fixture(scope="session")
def subject() -> Subject:
    model = new_model()
    config = replace(TrainConfig(), width=WIDTH, height=HEIGHT, model=model.config)
    return from_checkpoint(Checkpoint(config, SCENE, "car", 1, model, {}, {"seconds": 1.0}))


@pytest.fixture(scope="session")
def sitting() -> Sitting:
    shown = tuple(exhibits("car", TEST_SEED, 6))
    return Sitting(shown, SCENE, photographs(shown, SCENE))


@pytest.fixture(scope="session")
def truth(sitting: Sitting) -> tuple[Truth, ...]:
    return truths(sitting.shown)


@pytest.fixture(scope="session")
def validation() -> Validation:
    shown = exhibits("car", VALIDATION_SEED, 12)
    azimuths = np.array([exhibit.azimuths[0] for exhibit in shown])
    return Validation(photographs(shown, SCENE), azimuths, np.arange(len(shown)), None)


@pytest.fixture(scope="session")
def examined(subject: Subject, validation: Validation) -> Examinee:
    return examinee("new", subject, validation, None)
