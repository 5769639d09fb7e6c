"""What docs/training.md recommends for kinds of objects are options of a training that could begin."""

import re
import shlex
from pathlib import Path

import pytest
import tyro

from trainer.commands.train import TrainCommand
from trainer.training.checks import check_settings

PAGE = (Path(__file__).parents[2] / "docs" / "training.md").read_text()


def _recommended(training: str) -> list[str]:
    """The options in the table of the first or a second training."""
    (section,) = re.findall(rf"^### In {training} training\n(.*?)^##", PAGE, re.DOTALL | re.MULTILINE)
    table = "\n".join(line for line in section.splitlines() if line.startswith("|"))
    return re.findall(r"`(--[^`]+)`", table)


@pytest.mark.parametrize("training", ["the first", "a second"])
def test_what_is_recommended_is_a_training_that_could_begin(training: str) -> None:
    recommended = _recommended(training)
    assert len(recommended) >= 7
    for options in recommended:
        arguments = ["train", "--images", "pictures", "--run", "runs/mine", *shlex.split(options)]
        if training == "a second":
            arguments += ["--poses-of", "runs/first"]
            if "--preset" not in arguments:
                arguments += ["--preset", "told"]
        command = tyro.cli(TrainCommand, args=arguments[1:], default=TrainCommand.default(arguments))
        check_settings(command.config)
