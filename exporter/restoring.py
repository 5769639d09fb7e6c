"""From a bundle back to a run directory, to teach its encoder the last phase anew, or to judge and export it.

    python -m exporter.restoring --bundle models/car --images PICTURES --run RUN
    python -m trainer train --resume --run RUN --images PICTURES --reframing-share 0.5

For those who have a bundle and no longer the run that it came from. Weights are the bundle's; the optimiser's state is
lost, and the steps before the last phase cannot go on as if nothing had been.
"""

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import onnx
import torch
import tyro
from jaxtyping import Float
from onnx import numpy_helper
from torch import Tensor, nn
from torch.nn.utils import parametrize

from exporter.errors import ExportError
from exporter.precision import widened
from imaging.srgb import decode_table
from service.bundle import Bundle, read_bundle
from service.errors import BundleError
from trainer.config import TrainConfig
from trainer.errors import ChiaroError
from trainer.evaluation.bundle import from_bundle
from trainer.evaluation.pictures import load_as_seen
from trainer.mapping import from_mapping
from trainer.model.vae import Model, model_of
from trainer.training.checkpoint import FILE_NAME, Checkpoint, save_checkpoint

_KEPT: Final = ("seconds", "core_seconds", "pictures", "validation_pictures")
"""What of the run's summary is still so."""
_LOOKED_AT: Final = 256
"""Pictures that tell means and variances of a layer."""


@dataclass(frozen=True)
class RestoringOptions:
    """Makes a run directory of a bundle."""

    bundle: Path
    """The bundle's directory."""
    images: Path
    """The folder of pictures that it was trained on, as `trainer render` wrote it or your own."""
    run: Path
    """The run directory, new."""


def main(arguments: list[str]) -> int:
    """Read the options, restore, tell. Returns the exit status: 2 where something has to be mended."""
    options = tyro.cli(RestoringOptions, prog="python -m exporter.restoring", args=arguments)
    try:
        if (options.run / FILE_NAME).exists():
            raise ExportError(f"{options.run}: expected no training there yet, found one; name another directory")
        checkpoint = restored(options.bundle, options.images)
        options.run.mkdir(parents=True, exist_ok=True)
        save_checkpoint(options.run / FILE_NAME, checkpoint)
    except ChiaroError as error:
        print(error, file=sys.stderr)
        return 2
    print(f"{options.run}: {checkpoint.category}, step {checkpoint.step}, without the encoder's last phase")
    return 0


def restored(directory: Path, images: Path) -> Checkpoint:
    """What the bundle in a directory was made from, as it was after its steps, but for rounded weights; `images` is the
    folder of pictures that it was trained on.

    Raises:
        ExportError: no bundle that can be trusted, or one whose weights are not those of a training: int8, or without
            what carried nothing.
        DataError: no pictures that can be used.
    """
    try:
        bundle = read_bundle(directory)
    except BundleError as error:
        raise ExportError(str(error)) from error
    _check_whole(directory, bundle)
    scene, (step, run, config) = from_bundle(directory).scene, _training(directory, bundle)
    model = model_of(config).eval()
    seen = load_as_seen(images, scene).pictures
    pictures = torch.from_numpy(decode_table()[seen[:: -(-len(seen) // _LOOKED_AT)]])
    with torch.no_grad():
        _restore_encoder(model, _weights(bundle.encoder), pictures)
        _restore_layers(model.heads, "heads", _weights(bundle.encoder))
        _restore_layers(model.decoder, "decoder", _weights(bundle.decoder))
    kept = {name: value for name, value in run.items() if name in _KEPT}
    now: dict[str, Any] = {**kept, "images": str(images.resolve()), "restored_from": run}
    return Checkpoint(config, scene, bundle.manifest.category, step, model, {}, now)


def _check_whole(directory: Path, bundle: Bundle) -> None:
    precision, parsimony = bundle.manifest.precision, bundle.manifest.parsimony
    if precision is not None and precision.encoder == "int8":
        raise ExportError(
            f"{directory}: expected weights in float32 or float16, found int8, which are too coarse to learn on with; "
            "name the bundle that it was made from"
        )
    if parsimony is not None and (len(parsimony.latent) < parsimony.trained_latent or parsimony.removed_blocks):
        raise ExportError(
            f"{directory}: expected a bundle of all that its training had, found one that does without "
            f"{parsimony.trained_latent - len(parsimony.latent)} numbers of its shape code and "
            f"{len(parsimony.removed_blocks)} blocks, which carried nothing; train again"
        )


def _training(directory: Path, bundle: Bundle) -> tuple[int, dict[str, Any], TrainConfig]:
    """Steps, summary and settings."""
    told: Any = bundle.manifest.training
    try:
        return int(told["step"]), dict(told["run"]), from_mapping(TrainConfig, told["config"], f"{directory}, training")
    except (KeyError, TypeError, ValueError) as error:
        raise ExportError(
            f"{directory}: expected the steps, summary and settings of a training in the manifest, found others "
            f"({error}); export the bundle again"
        ) from error


def _weights(graph: bytes) -> dict[str, Tensor]:
    """Weights and biases of a graph's layers in float32, named as within the model. A layer's bias is what its node
    asks for, 0 if for none: that of a folded batch normalisation has no name of the model, and equal ones are one."""
    model = onnx.load_from_string(widened(graph)).graph
    tensors = {tensor.name: torch.from_numpy(numpy_helper.to_array(tensor).copy()) for tensor in model.initializer}
    found: dict[str, Tensor] = {}
    for node in model.node:
        if node.op_type in ("Conv", "Gemm") and node.input[1].startswith("model."):
            layer, weight = node.input[1].removeprefix("model.").removesuffix(".weight"), tensors[node.input[1]]
            bias = tensors[node.input[2]] if len(node.input) > 2 else torch.zeros(len(weight))
            found |= {f"{layer}.weight": weight, f"{layer}.bias": bias}
    return found


def _restore_encoder(model: Model, weights: dict[str, Tensor], pictures: Float[Tensor, "N 3 H W"]) -> None:
    """Layers as they are in the graph, and after each a batch normalisation that knows what comes out of it, and
    changes nothing: so it normalises by the batch again as soon as it learns."""
    values = pictures
    for part, layers in (("convolutions", model.encoder.convolutions), ("features", model.encoder.features)):
        for number, layer in enumerate(layers):
            own, before = f"encoder.{part}.{number}", f"encoder.{part}.{number - 1}"
            if isinstance(layer, nn.Conv2d | nn.Linear):
                layer.weight.copy_(weights[f"{own}.weight"])
            elif isinstance(layer, nn.BatchNorm2d | nn.BatchNorm1d):
                assert layer.running_mean is not None
                assert layer.running_var is not None
                axes = [axis for axis in range(values.dim()) if axis != 1]
                layer.running_mean.copy_(values.mean(axes))
                layer.running_var.copy_(values.var(axes, unbiased=False))
                layer.weight.copy_((layer.running_var + layer.eps).sqrt())
                layer.bias.copy_(weights[f"{before}.bias"] + layer.running_mean)
            values = layer(values)


def _restore_layers(module: nn.Module, name: str, weights: dict[str, Tensor]) -> None:
    """The linear layers within; of tied rows, those that are learnt."""
    for path, layer in module.named_modules():
        if isinstance(layer, nn.Linear):
            for part in ("weight", "bias"):
                found = weights[f"{name}.{path}.{part}"]
                if parametrize.is_parametrized(layer, part):
                    setattr(layer, part, found)
                else:
                    getattr(layer, part).copy_(found)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
