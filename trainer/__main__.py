"""`python -m trainer`: render pictures, train on them, judge what was learnt, look at samples."""

import sys


def main(arguments: list[str]) -> int:
    """Runs one command; returns the exit status: 0, 2 after an error that the user can mend, 130 after Ctrl-C."""
    try:
        # Here and not above: torch takes seconds to load, and Ctrl-C is to be answered meanwhile, too.
        from trainer.commands.line import run  # noqa: PLC0415

        return run(arguments)
    except (KeyboardInterrupt, SystemError) as error:
        if not _is_ctrl_c(error):
            raise
        print("interrupted; finished files are kept, and nothing is half-written", file=sys.stderr)
        return 130


def _is_ctrl_c(error: BaseException | None) -> bool:
    """Also where Ctrl-C comes while a compiled kernel hands over its result: Python then raises SystemError from it."""
    while isinstance(error, SystemError):
        error = error.__cause__
    return isinstance(error, KeyboardInterrupt)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
