"""The offset between the learnt frame and the true one becomes part of the graphs, and changes no rendering."""

import math

import pytest
import torch

from exporter.graphs import DecoderGraph, EncoderGraph, exported_bin_centres
from trainer.geometry.conventions import rotation_about_y, wrap_angle
from trainer.training.checkpoint import Checkpoint

OFFSETS = [0.0, 0.3, math.pi / 2, -3.0, math.pi]


@pytest.mark.parametrize("offset", OFFSETS)
def test_the_rendered_object_stays_where_it_was(checkpoint: Checkpoint, offset: float) -> None:
    """R(θ + δ) · R(−δ) v = R(θ) v, with θ from the encoder graph and v from the decoder graph."""
    images, shape_codes = torch.rand(6, 3, 48, 64), torch.randn(6, 5)

    def rendered(azimuth_offset: float) -> torch.Tensor:
        with torch.no_grad():
            azimuth = EncoderGraph(checkpoint.model, azimuth_offset)(images)[-1]
            vertices, _ = DecoderGraph(checkpoint.model, azimuth_offset)(shape_codes)
        return vertices @ rotation_about_y(azimuth).mT

    torch.testing.assert_close(rendered(offset), rendered(0.0), atol=2e-6, rtol=0)


@pytest.mark.parametrize("offset", OFFSETS)
def test_azimuths_grow_by_the_offset_and_the_object_turns_back(checkpoint: Checkpoint, offset: float) -> None:
    images, shape_codes = torch.rand(6, 3, 48, 64), torch.randn(6, 5)
    with torch.no_grad():
        before = EncoderGraph(checkpoint.model, 0.0)(images)
        after = EncoderGraph(checkpoint.model, offset)(images)
        plain = checkpoint.model.decode(shape_codes)
        vertices, _ = DecoderGraph(checkpoint.model, offset)(shape_codes)
    torch.testing.assert_close(wrap_angle(after[-1] - before[-1] - offset), torch.zeros(6), atol=1e-6, rtol=0)
    assert ((after[-1] >= -math.pi) & (after[-1] < math.pi)).all()
    for unchanged, same in zip(after[:-1], before[:-1], strict=True):
        assert torch.equal(unchanged, same)
    # A right-handed turn by −δ about +Y, written out.
    cosine, sine = math.cos(offset), math.sin(offset)
    x, y, z = plain.unbind(-1)
    expected = torch.stack((cosine * x - sine * z, y, sine * x + cosine * z), -1)
    torch.testing.assert_close(vertices, expected, atol=1e-6, rtol=0)


@pytest.mark.parametrize("offset", OFFSETS)
def test_the_azimuth_is_the_best_bins_centre_plus_the_fine_mean(checkpoint: Checkpoint, offset: float) -> None:
    with torch.no_grad():
        _, _, probabilities, fine_mean, _, azimuth = EncoderGraph(checkpoint.model, offset)(torch.rand(6, 3, 48, 64))
    torch.testing.assert_close(probabilities.sum(1), torch.ones(6))
    centres = torch.tensor(exported_bin_centres(7, offset)).deg2rad()
    expected = wrap_angle(centres[probabilities.argmax(1)] + fine_mean)
    torch.testing.assert_close(wrap_angle(azimuth - expected), torch.zeros(6), atol=1e-6, rtol=0)


def test_a_temperature_changes_how_sure_the_bins_are_and_nothing_else(checkpoint: Checkpoint) -> None:
    images = torch.rand(6, 3, 48, 64)
    with torch.no_grad():
        plain, cooler = (EncoderGraph(checkpoint.model, 0.3, temperature)(images) for temperature in (1.0, 2.0))
    for number, (before, after) in enumerate(zip(plain, cooler, strict=True)):
        if number != 2:
            assert torch.equal(before, after)
    expected = plain[2].sqrt() / plain[2].sqrt().sum(1, keepdim=True)
    torch.testing.assert_close(cooler[2], expected)


def test_bin_centres_in_closed_form() -> None:
    assert exported_bin_centres(4, 0.0) == [-180, -90, 0, 90]
    assert exported_bin_centres(4, math.radians(100)) == [-80, 10, 100, -170]
    assert exported_bin_centres(12, 0.0)[0] == -180


@pytest.mark.parametrize("offset", OFFSETS)
def test_normals_stand_on_their_faces(checkpoint: Checkpoint, offset: float) -> None:
    """Before any training the object is a cube: in the middle of a side the normal is the side's own."""
    with torch.no_grad():
        checkpoint.model.decoder.displacements.weight.zero_()
        vertices, normals = DecoderGraph(checkpoint.model, offset)(torch.zeros(1, 5))
        plain = checkpoint.model.decode(torch.zeros(1, 5))[0]
    torch.testing.assert_close(normals.norm(dim=-1), torch.ones(1, len(plain)))
    half = plain.abs().max()
    inner = ((plain.abs() > half - 1e-6).sum(1) == 1).nonzero().squeeze(1)
    assert len(inner) == 6 * 9
    sides = (plain[inner] / half).round() * (plain[inner].abs() > half - 1e-6)
    expected = sides @ rotation_about_y(torch.tensor(-offset)).mT
    torch.testing.assert_close(normals[0, inner], expected, atol=1e-5, rtol=0)
    assert ((vertices * normals).sum(-1) > 0).all()


def test_a_surface_without_area_has_a_normal_all_the_same(checkpoint: Checkpoint) -> None:
    with torch.no_grad():
        checkpoint.model.decoder.displacements.weight.zero_()
        checkpoint.model.decoder.base_vertices.zero_()
        _, normals = DecoderGraph(checkpoint.model, 0.5)(torch.randn(2, 5))
    assert torch.equal(normals, torch.tensor([0.0, 1.0, 0.0]).expand_as(normals))
