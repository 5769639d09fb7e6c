"""Which models are compared, and how large they are."""

import json
import math
from dataclasses import replace
from pathlib import Path

import pytest

from trainer.config import ModelConfig, TrainConfig
from trainer.errors import ConfigError
from trainer.mapping import from_mapping
from trainer.presets import load_preset
from trainer.selection.candidates import Candidate, Form, config_of, grid, parse_form
from trainer.selection.size import size_of

ROOT = Path(__file__).parents[3]


def test_the_grid_holds_every_combination_once() -> None:
    found = grid(["subdivision-3", "full-block-12"], [6, 12], ["fixed", "varying"], ["none", "mirror"])
    assert len(set(found)) == 16
    assert len({candidate.name for candidate in found}) == 16
    assert Candidate(Form("full-block", 12), 6, "varying", "mirror") in found


@pytest.mark.parametrize("text", ["cube-3", "subdivision", "subdivision-0", "subdivision-3x", "ortho-block-", ""])
def test_what_is_no_form_is_refused(text: str) -> None:
    with pytest.raises(ConfigError, match=r"Expected --forms such as subdivision-4 .*, found "):
        parse_form(text)


def test_a_candidate_changes_the_model_alone() -> None:
    recipe = replace(load_preset("fast"), model=ModelConfig(segments=2, base="cup", hidden=48))
    blocks = config_of(Candidate(Form("ortho-block", 3), 6, "fixed"), recipe)
    assert replace(blocks, model=recipe.model) == recipe
    assert blocks.model == ModelConfig(latent=6, hidden=48, parameterisation="ortho-block", blocks=3)
    meshed = config_of(Candidate(Form("subdivision", 5), 9, "varying"), recipe)
    assert meshed.model == ModelConfig(latent=9, hidden=48, segments=5, light="varying")
    hollow = config_of(Candidate(Form("cup", 5), 9, "varying"), replace(recipe, model=ModelConfig(hidden=48)))
    assert hollow.model == replace(meshed.model, base="cup")
    uneven = replace(recipe, model=ModelConfig(hidden=48, proportions=(1, 3, 2)))
    assert config_of(Candidate(Form("ortho-block", 3), 6, "fixed"), uneven).model == blocks.model
    assert config_of(Candidate(Form("cup", 5), 9, "varying"), uneven).model == hollow.model
    longer = config_of(Candidate(Form("subdivision", 5), 9, "varying"), uneven)
    assert longer.model == replace(meshed.model, proportions=(1, 3, 2))
    mirrored = config_of(Candidate(Form("ortho-block", 3), 6, "fixed", "mirror"), recipe)
    assert mirrored.model == replace(blocks.model, symmetry="mirror")
    with pytest.raises(ConfigError, match=r"Expected model.segments from 1 to 64, found 65"):
        config_of(Candidate(Form("subdivision", 65), 9, "fixed"), recipe)


def test_silhouettes_have_no_light_to_infer() -> None:
    recipe = load_preset("fast")
    silhouettes = replace(recipe, loss=replace(recipe.loss, kind="silhouette"))
    config_of(Candidate(Form("subdivision", 4), 12, "fixed"), silhouettes)
    with pytest.raises(ConfigError, match="silhouettes say nothing about the light"):
        config_of(Candidate(Form("subdivision", 4), 12, "varying"), silhouettes)


@pytest.mark.parametrize(
    ("form", "outputs", "vertices"),
    [
        ("subdivision-3", 3 * 56, 56),
        ("subdivision-4", 3 * 98, 98),
        ("cup-4", 3 * 178, 178),
        ("ortho-block-6", 6 * 6, 144),
        ("full-block-6", 9 * 6, 144),
    ],
)
def test_the_decoder_has_two_layers_and_the_sizes_say_so(form: str, outputs: int, vertices: int) -> None:
    size = size_of(config_of(Candidate(parse_form(form), 6, "fixed"), load_preset("fast")))
    assert size.shape_parameters == (6 + 1) * 32 + (32 + 1) * outputs
    assert size.vertices == vertices


@pytest.mark.parametrize(
    ("form", "rows"),
    # Of 98 vertices 41 have an image, and 16 lie in the mirror; of three blocks one has an image, and one lies in it.
    [("subdivision-4", 3 * 41 + 2 * 16), ("ortho-block-6", 3 * 6), ("full-block-3", 9 + (2 + 3 + 1))],
)
def test_mirrored_shapes_have_half_as_much_to_learn(form: str, rows: int) -> None:
    size = size_of(config_of(Candidate(parse_form(form), 6, "fixed", "mirror"), load_preset("fast")))
    assert size.shape_parameters == (6 + 1) * 32 + (32 + 1) * rows


def test_each_dimension_of_the_code_and_each_angle_of_the_light_is_paid_for() -> None:
    def parameters(latent: int, light: str) -> int:
        model = ModelConfig(latent=latent, light="varying" if light else "fixed")
        return size_of(replace(load_preset("fast"), model=model)).parameters

    # Mean and deviation from 128 features and a bias each, and a row of the decoder's 32.
    assert parameters(7, "") - parameters(6, "") == 2 * 129 + 32
    assert parameters(6, "varying") - parameters(6, "") == (3 + 2) * 129


def test_the_estimate_is_what_the_bundles_that_ship_weigh() -> None:
    manifests = {path.parent: json.loads(path.read_text()) for path in ROOT.glob("models*/*/manifest.json")}
    # It is of what a training is exported to, unless another precision is asked for.
    in_float32 = [folder for folder, manifest in manifests.items() if manifest["precision"] is None]
    assert len(in_float32) > 5
    for folder in in_float32:
        config = from_mapping(TrainConfig, manifests[folder]["training"]["config"], str(folder))
        weighed = sum(file.stat().st_size for file in folder.iterdir())
        assert math.isclose(size_of(config).bundle_bytes, weighed, rel_tol=0.01), folder.name
