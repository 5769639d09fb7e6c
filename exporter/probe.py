"""The probe of a bundle: inputs, and the answers that the graphs must give again wherever they are loaded."""

import io
from typing import Final

import numpy as np
from numpy.typing import NDArray
from torch import Tensor

from exporter.parity import BEST_BINS, run_onnx, top_margin
from exporter.precision import Graphs
from service.manifest import DECODER_INPUT, DECODER_OUTPUTS, ENCODER_INPUT, Manifest, encoder_outputs

PROBE_BATCH: Final = 2


def make_probe(manifest: Manifest, graphs: Graphs, pictures: Tensor, shape_codes: Tensor) -> bytes:
    """The clearest pictures and the first shape codes, with what the graphs make of them, as .npz."""
    names = encoder_outputs(manifest)
    outputs = run_onnx(graphs.encoder, pictures, names)
    # A picture between two bins would be answered by either on another machine.
    margins = [top_margin(outputs[bins]) for angle, bins in BEST_BINS.items() if angle in names]
    clearest = np.argsort(-np.min(margins, axis=0))[:PROBE_BATCH]
    arrays: dict[str, NDArray[np.float32]] = {
        ENCODER_INPUT: pictures.numpy()[clearest],
        **{name: output[clearest] for name, output in outputs.items()},
        DECODER_INPUT: shape_codes.numpy()[:PROBE_BATCH],
        **run_onnx(graphs.decoder, shape_codes[:PROBE_BATCH], DECODER_OUTPUTS),
    }
    buffer = io.BytesIO()
    np.savez_compressed(buffer, allow_pickle=False, **{name: np.ascontiguousarray(a) for name, a in arrays.items()})
    return buffer.getvalue()
