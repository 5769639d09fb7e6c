"""What an answer costs, measured once for each architecture: weights do not change it."""

import json
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import torch
from torch.utils.flop_counter import FlopCounterMode

from trainer.config import ModelConfig
from trainer.data.writing import write_bytes
from trainer.errors import DataError
from trainer.frontier.answering import latencies_ms
from trainer.frontier.bundles import megabytes
from trainer.frontier.plan import BundlePrecision, Point
from trainer.mapping import from_mapping, to_mapping
from trainer.model.vae import Model

TURNS = 25
"""How often each bundle is timed, after all the others."""
_FILE = "costs.json"


class Architecture(NamedTuple):
    """What determines the cost of an answer."""

    model: ModelConfig
    width: int
    height: int
    bundle: BundlePrecision


@dataclass(frozen=True)
class Cost:
    """Of one picture, from the picture to vertices."""

    latency_ms: float
    """Encoder and decoder on one core: the median of many, in turns with all other bundles."""
    bundle_mb: float
    memory_mb: float
    """Largest resident set of a process that does nothing but load the bundle and answer."""
    multiply_adds_millions: float
    parameters_thousands: float


def architecture_of(point: Point) -> Architecture:
    config = point.variant.config
    return Architecture(config.model, config.width, config.height, point.choice.bundle)


def costs_of(bundles: Mapping[Architecture, Path], root: Path) -> dict[Architecture, Cost]:
    """The costs of all of these, measured in one go; or those that `root` keeps, where it has just these bundles'."""
    identities = {str(bundle.relative_to(root)): _identity(bundle) for bundle in bundles.values()}
    file = root / _FILE
    kept = json.loads(file.read_text(encoding="utf-8")) if file.exists() else {}
    if kept.get("identities") != identities:
        names = {str(number): bundle for number, bundle in enumerate(bundles.values())}
        latencies = latencies_ms(names, TURNS)
        costs = [
            to_mapping(_cost(architecture, bundle, latencies[str(number)]))
            for number, (architecture, bundle) in enumerate(bundles.items())
        ]
        kept = {"identities": identities, "costs": dict(zip(identities, costs, strict=True))}
        write_bytes(file, (json.dumps(kept, indent=2) + "\n").encode())
    found: dict[str, Any] = kept["costs"]
    return {
        architecture: from_mapping(Cost, found[str(bundle.relative_to(root))], _FILE)
        for architecture, bundle in bundles.items()
    }


def _cost(architecture: Architecture, bundle: Path, latency_ms: float) -> Cost:
    model = Model(architecture.model, architecture.width, architecture.height)
    return Cost(
        latency_ms=round(latency_ms, 4),
        bundle_mb=round(megabytes(bundle), 4),
        memory_mb=round(_peak_bytes(bundle) / 1e6, 1),
        multiply_adds_millions=round(multiply_adds(model) / 1e6, 3),
        parameters_thousands=round(sum(parameter.numel() for parameter in model.parameters()) / 1e3, 1),
    )


def multiply_adds(model: Model) -> int:
    """Of the convolutions and linear layers, from one picture to vertices."""
    model.eval()
    with torch.no_grad(), FlopCounterMode(display=False) as counter:
        model.decode(model.encode(torch.zeros(1, 3, model.height, model.width)).shape_mean)
    return int(counter.get_total_flops()) // 2


def _peak_bytes(bundle: Path) -> int:
    command = [sys.executable, "-m", "trainer.frontier.answering", str(bundle)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise DataError(f"Expected {bundle} to answer in a process of its own, found: {done.stderr.strip()[-300:]}")
    return int(done.stdout)


def _identity(bundle: Path) -> str:
    """Of the graphs."""
    return str(json.loads((bundle / "manifest.json").read_text(encoding="utf-8"))["identity"])
