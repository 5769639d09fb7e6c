"""The command line: which commands there are, and how their errors are told."""

import inspect
import logging
import sys

import tyro

from trainer.commands.evaluate import EvaluateCommand
from trainer.commands.render import RenderCommand
from trainer.commands.sample import SampleCommand
from trainer.commands.train import TrainCommand
from trainer.errors import ChiaroError

Command = RenderCommand | TrainCommand | EvaluateCommand | SampleCommand


def run(arguments: list[str]) -> int:
    """Runs one command; returns the exit status: 0, or 2 after an error that the user can mend."""
    logging.basicConfig(level=logging.WARNING, format="%(levelname)s: %(message)s")
    try:
        defaults: dict[str, Command] = {
            "render": RenderCommand.default(arguments),
            "train": TrainCommand.default(arguments),
            "evaluate": EvaluateCommand.default(arguments),
            "sample": SampleCommand.default(arguments),
        }
        command: Command = tyro.cli(
            tyro.extras.subcommand_type_from_defaults(
                defaults,
                {name: inspect.getdoc(command) or "" for name, command in defaults.items()},
                sort_subcommands=False,
            ),
            prog="python -m trainer",
            description="Render pictures, train on them, judge what was learnt, look at samples.",
            args=arguments,
            config=(tyro.conf.OmitSubcommandPrefixes,),
        )
        command.run()
    except ChiaroError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    return 0
