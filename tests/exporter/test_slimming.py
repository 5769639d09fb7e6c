"""What carries nothing is left out of a bundle, and nobody can tell from its answers."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from torch import nn

from exporter.export import export
from exporter.slimming import LARGEST_CHANGE, blocks_in_use, codes_alive, slimmed
from service.bundle import read_bundle
from service.errors import BundleError
from service.generation import LARGEST_NUMBER, decode_shape, sampled_code
from service.inference import decode, encode, load_engine
from service.manifest import Block, decode_manifest, encode_manifest
from tests.exporter.conftest import OFFSET, small_checkpoint
from tests.exporter.test_held_out import disc
from tests.exporter.test_settings import checkpoint_with
from trainer.model.block_decoder import BlockDecoder
from trainer.training.checkpoint import Checkpoint

NO_PICTURES = np.zeros((0, 3, 48, 64), np.float32)


def generator() -> torch.Generator:
    return torch.Generator().manual_seed(0)


def with_still_numbers(*numbers: int) -> Checkpoint:
    """The small checkpoint whose decoder hardly looks at some numbers of the shape code."""
    checkpoint = small_checkpoint()
    first = checkpoint.model.decoder.hidden[0]
    assert isinstance(first, nn.Linear)
    with torch.no_grad():
        first.weight[:, list(numbers)] *= 1e-9
    return checkpoint


def with_blocks_placed(checkpoint: Checkpoint, places: dict[int, tuple[float, float]]) -> BlockDecoder:
    """Blocks that stand still: at a place along x, as large as a softplus of that number makes them."""
    decoder = checkpoint.model.decoder
    assert isinstance(decoder, BlockDecoder)
    with torch.no_grad():
        for block, (place, scale) in places.items():
            rows = slice(3 * block, 3 * block + 3)
            decoder.locations[block] = torch.tensor([place, 0.0, 0.0])
            for layer in (decoder.offsets, decoder.scales):
                layer.weight[rows] = 0
                layer.bias[rows] = 0
            decoder.scales.bias[rows] = scale
    return decoder


def test_numbers_that_move_nothing_go_and_every_answer_stays(tmp_path: Path) -> None:
    checkpoint = with_still_numbers(1, 3)
    export(checkpoint, tmp_path / "car", OFFSET, {})
    engine = load_engine(read_bundle(tmp_path / "car"))
    manifest = engine.manifest
    assert manifest.parsimony is not None
    assert (manifest.parsimony.latent, manifest.parsimony.trained_latent, manifest.latent) == ((0, 2, 4), 5, 3)
    assert 0 < manifest.parsimony.largest_change <= LARGEST_CHANGE
    rotation = torch.tensor(
        [[np.cos(OFFSET), 0, -np.sin(OFFSET)], [0, 1, 0], [np.sin(OFFSET), 0, np.cos(OFFSET)]], dtype=torch.float32
    )
    images = torch.rand(8, 3, 48, 64)
    with torch.no_grad():
        posterior = checkpoint.model.encode(images)
        expected = checkpoint.model.decode(posterior.shape_mean) @ rotation.T
    for image, mean, vertices in zip(images, posterior.shape_mean, expected, strict=True):
        found = encode(engine, image.numpy())
        np.testing.assert_allclose(found.shape_mean, mean[[0, 2, 4]], atol=1e-5)
        np.testing.assert_allclose(decode(engine, found.shape_mean).vertices, vertices, atol=1e-4)


def test_a_seed_stays_the_same_object(tmp_path: Path) -> None:
    checkpoint = with_still_numbers(0)
    slim = export(checkpoint, tmp_path / "slim", 0.0, {})
    engine = load_engine(read_bundle(tmp_path / "slim"))
    for seed in range(5):
        code = np.random.RandomState(seed).standard_normal(5).astype(np.float32)
        with torch.no_grad():
            expected = checkpoint.model.decode(torch.from_numpy(code)[None])[0]
        found = decode(engine, sampled_code(slim, seed, 1.0)).vertices
        np.testing.assert_allclose(found, expected, atol=1e-4)
    assert decode_shape(engine, [LARGEST_NUMBER] * 4).report.shape_code == (LARGEST_NUMBER,) * 4


def test_a_number_that_moves_samples_stays_whatever_pictures_say_of_it() -> None:
    checkpoint = small_checkpoint()
    heads = checkpoint.model.heads
    with torch.no_grad():
        # Its posterior is the prior, 0 ± 1.
        heads.shape_mean.weight[2], heads.shape_mean.bias[2] = 0, 0
        heads.shape_deviation.weight[2], heads.shape_deviation.bias[2] = 0, 0.0012
    slim, parsimony = slimmed(
        checkpoint.model, np.random.default_rng(0).random((30, 3, 48, 64), np.float32), generator()
    )
    assert parsimony.latent == (0, 1, 2, 3, 4)
    assert parsimony.latent_divergence_nats[2] == pytest.approx(0, abs=1e-5)
    assert min(parsimony.latent_divergence_nats[:2]) > 1e-4
    assert (parsimony.largest_change, slim.config.latent, parsimony.pictures) == (0, 5, 30)


def test_a_number_that_moves_vertices_far_from_the_prior_only_stays() -> None:
    """What the service may be asked for counts: numbers up to ±10."""
    checkpoint = with_still_numbers(4)
    first = checkpoint.model.decoder.hidden[0]
    assert isinstance(first, nn.Linear)
    with torch.no_grad():
        first.weight[0, 4], first.bias[0] = 1.0, -9.0
        first.weight[0, :4] = 0
    _, parsimony = slimmed(checkpoint.model, NO_PICTURES, generator())
    assert parsimony.latent == (0, 1, 2, 3, 4)


def test_one_number_stays_of_a_model_that_never_moves() -> None:
    _, parsimony = slimmed(with_still_numbers(0, 1, 2, 3, 4).model, NO_PICTURES, generator())
    assert len(parsimony.latent) == 1


@pytest.mark.parametrize("kind", ["ortho-block", "full-block"])
def test_blocks_that_never_show_go(kind: str, tmp_path: Path) -> None:
    """A block inside another, and one as small as can be; not one that only lies behind another."""
    checkpoint = checkpoint_with(parameterisation=kind, blocks=4)
    decoder = with_blocks_placed(checkpoint, {0: (0.0, -2.0), 1: (0.0, 2.0), 2: (0.6, -1.0), 3: (-0.9, -40.0)})
    with torch.no_grad():
        # The third grows and shrinks.
        decoder.scales.weight[6:9] = 0.2 * torch.randn(3, decoder.scales.in_features)
    manifest = export(checkpoint, tmp_path / "car", 0.0, {})
    assert manifest.parsimony is not None
    assert manifest.latent == 5
    assert manifest.parsimony.removed_blocks == ("block-1", "block-4")
    assert [block.name for block in manifest.blocks] == ["block-2", "block-3"]
    assert (manifest.vertices, len(manifest.faces)) == (48, 88)
    engine = load_engine(read_bundle(tmp_path / "car"))
    codes = torch.randn(4, 5)
    with torch.no_grad():
        vertices, normals = decoder(codes), decoder.normals(codes)
    for code, expected, upright in zip(codes.numpy(), vertices, normals, strict=True):
        found = decode(engine, code)
        np.testing.assert_allclose(found.vertices, expected[24:72], atol=1e-5)
        np.testing.assert_allclose(found.normals, upright[24:72], atol=1e-4)


@pytest.mark.parametrize("kind", ["subdivision", "ortho-block", "full-block"])
def test_mirrored_shapes_are_written_out(kind: str) -> None:
    """A bundle has all vertices, also those that were not learnt by themselves, as any other decoder has them."""
    blocks = 0 if kind == "subdivision" else 3
    checkpoint = checkpoint_with(parameterisation=kind, blocks=blocks, symmetry="mirror")
    slim, parsimony = slimmed(checkpoint.model, NO_PICTURES, generator())
    assert parsimony.removed_blocks == ()
    assert not any("parametrizations" in name for name in slim.state_dict())
    codes = torch.randn(4, 5)
    with torch.no_grad():
        np.testing.assert_allclose(slim.decode(codes), checkpoint.model.decode(codes), atol=1e-6)


def test_a_block_that_shows_once_in_a_while_stays() -> None:
    checkpoint = checkpoint_with(parameterisation="ortho-block", blocks=2)
    decoder = with_blocks_placed(checkpoint, {0: (0.0, -2.0), 1: (0.0, 2.0)})
    hidden = decoder.hidden[0]
    assert isinstance(hidden, nn.Linear)
    with torch.no_grad():
        hidden.weight[0], hidden.bias[0] = torch.tensor([1.0, 0, 0, 0, 0]), -2.0
        decoder.offsets.weight[0, 0] = 5.0
    slim, parsimony = slimmed(checkpoint.model, NO_PICTURES, generator())
    assert parsimony.removed_blocks == ()
    assert len(slim.decoder.parts) == 2


def test_a_speck_goes_but_not_a_small_block() -> None:
    """Of sides of 0.005 and 0.03: less and more than counts as used."""
    for scale, stays in ((-5.0, 2), (-3.0, 3)):
        checkpoint = checkpoint_with(parameterisation="ortho-block", blocks=3)
        with_blocks_placed(checkpoint, {0: (0.0, 2.0), 1: (0.6, 0.0), 2: (1.5, scale)})
        slim, _ = slimmed(checkpoint.model, NO_PICTURES, generator())
        assert len(slim.decoder.parts) == stays


def test_shapes_are_looked_at_where_pictures_have_their_codes() -> None:
    """Only what the prior has far from all pictures makes use of the second block."""
    checkpoint = checkpoint_with(parameterisation="ortho-block", blocks=2)
    decoder = with_blocks_placed(checkpoint, {0: (0.0, 2.0), 1: (0.6, -5.0)})
    hidden = decoder.hidden[0]
    assert isinstance(hidden, nn.Linear)
    with torch.no_grad():
        hidden.weight[0], hidden.bias[0] = torch.tensor([1.0, 0, 0, 0, 0]), -2.0
        decoder.scales.weight[3:6, 0] = 5.0
    mean, deviation, noise = torch.zeros(3, 5), torch.full((3, 5), 0.1), torch.randn(256, 5, generator=generator())
    parts = [Block(*part) for part in decoder.parts]
    with torch.no_grad():
        found = [
            blocks_in_use(decoder(codes).numpy(), decoder.faces.numpy(), parts)
            for codes in (noise, codes_alive(mean, deviation, noise))
        ]
    assert found == [[0, 1], [0]]


def test_of_two_blocks_in_one_place_one_stays() -> None:
    checkpoint = checkpoint_with(parameterisation="ortho-block", blocks=2)
    with_blocks_placed(checkpoint, {0: (0.0, 0.0), 1: (0.0, 0.0)})
    slim, _ = slimmed(checkpoint.model, NO_PICTURES, generator())
    assert len(slim.decoder.parts) == 1


def test_a_lively_model_stays_whole(checkpoint: Checkpoint) -> None:
    slim, parsimony = slimmed(checkpoint.model, NO_PICTURES, generator())
    assert parsimony.latent == (0, 1, 2, 3, 4)
    for one, other in zip(slim.state_dict().values(), checkpoint.model.state_dict().values(), strict=True):
        assert torch.equal(one, other)


def test_held_out_pictures_are_looked_at(checkpoint: Checkpoint, tmp_path: Path) -> None:
    manifest = export(checkpoint, tmp_path / "car", 0.0, {}, held_out=[disc(seed) for seed in range(20)])
    assert manifest.parsimony is not None
    assert manifest.parsimony.pictures == 20
    assert len(manifest.parsimony.latent_divergence_nats) == 5


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"latent": (0, 1)}, "expected 5 numbers of the shape code, found 2"),
        ({"latent": (1, 0, 2, 3, 4)}, "expected ascending numbers below 5"),
        ({"latent": (0, 1, 2, 3, 9)}, "expected ascending numbers below 5"),
        ({"latent_divergence_nats": (0.1,)}, "expected 5 divergences or none, found 1"),
    ],
)
def test_a_manifest_that_contradicts_itself_is_refused(
    exported: Path, change: dict[str, object], sentence: str
) -> None:
    manifest = read_bundle(exported).manifest
    assert manifest.parsimony is not None
    wrong = replace(manifest, parsimony=replace(manifest.parsimony, **change))
    with pytest.raises(BundleError, match=f"parsimony: {sentence}"):
        decode_manifest(encode_manifest(wrong), "manifest.json")
