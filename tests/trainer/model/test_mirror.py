"""Shapes that are their own mirror images: in every parameterisation, for odd and even numbers, with less to learn."""

from typing import Any

import numpy as np
import pytest
import torch

from trainer.config import ModelConfig
from trainer.model.mirror import mirrored_copies
from trainer.model.vae import Decoder, decoder_of

KINDS = [
    ("subdivision", 0, 3),
    ("subdivision", 0, 4),
    ("cup", 0, 3),
    ("cup", 0, 4),
    ("ortho-block", 6, 4),
    ("ortho-block", 3, 4),
    ("full-block", 12, 4),
    ("full-block", 1, 4),
    ("full-block", 5, 4),
]


def settings_of(kind: str, blocks: int, segments: int) -> dict[str, Any]:
    """Of a parameterisation, or of the cup."""
    if kind == "cup":
        return {"base": "cup", "segments": segments}
    return {"parameterisation": kind, "blocks": blocks, "segments": segments}


def decoders(kind: str, blocks: int, segments: int, std: float = 0.0) -> list[Decoder]:
    """One of any shape, and one of mirrored shapes; with weights of that size, if any is given."""
    found = []
    for symmetry in ("none", "mirror"):
        torch.manual_seed(3)
        decoder = decoder_of(ModelConfig(**settings_of(kind, blocks, segments), symmetry=symmetry))
        with torch.no_grad():
            for parameter in decoder.parameters():
                if std:
                    parameter.normal_(std=std)
        found.append(decoder)
    return found


def farthest(points: torch.Tensor, others: torch.Tensor) -> float:
    """How far any of some points is from the nearest of others."""
    return float(torch.cdist(points.double(), others.double()).min(-1).values.max())


@pytest.mark.parametrize(("kind", "blocks", "segments"), KINDS)
def test_every_shape_is_its_own_mirror_image_and_others_are_not(kind: str, blocks: int, segments: int) -> None:
    free, mirrored = decoders(kind, blocks, segments, std=0.7)
    codes, across = torch.randn(6, 12), torch.tensor([-1.0, 1.0, 1.0])
    with torch.no_grad():
        for vertices in mirrored(codes):
            assert farthest(vertices * across, vertices) < 1e-6
        assert all(farthest(vertices * across, vertices) > 0.05 for vertices in free(codes))
        if kind == "cup" or (kind == "subdivision" and segments % 2 == 0):
            # The diagonals are mirrored as well, and so are the normals: faces look outwards on both sides.
            vertices, normals = mirrored(codes)[0], mirrored.normals(codes)[0]
            both = torch.cat([vertices, 0.1 * normals], 1)
            assert farthest(both * across.repeat(2), both) < 1e-5


@pytest.mark.parametrize(("kind", "blocks", "segments"), KINDS)
def test_a_mirrored_decoder_starts_like_another_and_learns_half_as_much(kind: str, blocks: int, segments: int) -> None:
    free, mirrored = decoders(kind, blocks, segments)
    assert torch.equal(free.faces, mirrored.faces)
    assert free.parts == mirrored.parts
    codes = torch.randn(40, 12)
    assert (mirrored(codes) - mirrored.base_vertices).abs().max() < 0.06
    base = mirrored.base_vertices
    assert farthest(base * torch.tensor([-1.0, 1.0, 1.0]), base) < 1e-6
    learnt, less = (sum(p.numel() for p in decoder.parameters()) - 13 * 32 for decoder in (free, mirrored))
    # What lies in the mirror has no image, and keeps two of three numbers.
    assert 0.5 <= less / learnt <= (0.59 if blocks == 0 or blocks > 3 else 0.72)
    (mirrored(codes) * torch.randn(base.shape)).sum().backward()
    for name, parameter in mirrored.named_parameters():
        moved = parameter.grad.abs() if parameter.grad is not None else torch.zeros(1)
        assert (moved.flatten(1).sum(1) if moved.dim() > 1 else moved).min() > 0 or name.startswith("hidden"), name


def test_a_mirrored_blocks_image_is_turned_the_other_way_round() -> None:
    _, decoder = decoders("full-block", 2, 4, std=0.5)
    with torch.no_grad():
        blocks = decoder(torch.randn(1, 12))[0].unflatten(0, (2, 24)).numpy()
    images = blocks[0] * [-1, 1, 1]
    assert farthest(torch.tensor(images), torch.tensor(blocks[1])) < 1e-6
    assert np.abs(blocks[0].mean(0)[0] + blocks[1].mean(0)[0]) < 1e-6


@pytest.mark.parametrize(
    ("kind", "blocks", "segments"),
    [
        ("subdivision", 0, 3),
        ("subdivision", 0, 4),
        ("cup", 0, 3),
        ("ortho-block", 6, 4),
        ("full-block", 12, 4),
        ("full-block", 13, 4),
        ("full-block", 15, 4),
    ],
)
def test_two_mirrors_make_every_shape_the_same_from_front_and_back_too_and_learn_a_quarter(
    kind: str, blocks: int, segments: int
) -> None:
    settings = settings_of(kind, blocks, segments)
    torch.manual_seed(3)
    free, twice = (decoder_of(ModelConfig(**settings, symmetry=symmetry)) for symmetry in ("none", "two-mirrors"))
    assert torch.equal(free.faces, twice.faces)
    with torch.no_grad():
        assert farthest(twice(torch.randn(40, 12)), twice.base_vertices) < 0.06
        for parameter in twice.parameters():
            parameter.normal_(std=0.7)
        shapes = twice(torch.randn(6, 12))
    for axis in ([-1.0, 1.0, 1.0], [1.0, 1.0, -1.0], [-1.0, 1.0, -1.0]):
        assert all(farthest(vertices * torch.tensor(axis), vertices) < 1e-6 for vertices in shapes)
    assert all(farthest(vertices * torch.tensor([1.0, -1.0, 1.0]), vertices) > 0.05 for vertices in shapes)
    learnt, less = (sum(p.numel() for p in decoder.parameters()) - 13 * 32 for decoder in (free, twice))
    # What lies in a mirror keeps two of three numbers, what lies in both one; blocks keep all their scales.
    assert 0.25 <= less / learnt <= 0.36
    (twice(torch.randn(40, 12)) * torch.randn(twice.base_vertices.shape)).sum().backward()
    for name, parameter in twice.named_parameters():
        assert parameter.grad is not None
        assert parameter.grad.abs().sum() > 0, name


def test_blocks_come_in_fours_pairs_and_alone_of_two_mirrors() -> None:
    mirrors = mirrored_copies(15, (0, 2))
    assert mirrors.source.tolist() == [0, 1, 2] * 4 + [12, 12, 14]
    assert mirrors.side[:, 0].tolist() == [1] * 3 + [-1] * 3 + [1] * 3 + [-1] * 3 + [1, -1, 0]
    assert mirrors.side[:, 1].tolist() == [1] * 15
    assert mirrors.side[:, 2].tolist() == [1] * 6 + [-1] * 6 + [0] * 3
