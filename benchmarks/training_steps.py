"""Some steps of a training, here or in processes that torchrun has started; prints seconds a step and a stage, and how
long the networks' arithmetic would take at the machine's best."""

import json
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import torch
import tyro
from torch.utils.flop_counter import FlopCounterMode

from trainer import processes
from trainer.config import TrainConfig
from trainer.data.images import load_image_folder
from trainer.model.vae import Model
from trainer.presets import load_preset
from trainer.rendering import renderer
from trainer.training import step
from trainer.training.device import Choice, chosen_device
from trainer.training.intervals import Intervals
from trainer.training.loop import train
from trainer.training.step import number_format
from trainer.training.threads import limit_threads

# These are left out: memory is allocated, and caches are cold.
FIRST_STEPS = 20
EVERY = 10
STAGES: dict[str, tuple[Any, str]] = {
    "encoder, forward": (step, "encode_mixed"),
    "E-step": (renderer, "log_likelihood"),
    "likelihood and its gradient": (renderer, "expected_log_likelihood"),
}


def main(images: Path, preset: str, steps: int, threads: int, device: Choice = "cpu", record: bool = False) -> None:
    """`images` is a folder of pictures; `steps` are measured, after some that are not. Of steps that are recorded
    there are no stages; others wait for a GPU after each."""
    config = load_preset(preset)
    config = replace(config, optimiser=replace(config.optimiser, steps=FIRST_STEPS + steps))
    spent = dict.fromkeys(STAGES, 0.0)
    for name, (module, function) in STAGES.items() if not record else ():
        setattr(module, function, timed(getattr(module, function), spent, name))
    at: dict[int, tuple[float, dict[str, float]]] = {}

    def report(step: int, figures: dict[str, float]) -> None:
        at[step] = time.perf_counter(), dict(spent)

    with processes.joined(), TemporaryDirectory() as folder:
        limit_threads(threads)
        pictures = load_image_folder(images, config.width, config.height)
        intervals = Intervals(log=EVERY, preview=10**6, checkpoint=10**6)
        where = chosen_device(device)
        train(config, pictures, "car", Path(folder), intervals, False, report, {}, device=where, record=record)
        if processes.number() == 0:
            (begun, before), (ended, after) = at[FIRST_STEPS], at[FIRST_STEPS + steps - EVERY]
            counted = steps - EVERY  # The last step writes a preview before it reports.
            seconds = (ended - begun) / counted
            stages = {} if record else {name: (after[name] - before[name]) / counted for name in STAGES}
            if stages:
                stages["networks' backward, decoder, Adam"] = seconds - sum(stages.values())
            told = {"batch": config.optimiser.batch_size, "seconds": seconds, "stages": stages}
            print(json.dumps(told | roofline(config, where)))


def roofline(config: TrainConfig, device: torch.device) -> dict[str, float]:
    """Operations of the networks' products and convolutions in a step, forward and backward, of all processes together;
    how many a second the devices reach on a large product in the convolutions' number format; and their quotient."""
    convolutions = number_format(config.precision, device)
    model = Model(config.model, config.width, config.height).to(device)
    images = torch.zeros(config.optimiser.batch_size, 3, config.height, config.width, device=device)
    with FlopCounterMode(display=False) as counter:
        posterior = step.encode_mixed(model, images, convolutions)
        (sum(part.sum() for part in posterior[:5]) + model.decode(posterior.shape_mean).sum()).backward()
    operations, size = counter.get_total_flops(), 2048 if device.type == "cpu" else 8192
    factor = torch.randn(size, size, device=device).to(convolutions)
    seconds = []
    for _ in range(8):
        begun = time.perf_counter()
        float((factor @ factor)[0, 0])
        seconds.append(time.perf_counter() - begun)
    peak = processes.count() * 2 * size**3 / min(seconds)
    return {"network_operations": operations, "peak_operations_a_second": peak, "least_seconds": operations / peak}


def wait() -> None:
    """Until a GPU, if there is one, has done what it was told."""
    if torch.cuda.is_available():
        torch.cuda.synchronize()


def timed(function: Callable[..., Any], spent: dict[str, float], name: str) -> Callable[..., Any]:
    def measured(*arguments: Any, **options: Any) -> Any:
        wait()
        begun = time.perf_counter()
        try:
            return function(*arguments, **options)
        finally:
            wait()
            spent[name] += time.perf_counter() - begun

    return measured


if __name__ == "__main__":
    tyro.cli(main, prog="python -m benchmarks.training_steps")
