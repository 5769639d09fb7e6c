"""From a bundle to the same bundle in another precision."""

from collections.abc import Sequence
from pathlib import Path

import torch

from exporter.assembly import Parts, write_bundle
from exporter.errors import ExportError
from exporter.held_out import read_pictures
from exporter.precision import Graphs, PrecisionName
from service.bundle import Bundle, read_bundle
from service.errors import BundleError
from service.manifest import Manifest


def float32_bundle(directory: Path) -> Bundle:
    """The bundle in a directory. Raises ExportError where there is none that the service takes, or none in float32."""
    try:
        bundle = read_bundle(directory)
    except BundleError as error:
        raise ExportError(str(error)) from error
    if bundle.manifest.precision is not None:
        raise ExportError(
            f"{directory}: expected a bundle in float32, found one in {bundle.manifest.precision.encoder}; what is "
            "lost does not come back: convert the bundle that it was made from"
        )
    return bundle


def repack(
    bundle: Bundle, output: Path, precision: PrecisionName, held_out: Sequence[bytes], seed: int = 0
) -> Manifest:
    """Writes a float32 bundle in another precision to the directory `output`, and returns its manifest.

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
    parts = Parts(manifest, Graphs(bundle.encoder, bundle.decoder))
    return write_bundle(parts, output, precision, held_out, pictures, torch.Generator().manual_seed(seed))
