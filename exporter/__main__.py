"""python -m exporter: turn a checkpoint into a bundle."""

import json
import math
import sys
from dataclasses import dataclass
from pathlib import Path

import tyro
from pydantic import JsonValue

from exporter.errors import ExportError
from exporter.export import export
from trainer.data.images import load_image_folder
from trainer.errors import ChiaroError, ConfigError
from trainer.training.checkpoint import Checkpoint, load_checkpoint

OFFSET_KEY = "azimuth_offset_degrees"


@dataclass(frozen=True)
class ExportOptions:
    """Turns a checkpoint into a bundle that the service can load, and proves that both say the same."""

    checkpoint: Path
    """A checkpoint, or a run directory, whose newest checkpoint is taken."""
    output: Path
    """The bundle's directory; a bundle that is there is replaced."""
    azimuth_offset_degrees: float | None = None
    """What has to be added to predicted azimuths to get true ones, degrees; 0 without --metrics."""
    metrics: Path | None = None
    """The judge's metrics.json: its azimuth_offset_degrees is applied, and its figures go into the manifest."""
    images: Path | None = None
    """A folder of pictures of the class that were not trained on, such as the judge's validation pictures, 20 at least:
    how well the model explains them tells the service which pictures are of another class. Without it the service takes
    any picture for one of the class."""


def main(arguments: list[str]) -> int:
    """Read the options, export, tell what was written. Returns the exit status: 2 where something has to be mended."""
    options = tyro.cli(ExportOptions, prog="python -m exporter", args=arguments)
    try:
        metrics = _read_metrics(options.metrics) if options.metrics is not None else {}
        offset = _offset_degrees(options, metrics)
        checkpoint = load_checkpoint(options.checkpoint)
        held_out = _read_pictures(options.images, checkpoint) if options.images is not None else []
        manifest = export(checkpoint, options.output, math.radians(offset), metrics, held_out=held_out)
    except ChiaroError as error:
        print(error, file=sys.stderr)
        return 2
    worst = max(manifest.parity, key=lambda name: manifest.parity[name])
    print(
        f"{options.output}: {manifest.category}, {manifest.vertices} vertices, azimuth offset {offset:g}°; torch and "
        f"onnxruntime differ by at most {manifest.parity[worst]:.1e} ({worst}); model {manifest.identity[:12]}"
    )
    if manifest.held_out is None:
        print("no held-out pictures: the service will give no out-of-class score; name a folder of them with --images")
    return 0


def _offset_degrees(options: ExportOptions, metrics: dict[str, JsonValue]) -> float:
    if options.metrics is None:
        offset: JsonValue = options.azimuth_offset_degrees or 0.0
    elif options.azimuth_offset_degrees is not None:
        raise ConfigError("expected one of --azimuth-offset-degrees and --metrics, found both; name one of them")
    else:
        offset = metrics.get(OFFSET_KEY)
    if isinstance(offset, bool) or not isinstance(offset, int | float) or not -360 <= offset <= 360:
        raise ConfigError(
            f"{options.metrics or '--azimuth-offset-degrees'}: expected {OFFSET_KEY} from -360 to 360, found "
            f"{str(offset)[:40]}; measure it with python -m trainer evaluate"
        )
    return float(offset)


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


def _read_pictures(folder: Path, checkpoint: Checkpoint) -> list[bytes]:
    """The files of a folder's pictures that can be used."""
    model = checkpoint.model
    return [(folder / name).read_bytes() for name in load_image_folder(folder, model.width, model.height).names]


def _refuse_constant(name: str) -> float:
    raise ValueError(name)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
