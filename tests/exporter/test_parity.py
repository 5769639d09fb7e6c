"""How far torch and onnxruntime may differ: in normals, as far as the faces around them say where they point."""

from collections.abc import Mapping

import numpy as np
import pytest
import torch
from torch import Tensor, nn

import exporter.parity
from exporter.errors import ExportError
from exporter.parity import measure_parity
from service.manifest import DECODER_OUTPUTS
from trainer.geometry.normals import vertex_normals

# Two triangles share the edge from 0 to 1: the first lies level, the second is folded back over it but for a little.
FACES = np.array([(0, 1, 2), (1, 0, 3)])
FOLD = 1e-3
VERTICES = torch.tensor([[(0.0, 0, 0), (0, 0, 1), (1, 0, 0), (1, FOLD, 0)]])
EXAMPLES = [torch.zeros(1, 1)]


class Fixed(nn.Module):
    def forward(self, _codes: Tensor) -> tuple[Tensor, Tensor]:
        return VERTICES, vertex_normals(VERTICES, torch.from_numpy(FACES))


def turned(monkeypatch: pytest.MonkeyPatch, vertex: int, by: float) -> None:
    """onnxruntime says the same, but for one normal."""

    def run(_graph: bytes, example: Tensor, names: tuple[str, ...]) -> Mapping[str, np.ndarray]:
        vertices, normals = (output.numpy().copy() for output in Fixed()(example))
        normals[0, vertex, 0] += by
        return dict(zip(names, (vertices, normals), strict=True))

    monkeypatch.setattr(exporter.parity, "run_onnx", run)


@pytest.mark.parametrize(("vertex", "by", "agreement"), [(0, 2e-3, FOLD / 2), (2, 9e-5, 1.0)], ids=["fold", "level"])
def test_a_normal_counts_by_how_much_its_faces_agree(
    monkeypatch: pytest.MonkeyPatch, vertex: int, by: float, agreement: float
) -> None:
    turned(monkeypatch, vertex, by)
    errors = measure_parity(Fixed(), b"", EXAMPLES, DECODER_OUTPUTS, FACES)
    assert errors["normals"] == pytest.approx(by * agreement, rel=1e-3)
    assert errors["vertices"] == 0


@pytest.mark.parametrize(("vertex", "by"), [(2, 2e-4), (0, 0.5), (0, np.nan)], ids=["level", "fold", "not a number"])
def test_normals_that_differ_by_more_than_rounding_are_refused(
    monkeypatch: pytest.MonkeyPatch, vertex: int, by: float
) -> None:
    turned(monkeypatch, vertex, by)
    with pytest.raises(ExportError, match=r"^normals: expected torch and onnxruntime to agree within 0\.0001"):
        measure_parity(Fixed(), b"", EXAMPLES, DECODER_OUTPUTS, FACES)


def test_without_faces_all_normals_count_alike(monkeypatch: pytest.MonkeyPatch) -> None:
    turned(monkeypatch, 0, 2e-3)
    with pytest.raises(ExportError, match=r"^normals: .* found a difference of 0\.002"):
        measure_parity(Fixed(), b"", EXAMPLES, DECODER_OUTPUTS)
