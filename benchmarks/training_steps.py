"""Some steps of a training, here or in processes that torchrun has started; prints seconds a step and a stage."""

import json
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import tyro

from trainer import processes
from trainer.data.images import load_image_folder
from trainer.presets import load_preset
from trainer.rendering import renderer
from trainer.training import step
from trainer.training.intervals import Intervals
from trainer.training.loop import train
from trainer.training.threads import limit_threads

# These are left out: memory is allocated, and caches are cold.
FIRST_STEPS = 20
EVERY = 10
STAGES: dict[str, tuple[Any, str]] = {
    "encoder, forward": (step, "encode_mixed"),
    "E-step": (renderer, "log_likelihood"),
    "likelihood and its gradient": (renderer, "expected_log_likelihood"),
}


def main(images: Path, preset: str, steps: int, threads: int) -> None:
    """`images` is a folder of pictures; `steps` are measured, after some that are not."""
    config = load_preset(preset)
    config = replace(config, optimiser=replace(config.optimiser, steps=FIRST_STEPS + steps))
    spent = dict.fromkeys(STAGES, 0.0)
    for name, (module, function) in STAGES.items():
        setattr(module, function, timed(getattr(module, function), spent, name))
    at: dict[int, tuple[float, dict[str, float]]] = {}

    def report(step: int, figures: dict[str, float]) -> None:
        at[step] = time.perf_counter(), dict(spent)

    with processes.joined(), TemporaryDirectory() as folder:
        limit_threads(threads)
        pictures = load_image_folder(images, config.width, config.height)
        intervals = Intervals(log=EVERY, preview=10**6, checkpoint=10**6)
        train(config, pictures, "car", Path(folder), intervals, False, report, {})
        if processes.number() == 0:
            (begun, before), (ended, after) = at[FIRST_STEPS], at[FIRST_STEPS + steps - EVERY]
            counted = steps - EVERY  # The last step writes a preview before it reports.
            seconds = (ended - begun) / counted
            stages = {name: (after[name] - before[name]) / counted for name in STAGES}
            stages["networks' backward, decoder, Adam"] = seconds - sum(stages.values())
            print(json.dumps({"batch": config.optimiser.batch_size, "seconds": seconds, "stages": stages}))


def timed(function: Callable[..., Any], spent: dict[str, float], name: str) -> Callable[..., Any]:
    def measured(*arguments: Any, **options: Any) -> Any:
        begun = time.perf_counter()
        try:
            return function(*arguments, **options)
        finally:
            spent[name] += time.perf_counter() - begun

    return measured


if __name__ == "__main__":
    tyro.cli(main, prog="python -m benchmarks.training_steps")
