"""The line that shows how far a training has come, and one that says what holds it up."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import torch
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from trainer.training.contention import Contention


@contextmanager
def progress_of(
    what: str, steps: int, console: Console, device: torch.device
) -> Iterator[Callable[[int, dict[str, float]], None]]:
    """To be called with the number and the figures of each logged step out of so many. Says, too, where other programs
    want the cores, if these are the `device` that is computed on."""
    columns = (
        TextColumn(what),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.fields[rate]} steps/s"),
        TimeRemainingColumn(),
        TextColumn("loss {task.fields[loss]}"),
    )
    with Progress(*columns, console=console) as progress:
        contention = Contention() if device.type == "cpu" else None
        bar = progress.add_task(what, total=steps, rate="…", loss="…")

        def report(step: int, figures: dict[str, float]) -> None:
            speed = progress.tasks[bar].speed
            rate = "…" if speed is None else f"{speed:.1f}"
            progress.update(bar, completed=step, rate=rate, loss=f"{figures['loss']:.1f}")
            if contention and (sentence := contention.told()):
                console.print(sentence, markup=False)

        yield report
