"""From a bundle to the same bundle in another precision."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import torch

from exporter.assembly import Parts, write_bundle
from exporter.errors import ExportError
from exporter.held_out import read_pictures
from exporter.precision import Graphs, PrecisionName, widened
from service.bundle import Bundle, read_bundle
from service.errors import BundleError
from service.manifest import Manifest


def convertible_bundle(directory: Path, precision: PrecisionName) -> Bundle:
    """The bundle in a directory, which can be had in that precision.

    Raises ExportError where there is none that the service takes, or where its weights have no more bits than that.
    """
    try:
        bundle = read_bundle(directory)
    except BundleError as error:
        raise ExportError(str(error)) from error
    known = bundle.manifest.precision.encoder if bundle.manifest.precision else "float32"
    if (known, precision) not in {("float32", "float16"), ("float32", "int8"), ("float16", "int8")}:
        raise ExportError(
            f"{directory}: expected a bundle of more bits than {precision}, found one in {known}; what is lost does "
            "not come back: convert the bundle that it was made from"
        )
    return bundle


def repack(
    bundle: Bundle, output: Path, precision: PrecisionName, held_out: Sequence[bytes], seed: int = 0
) -> Manifest:
    """Writes a bundle (`convertible_bundle`) in another precision to the directory `output`, and returns its manifest.
    What its outputs are compared with is the bundle that it is made from.

    `held_out` are files of pictures that were not trained on, and `seed` draws the probe's inputs. What the manifest
    says of held-out pictures is measured anew.

    Raises:
        ExportError, StorageError: as `write_bundle` does.
    """
    manifest = bundle.manifest
    camera, size = manifest.camera, manifest.picture
    pictures = read_pictures(
        held_out, size.width, size.height, camera.distance, camera.field_of_view_degrees, size.zoom
    )
    graphs = Graphs(*(widened(graph) for graph in (bundle.encoder, bundle.decoder)))
    parts = Parts(replace(manifest, precision=None), graphs)
    return write_bundle(parts, output, precision, held_out, pictures, torch.Generator().manual_seed(seed))
