"""Blocks: where they start, what each parameter does, and how they are learnt."""

import math

import numpy as np
import pytest
import torch

from trainer.config import ModelConfig, OptimiserConfig
from trainer.geometry.blocks import chamfered_cube, loose_cluster
from trainer.geometry.normals import vertex_normals
from trainer.model.block_decoder import SMALLEST_SIDE, BlockDecoder
from trainer.model.vae import Model, decoder_of
from trainer.training.optimiser import adam, at_step


@pytest.mark.parametrize(("kind", "blocks"), [("ortho-block", 6), ("full-block", 12)])
def test_a_new_decoder_starts_at_the_papers_number_of_loose_cubes(kind: str, blocks: int) -> None:
    decoder = decoder_of(ModelConfig(parameterisation=kind))  # type: ignore[arg-type]
    assert isinstance(decoder, BlockDecoder)
    vertices = decoder(torch.randn(5, 12)).detach()
    assert vertices.shape == (5, 24 * blocks, 3)
    assert (vertices - decoder.base_vertices).abs().max() < 0.05
    assert [part.name for part in decoder.parts] == [f"block-{k}" for k in range(1, blocks + 1)]
    assert [part.first_face for part in decoder.parts] == list(range(0, 44 * blocks, 44))
    assert len(decoder.faces) == sum(part.face_count for part in decoder.parts) == 44 * blocks
    for k, part in enumerate(decoder.parts):
        own = decoder.faces[part.first_face : part.first_face + part.face_count]
        assert sorted(own.unique().tolist()) == list(range(24 * k, 24 * k + 24))


def test_vertices_are_scaled_then_turned_then_moved() -> None:
    decoder = BlockDecoder(3, 4, 2, side=0.4, turning=True)
    offsets, scales = np.array([[1.0, -2.0, 0.5], [0.1, 0.2, 0.3]]), np.array([[3.0, -1.0, 0.2], [0.5, 0.0, -4.0]])
    angles = np.array([[math.pi / 2, 0.0, 0.0], [0.0, 0.0, math.pi / 2]])
    assert decoder.angles is not None
    with torch.no_grad():
        for layer, bias in ((decoder.offsets, offsets), (decoder.scales, scales), (decoder.angles, angles)):
            layer.weight.zero_()
            layer.bias.copy_(torch.tensor(bias).flatten())
        found = decoder(torch.zeros(1, 3))[0].double().numpy().reshape(2, 24, 3)
    centres, side = loose_cluster(2, 0.4)
    sides = SMALLEST_SIDE + (side - SMALLEST_SIDE) * np.log1p(np.exp(scales + math.log(math.e - 1)))
    boxes = chamfered_cube().vertices * sides[:, None]
    # A quarter turn about +Y takes x to -z and z to x; about +Z, x to y and y to -x.
    turned = np.stack((boxes[0][:, [2, 1, 0]] * [1, 1, -1], boxes[1][:, [1, 0, 2]] * [-1, 1, 1]))
    np.testing.assert_allclose(found, turned + (centres + 0.3 * offsets)[:, None], atol=1e-6)


def test_normals_are_those_of_the_vertices_also_of_a_block_as_thin_as_paper() -> None:
    torch.manual_seed(0)
    decoder = BlockDecoder(5, 8, 3, side=0.4, turning=True)
    assert decoder.angles is not None
    with torch.no_grad():
        decoder.angles.bias.normal_()
        decoder.scales.bias[1] = -90.0
        codes = torch.randn(4, 5)
        exact = decoder.double()
        expected = vertex_normals(exact(codes.double()), decoder.faces)
        np.testing.assert_allclose(decoder.float().normals(codes), expected, atol=1e-5)
    assert (decoder.normals(codes).norm(dim=-1) - 1).abs().max() < 1e-5


def test_upright_blocks_have_no_angles_and_rotations_a_learning_rate_of_their_own() -> None:
    channels = (4, 4, 4, 4, 4, 4)
    config = OptimiserConfig(learning_rate=5e-3, decoder_factor=4)
    ortho = Model(ModelConfig(parameterisation="ortho-block", encoder_channels=channels), 32, 24)
    assert not any("angles" in name for name, _ in ortho.named_parameters())
    assert [group["lr"] for group in adam(ortho, config).param_groups] == [5e-3, 2e-2]
    full = Model(ModelConfig(parameterisation="full-block", encoder_channels=channels), 32, 24)
    groups = {group["lr"]: group["params"] for group in adam(full, config).param_groups}
    assert sorted(groups) == [1e-4, 5e-3, 2e-2]
    assert [tuple(parameter.shape) for parameter in groups[1e-4]] == [(36, 32), (36,)]
    assert len(groups[2e-2]) + 2 == len(list(full.decoder.parameters()))
    assert sum(map(len, groups.values())) == len(list(full.parameters()))


def test_all_learning_rates_fall_alike_and_are_those_of_the_step() -> None:
    channels = (4, 4, 4, 4, 4, 4)
    config = OptimiserConfig(decoder_factor=4, falling_share=0.4, steps=10)
    optimiser = adam(Model(ModelConfig(parameterisation="ortho-block", encoder_channels=channels), 32, 24), config)
    for step, rate in ((8, 5e-4), (0, 1e-3)):
        rates = [group["lr"] for group in at_step(optimiser, config, step).param_groups]
        assert rates == pytest.approx([rate, 4 * rate])


def test_only_a_model_of_varying_light_has_heads_for_it() -> None:
    channels = (4, 4, 4, 4, 4, 4)
    fixed = Model(ModelConfig(encoder_channels=channels), 32, 24)
    varying = Model(ModelConfig(encoder_channels=channels, light="varying"), 32, 24)
    names = {name for name, _ in varying.named_parameters()} - {name for name, _ in fixed.named_parameters()}
    heads = ("logits", "fine_mean", "fine_deviation")
    assert names == {f"heads.light.{head}.{part}" for head in heads for part in ("weight", "bias")}
    light = varying.eval().encode(torch.rand(4, 3, 24, 32)).light
    assert light is not None
    assert light.logits.shape == (4, 3)
    assert light.fine_mean.abs().max() < math.pi / 6
