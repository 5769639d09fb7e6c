"""`python -m trainer`: render pictures, train on them, judge what was learnt, look at samples."""

import logging
import sys

import tyro

from trainer.commands import evaluate, render, sample, train
from trainer.errors import ChiaroError

COMMANDS = {
    "render": render.RenderCommand,
    "train": train.TrainCommand,
    "evaluate": evaluate.EvaluateCommand,
    "sample": sample.SampleCommand,
}


def main(arguments: list[str]) -> int:
    """Runs one command; returns the exit status: 0, or 2 after an error that the user can mend."""
    logging.basicConfig(level=logging.WARNING, format="%(levelname)s: %(message)s")
    try:
        defaults = {name: command.default(arguments) for name, command in COMMANDS.items()}
        command = tyro.cli(
            tyro.extras.subcommand_type_from_defaults(defaults, sort_subcommands=False),
            prog="python -m trainer",
            description=__doc__,
            args=arguments,
            config=(tyro.conf.OmitSubcommandPrefixes,),
        )
        command.run()
    except ChiaroError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
