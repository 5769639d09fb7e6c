"""python -m exporter: turn a checkpoint into a bundle, or a bundle into one of lower precision."""

import json
import math
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import cast

import tyro
from pydantic import JsonValue

from exporter.errors import ExportError
from exporter.export import export
from exporter.held_out import files_in
from exporter.precision import PrecisionName
from exporter.repacking import convertible_bundle, repack
from service.manifest import Manifest
from trainer.errors import ChiaroError, ConfigError
from trainer.evaluation.metrics import TEMPERATURES
from trainer.model.aggregate_posterior import MOST_PICTURES
from trainer.training.checkpoint import load_checkpoint

OFFSET_KEY, TEMPERATURE_KEY = "azimuth_offset_degrees", "azimuth_temperature"


@dataclass(frozen=True)
class ExportOptions:
    """Turns a checkpoint into a bundle that the service can load, and proves that both say the same."""

    output: Path
    """The bundle's directory; a bundle that is there is replaced."""
    checkpoint: Path | None = None
    """A checkpoint, or a run directory, whose newest checkpoint is taken."""
    bundle: Path | None = None
    """Instead of --checkpoint: a bundle, to be written in a --precision of fewer bits."""
    precision: PrecisionName = "float32"
    """Of the weights. float16 halves the bundle and computes in float32 as before; int8 is a quarter of it and faster,
    at the price of some accuracy, which the manifest tells. Both need --images."""
    azimuth_offset_degrees: float | None = None
    """What has to be added to predicted azimuths to get true ones, degrees; 0 without --metrics."""
    azimuth_temperature: float | None = None
    """What the logits of the coarse azimuth bins are divided by, so that they are as probable as they are right; 1, as
    trained, without --metrics."""
    metrics: Path | None = None
    """The judge's metrics.json: its azimuth_offset_degrees and its azimuth_temperature are applied, and its figures go
    into the manifest."""
    images: Path | None = None
    """A folder of pictures of the class that were not trained on, such as the judge's validation pictures, 20 at least,
    and 40 for another precision: how well the model explains them tells the service which pictures are of another
    class. Without it the service takes any picture for one of the class."""
    samples_from: Path | None = None
    """A folder of pictures of the class, such as those that were trained on, 40 at least: samples are drawn from where
    a thousand of them have their shape codes, as far as the model knows its shapes again. By default those of --images;
    without either, from the prior."""


def main(arguments: list[str]) -> int:
    """Read the options, export, tell what was written. Returns the exit status: 2 where something has to be mended."""
    options = tyro.cli(ExportOptions, prog="python -m exporter", args=arguments)
    try:
        manifest = _repacked(options) if options.bundle is not None else _exported(options)
    except ChiaroError as error:
        print(error, file=sys.stderr)
        return 2
    for line in _told(options.output, manifest):
        print(line)
    return 0


def _exported(options: ExportOptions) -> Manifest:
    if options.checkpoint is None:
        raise ConfigError("expected one of --checkpoint and --bundle, found neither; name what is to be exported")
    metrics = _read_metrics(options.metrics) if options.metrics is not None else {}
    offset = _fitted(options, metrics, OFFSET_KEY, 0.0, (-360, 360))
    temperature = _fitted(options, metrics, TEMPERATURE_KEY, 1.0, TEMPERATURES)
    checkpoint = load_checkpoint(options.checkpoint)
    held_out = files_in(options.images, checkpoint.model.width, checkpoint.model.height) if options.images else []
    return export(
        checkpoint,
        options.output,
        math.radians(offset),
        metrics,
        held_out=held_out,
        precision=options.precision,
        azimuth_temperature=temperature,
        samples_from=_sampled(options, checkpoint.model.width, checkpoint.model.height),
    )


def _repacked(options: ExportOptions) -> Manifest:
    if options.checkpoint is not None:
        raise ConfigError("expected one of --checkpoint and --bundle, found both; name one of them")
    own = options.metrics, options.azimuth_offset_degrees, options.azimuth_temperature, options.samples_from
    if any(value is not None for value in own):
        raise ConfigError(
            "expected no --metrics, --azimuth-offset-degrees, --azimuth-temperature or --samples-from with --bundle, "
            "found one; a bundle has its own"
        )
    if options.precision == "float32":
        raise ConfigError("expected --precision float16 or int8 with --bundle, found float32; name one of those")
    bundle = convertible_bundle(cast(Path, options.bundle), options.precision)
    size = bundle.manifest.picture
    held_out = files_in(options.images, size.width, size.height) if options.images else []
    return repack(bundle, options.output, options.precision, held_out)


def _sampled(options: ExportOptions, width: int, height: int) -> list[bytes]:
    """The files of --samples-from, a thousand at the most, evenly out of all."""
    files = files_in(options.samples_from, width, height) if options.samples_from else []
    return files[:: math.ceil(len(files) / MOST_PICTURES)] if files else []


def _told(output: Path, manifest: Manifest) -> Iterator[str]:
    """What there is to say of a bundle that was written."""
    worst = max(manifest.parity, key=lambda name: manifest.parity[name])
    yield (
        f"{output}: {manifest.category}, {manifest.vertices} vertices, azimuth offset "
        f"{manifest.azimuth_offset_degrees:g}°, temperature {manifest.azimuth_temperature:.3g}; torch and onnxruntime "
        f"differ by at most {manifest.parity[worst]:.1e} ({worst}); model {manifest.identity[:12]}"
    )
    parsimony, precision = manifest.parsimony, manifest.precision
    if parsimony is not None:
        gone = parsimony.trained_latent - manifest.latent
        blocks = ", ".join(parsimony.removed_blocks) or "no block"
        yield f"left out: {gone} of {parsimony.trained_latent} numbers of the shape code; {blocks}"
    if precision is not None:
        shape, agreement = precision.deviations["shape_mean"], precision.agreement["azimuth"]
        yield (
            f"{precision.encoder}: the most probable azimuth bin is that of float32 for {agreement:.1%} of "
            f"{precision.pictures} pictures, the shape code differs by {shape.mean:.1e} on average"
        )
    if manifest.held_out is None:
        yield "no held-out pictures: the service will give no out-of-class score; name a folder of them with --images"
    if manifest.aggregate_posterior is None:
        yield "samples will be drawn from the prior; name a folder of pictures of the class with --samples-from"


def _fitted(
    options: ExportOptions, metrics: dict[str, JsonValue], name: str, unfitted: float, limits: tuple[float, float]
) -> float:
    """What the judge has fitted, from its file or from the option of that name."""
    option, told = f"--{name.replace('_', '-')}", getattr(options, name)
    if options.metrics is not None and told is not None:
        raise ConfigError(f"expected one of {option} and --metrics, found both; name one of them")
    found: JsonValue = metrics.get(name) if options.metrics is not None else unfitted if told is None else told
    lowest, highest = limits
    if isinstance(found, bool) or not isinstance(found, int | float) or not lowest <= found <= highest:
        raise ConfigError(
            f"{options.metrics or option}: expected {name} from {lowest:g} to {highest:g}, found "
            f"{str(found)[:40]}; measure it with python -m trainer evaluate"
        )
    return float(found)


def _read_metrics(path: Path) -> dict[str, JsonValue]:
    advice = "write it with python -m trainer evaluate"
    try:
        content = json.loads(path.read_text(encoding="utf-8"), parse_constant=_refuse_constant)
    except OSError as error:
        raise ExportError(f"{path}: expected a metrics.json, found: {error.strerror}; {advice}") from None
    except ValueError as error:
        raise ExportError(f"{path}: expected JSON with finite numbers, found: {error}; {advice}") from None
    if not isinstance(content, dict):
        raise ExportError(f"{path}: expected a JSON object, found a {type(content).__name__}; {advice}")
    return content


def _refuse_constant(name: str) -> float:
    raise ValueError(name)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
