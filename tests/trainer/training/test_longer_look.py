"""A longer look descends E, which is that of `imaging.refinement`, and finds what pictures were drawn from."""

import math
from dataclasses import replace

import pytest
import torch
from torch import Tensor

from imaging import refinement
from imaging.pyramid import pyramid
from trainer.config import DirectionalLight, LossConfig, ModelConfig, SceneConfig, TrainConfig
from trainer.evaluation.refinement import drawing
from trainer.model.posterior import LightPosterior, Posterior, bin_centres, light_bin_centres
from trainer.model.vae import Model
from trainer.training.longer_look import Look, energy_of, joined, look_longer

SCENE = SceneConfig(
    48, 36, lights=(DirectionalLight(60.0, 30.0, (0.7, 0.4, 0.1)), DirectionalLight(-40.0, 20.0, (0.1, 0.3, 0.6)))
)
CONFIG = TrainConfig(width=48, height=36, loss=LossConfig(kl_weight=refinement.PRIOR_WEIGHT))
FIXED = ModelConfig(latent=4, azimuth_bins=6, segments=3, encoder_channels=(4, 4, 8, 8, 8, 16))
TURNING = replace(FIXED, light="varying", light_bins=4)
COUNT = 5


def learnt(config: ModelConfig = FIXED) -> Model:
    """Its codes change the shape by as much as those of a trained one."""
    torch.manual_seed(1)
    model = Model(config, SCENE.width, SCENE.height).eval()
    with torch.no_grad():
        layers = [layer for layer in model.decoder.modules() if isinstance(layer, torch.nn.Linear)]
        layers[-1].weight.copy_(0.05 * torch.randn_like(layers[-1].weight))
    return model


def truth(config: ModelConfig) -> tuple[Posterior, Look]:
    """What is to be found, and coarse angles that fit it; fine ones stay within their bins."""
    random = torch.Generator().manual_seed(3)
    code, azimuth = torch.randn(COUNT, 4, generator=random), 0.2 * torch.randn(COUNT, generator=random)
    light = None
    if config.light == "varying":
        light = LightPosterior(
            torch.eye(4)[torch.arange(COUNT) % 4], 0.1 * torch.randn(COUNT, generator=random), azimuth
        )
    logits = torch.eye(6)[torch.arange(COUNT)]
    return Posterior(code, code, logits, azimuth, azimuth, light), Look(code, azimuth, light and light.fine_mean)


def pictures_of(model: Model, posterior: Posterior, look: Look) -> Tensor:
    azimuths = bin_centres(6, look.azimuth_fine)[posterior.azimuth_logits.argmax(1)] + look.azimuth_fine
    lights = None
    if posterior.light is not None and look.light_fine is not None:
        lights = light_bin_centres(4, look.light_fine)[posterior.light.logits.argmax(1)] + look.light_fine
    draw = drawing(model.decode, model.faces, SCENE)
    with torch.no_grad():
        numbers = (None if part is None else part.double().numpy() for part in (look.shape_code, azimuths, lights))
        code, azimuth, light = numbers
        assert code is not None
        assert azimuth is not None
        return torch.from_numpy(draw(code, azimuth, light))


def beside(posterior: Posterior, look: Look, shift: float) -> Posterior:
    """What an encoder says that is off by so much."""
    light = posterior.light
    if light is not None and look.light_fine is not None:
        light = light._replace(fine_mean=look.light_fine - shift / 5)
    return posterior._replace(
        shape_mean=look.shape_code + shift, azimuth_fine_mean=look.azimuth_fine + shift / 5, light=light
    )


@pytest.mark.parametrize("config", [FIXED, TURNING], ids=["fixed light", "turning light"])
def test_e_is_that_of_refinement(config: ModelConfig) -> None:
    model, (posterior, look) = learnt(config), truth(config)
    pictures = pictures_of(model, posterior, look)
    other = look.each(lambda part: part + 0.1)
    with torch.no_grad():
        found = energy_of(model, SCENE, CONFIG, pictures, posterior)(other)
    drawn = pictures_of(model, posterior, other).numpy()
    misfit = (pyramid(drawn) - pyramid(pictures.numpy())) ** 2
    prior = refinement.PRIOR_WEIGHT * 48 * 36 / refinement.FULL_PIXELS
    expected = 0.5 * misfit.sum(1) + 0.5 * prior * other.shape_code.square().sum(1).numpy()
    assert found.tolist() == pytest.approx(expected.tolist(), rel=1e-4)


@pytest.mark.parametrize("config", [FIXED, TURNING], ids=["fixed light", "turning light"])
def test_it_finds_what_pictures_were_drawn_from(config: ModelConfig, monkeypatch: pytest.MonkeyPatch) -> None:
    model, (posterior, look) = learnt(config), truth(config)
    # What nothing pulls at but the pictures.
    free = replace(CONFIG, loss=replace(CONFIG.loss, kl_weight=0.0))
    pictures = pictures_of(model, posterior, look)
    monkeypatch.setattr(Model, "encode", lambda *_: beside(posterior, look, 0.3))
    found = look_longer(model, SCENE, free, pictures, 60)
    assert (found.azimuth_fine - look.azimuth_fine).abs().max() < 0.02
    assert (found.shape_code - look.shape_code).square().mean() < 0.3 * 0.3**2
    if found.light_fine is not None and look.light_fine is not None:
        assert (found.light_fine - look.light_fine).abs().max() < 0.02


def test_no_picture_is_explained_worse(monkeypatch: pytest.MonkeyPatch) -> None:
    """By steps that go astray the encoder's word stays."""
    model, (posterior, look) = learnt(), truth(FIXED)
    pictures = pictures_of(model, posterior, look)
    for shift, kept in ((0.3, False), (0.0, True)):
        said = beside(posterior, look, shift)
        monkeypatch.setattr(Model, "encode", lambda *_, said=said: said)
        config = replace(CONFIG, loss=replace(CONFIG.loss, kl_weight=0.0))
        found = look_longer(model, SCENE, config, pictures, 3)
        energy = energy_of(model, SCENE, config, pictures, posterior)
        first = Look(said.shape_mean, said.azimuth_fine_mean, None)
        with torch.no_grad():
            assert (energy(found) <= energy(first)).all()
        same = (found.shape_code == first.shape_code).all() and (found.azimuth_fine == first.azimuth_fine).all()
        assert bool(same) == kept


def test_fine_angles_stay_in_their_bins(monkeypatch: pytest.MonkeyPatch) -> None:
    """Those of pictures that were taken from beyond end at the border."""
    model, (posterior, look) = learnt(), truth(FIXED)
    half_bin = math.pi / 6
    beyond = look._replace(azimuth_fine=torch.full((COUNT,), half_bin + 0.1))
    pictures = pictures_of(model, posterior, beyond)
    said = posterior._replace(azimuth_fine_mean=torch.full((COUNT,), half_bin - 0.1))
    monkeypatch.setattr(Model, "encode", lambda *_: said)
    found = look_longer(model, SCENE, CONFIG, pictures, 30).azimuth_fine
    assert found.max() <= half_bin + 1e-6
    assert found.median() == pytest.approx(half_bin, abs=0.02)


def test_nothing_of_the_model_changes() -> None:
    model, (posterior, look) = learnt(), truth(FIXED)
    before = {name: tensor.clone() for name, tensor in model.state_dict().items()}
    look_longer(model, SCENE, CONFIG, pictures_of(model, posterior, look), 2)
    assert all(torch.equal(tensor, before[name]) for name, tensor in model.state_dict().items())
    assert all(parameter.grad is None for parameter in model.parameters())


def test_pictures_do_not_depend_on_those_beside_them() -> None:
    model, (posterior, look) = learnt(TURNING), truth(TURNING)
    pictures = pictures_of(model, posterior, look)
    together = look_longer(model, SCENE, CONFIG, pictures, 4)
    apart = joined([look_longer(model, SCENE, CONFIG, part, 4) for part in pictures.split(2)])
    assert together.light_fine is not None
    assert apart.light_fine is not None
    for one, other in zip(together, apart, strict=True):
        assert torch.allclose(one, other, atol=1e-4)


def test_what_cannot_be_drawn_is_told() -> None:
    model = learnt()
    with torch.no_grad():
        model.heads.shape_mean.bias[0] = torch.nan
    with pytest.raises(FloatingPointError, match="finite"):
        look_longer(model, SCENE, CONFIG, torch.zeros(2, 3, 36, 48), 2)
