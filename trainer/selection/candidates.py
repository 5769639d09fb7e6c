"""The models that are compared: every kind of mesh with every size of code, kind of light and of symmetry."""

import itertools
import re
from collections.abc import Sequence
from dataclasses import replace
from typing import Literal, NamedTuple, cast, get_args

from trainer.config import ModelConfig, Symmetry, TrainConfig
from trainer.errors import ConfigError
from trainer.training.checks import check_settings

Parameterisation = Literal["subdivision", "ortho-block", "full-block"]
Light = Literal["fixed", "varying"]

_FORM = re.compile(rf"({'|'.join(get_args(Parameterisation))})-([1-9]\d*)")


class Form(NamedTuple):
    """A kind of mesh, as section 3 of the paper has it, and how fine it is."""

    parameterisation: Parameterisation
    fineness: int
    """Segments along each edge of the cube, or blocks."""

    @property
    def name(self) -> str:
        return f"{self.parameterisation}-{self.fineness}"


class Candidate(NamedTuple):
    """A model that may be chosen."""

    form: Form
    latent: int
    """Dimensions of the shape code z."""
    light: Light
    symmetry: Symmetry = "none"

    @property
    def name(self) -> str:
        """Also its folder's."""
        symmetry = "" if self.symmetry == "none" else f"_{self.symmetry}"
        return f"{self.form.name}_latent-{self.latent}_{self.light}{symmetry}"


def parse_form(text: str) -> Form:
    """A form by its name, such as `subdivision-4` or `ortho-block-6`. Raises ConfigError for any other."""
    found = _FORM.fullmatch(text)
    if found is None:
        raise ConfigError(
            f"Expected --forms such as subdivision-4 (segments), ortho-block-6 or full-block-12 (blocks), found {text}."
        )
    return Form(cast(Parameterisation, found[1]), int(found[2]))


def grid(
    forms: Sequence[str], latents: Sequence[int], lights: Sequence[Light], symmetries: Sequence[Symmetry]
) -> list[Candidate]:
    """All combinations. Raises ConfigError where one is named twice, or where there is nothing to choose from."""
    options = (("forms", forms), ("latents", latents), ("lights", lights), ("symmetries", symmetries))
    for option, values in options:
        if len(set(values)) < len(values):
            raise ConfigError(f"Expected --{option} that differ, found {' '.join(map(str, values))}. Name each once.")
    parsed = [parse_form(form) for form in forms]
    found = [Candidate(*choice) for choice in itertools.product(parsed, latents, lights, symmetries)]
    if len(found) < 2:
        raise ConfigError(
            f"Expected two candidates or more, found {len(found)}: name several of --forms, --latents, "
            "--lights or --symmetries."
        )
    return found


def config_of(candidate: Candidate, recipe: TrainConfig) -> TrainConfig:
    """The recipe with this candidate's model. Raises ConfigError where the two do not go together."""
    usual, meshed = ModelConfig(), candidate.form.parameterisation == "subdivision"
    model = replace(
        recipe.model,
        parameterisation=candidate.form.parameterisation,
        segments=candidate.form.fineness if meshed else usual.segments,
        base=recipe.model.base if meshed else usual.base,
        blocks=0 if meshed else candidate.form.fineness,
        latent=candidate.latent,
        light=candidate.light,
        symmetry=candidate.symmetry,
        light_bins=recipe.model.light_bins if candidate.light == "varying" else usual.light_bins,
    )
    config = replace(recipe, model=model)
    check_settings(config)
    return config
