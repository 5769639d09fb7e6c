"""Ctrl-C as a question that a loop asks between two steps."""

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType


@contextmanager
def interruptible() -> Iterator[Callable[[], bool]]:
    """Turns the first Ctrl-C (or SIGTERM) into an answer of True; a second one stops at once.

    One that comes after the last question is not lost: whoever handled it before gets it at the end of the block.
    """
    asked = heard = False
    last = signal.SIGINT

    def ask(signum: int, frame: FrameType | None) -> None:
        nonlocal asked, last
        if asked:
            raise KeyboardInterrupt
        asked, last = True, signal.Signals(signum)

    def answer() -> bool:
        nonlocal heard
        heard = asked
        return asked

    before = {number: signal.signal(number, ask) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield answer
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        if asked and not heard:
            signal.raise_signal(last)
