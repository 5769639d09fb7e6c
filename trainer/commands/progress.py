"""The line that shows how far a training has come."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn


@contextmanager
def progress_of(what: str, steps: int, console: Console) -> Iterator[Callable[[int, dict[str, float]], None]]:
    """To be called with the number and the figures of each logged step out of so many."""
    columns = (
        TextColumn(what),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.fields[rate]} steps/s"),
        TimeRemainingColumn(),
        TextColumn("loss {task.fields[loss]}"),
    )
    with Progress(*columns, console=console) as progress:
        bar = progress.add_task(what, total=steps, rate="…", loss="…")

        def report(step: int, figures: dict[str, float]) -> None:
            speed = progress.tasks[bar].speed
            rate = "…" if speed is None else f"{speed:.1f}"
            progress.update(bar, completed=step, rate=rate, loss=f"{figures['loss']:.1f}")

        yield report
