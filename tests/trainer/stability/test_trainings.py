"""Trainings under adverse conditions end in figures or in a sentence, and are not done twice."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.random import Generator

from trainer.config import ModelConfig, TrainConfig
from trainer.data.images import ImageSet
from trainer.stability import trainings
from trainer.stability.budget import BUDGETS, Budget
from trainer.stability.regimes import REGIMES, Regime, Stock, chosen
from trainer.stability.trainings import found_trainings, recipe_for, run_trainings
from trainer.training.checkpoint import Checkpoint

USUAL = next(regime for regime in REGIMES if regime.name == "batch-4")


def two_pictures(stock: Stock, rng: Generator) -> ImageSet:
    """Of which half are held out."""
    return chosen(stock.cars, np.arange(2))


@pytest.fixture
def budget() -> Budget:
    return replace(BUDGETS["small"], training_pictures=40, steps=4, judged_objects=8)


@pytest.fixture
def recipe(budget: Budget) -> TrainConfig:
    model = ModelConfig(latent=3, segments=2, encoder_channels=(4, 4, 4, 4, 4, 8))
    return replace(recipe_for(budget), width=32, height=24, model=model)


def test_a_training_ends_in_figures_and_a_failure_in_its_sentence(
    tmp_path: Path, budget: Budget, recipe: TrainConfig, monkeypatch: pytest.MonkeyPatch
) -> None:
    lost = Regime("batch-8", "two pictures", lambda config: replace(config, validation_share=0.5), two_pictures)
    said = list[str]()
    run_trainings(tmp_path, budget, [USUAL, lost], recipe, said.append)
    assert said == ["batches of 4, seed 0", "two pictures, seed 0"]
    found = found_trainings(tmp_path)
    assert list(found) == ["batch-8", "batch-4"]
    (done,), (failed,) = found["batch-4"]["seeds"], found["batch-8"]["seeds"]
    assert (done["finished"], done["step"], done["skipped_steps"], done["batch_size"]) == (True, 4, 0, 4)
    assert 0 <= done["figures"]["iou"] <= 1
    assert done["rerender_error"] > 0
    assert (failed["finished"], failed["figures"]) == (False, None)
    assert failed["sentence"].startswith("Expected at least 2 pictures to train on, found 1.")

    def refuse(*arguments: object) -> None:
        raise AssertionError("trained again")

    monkeypatch.setattr(trainings, "train", refuse)
    run_trainings(tmp_path, budget, [USUAL, lost], recipe, said.append)
    assert len(said) == 2


def test_an_interrupted_training_goes_on(
    tmp_path: Path, budget: Budget, recipe: TrainConfig, monkeypatch: pytest.MonkeyPatch
) -> None:
    halves, whole = list[bool](), trainings.train

    def halved(config: TrainConfig, *arguments: Any) -> Checkpoint:
        halves.append(arguments[4])
        if len(halves) == 1:
            config = replace(config, optimiser=replace(config.optimiser, steps=2))
        return whole(config, *arguments)

    monkeypatch.setattr(trainings, "train", halved)
    with pytest.raises(KeyboardInterrupt):
        run_trainings(tmp_path, budget, [USUAL], recipe, lambda sentence: None)
    assert found_trainings(tmp_path) == {}
    run_trainings(tmp_path, budget, [USUAL], recipe, lambda sentence: None)
    assert halves == [False, True]
    lines = (tmp_path / "trainings" / "batch-4" / "seed-0" / "metrics.jsonl").read_text().splitlines()
    assert [json.loads(line)["step"] for line in lines] == [1, 2, 3, 4]
