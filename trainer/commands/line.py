"""The command line: which commands there are, and how their errors are told."""

import inspect
import logging
import sys
from importlib import import_module
from typing import Protocol, Self

import tyro

from trainer.errors import ChiaroError


class Command(Protocol):
    """The options of one command, and what it does with them."""

    @classmethod
    def default(cls, arguments: list[str]) -> Self:
        """What the options are where they are not given."""

    def run(self) -> None: ...


# Named here and loaded when they are called for: torch alone takes seconds, and not all of them need it.
COMMANDS = {
    "shapes": "ShapesCommand",
    "render": "RenderCommand",
    "train": "TrainCommand",
    "evaluate": "EvaluateCommand",
    "sample": "SampleCommand",
    "interpolate": "InterpolateCommand",
    "reconstruct": "ReconstructCommand",
    "table": "TableCommand",
    "stability": "StabilityCommand",
    "select": "SelectCommand",
    "frontier": "FrontierCommand",
}
"""Each command's class, in the module `trainer.commands.<name>`."""


def run(arguments: list[str]) -> int:
    """Runs one command; returns the exit status: 0, or 2 after an error that the user can mend."""
    logging.basicConfig(level=logging.WARNING, format="%(levelname)s: %(message)s")
    try:
        _parsed(arguments).run()
    except ChiaroError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    return 0


def _parsed(arguments: list[str]) -> Command:
    program = "python -m trainer"
    if arguments and arguments[0] in COMMANDS:
        name = arguments[0]
        default = _default(name, arguments)
        return tyro.cli(
            type(default),
            prog=f"{program} {name}",
            description=inspect.getdoc(default) or "",
            args=arguments[1:],
            default=default,
        )
    # A list of all commands is asked for, or has to be told.
    defaults = {name: _default(name, arguments) for name in COMMANDS}
    commands = tyro.extras.subcommand_type_from_defaults(
        defaults,
        {name: inspect.getdoc(default) or "" for name, default in defaults.items()},
        sort_subcommands=False,
    )
    command: Command = tyro.cli(
        commands,
        prog=program,
        description="Render pictures, train on them, judge what was learnt, look at samples, interpolate, reconstruct.",
        args=arguments,
        config=(tyro.conf.OmitSubcommandPrefixes,),
    )
    return command


def _default(name: str, arguments: list[str]) -> Command:
    command: type[Command] = getattr(import_module(f"trainer.commands.{name}"), COMMANDS[name])
    return command.default(arguments)
