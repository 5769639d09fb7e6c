"""The models that are compared: every kind of mesh with every size of code, kind of light and of symmetry."""

import itertools
import re
from collections.abc import Sequence
from dataclasses import replace
from typing import Literal, NamedTuple, cast, get_args

from trainer.config import ModelConfig, Symmetry, TrainConfig
from trainer.errors import ConfigError
from trainer.training.checks import check_settings

FormKind = Literal["subdivision", "cup", "ortho-block", "full-block"]
Light = Literal["fixed", "varying"]

_FORM = re.compile(rf"({'|'.join(get_args(FormKind))})-([1-9]\d*)")


class Form(NamedTuple):
    """A kind of mesh, and how fine it is: one of section 3 of the paper, or a `subdivision` of the cup."""

    kind: FormKind
    fineness: int
    """Segments along each edge of the cube, or of the cup; or blocks."""

    @property
    def name(self) -> str:
        return f"{self.kind}-{self.fineness}"


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
            "Expected --forms such as subdivision-4 or cup-4 (segments), ortho-block-6 or full-block-12 (blocks), "
            f"found {text}."
        )
    return Form(cast(FormKind, found[1]), int(found[2]))


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
    usual, kind = ModelConfig(), candidate.form.kind
    meshed = kind in ("subdivision", "cup")
    model = replace(
        recipe.model,
        parameterisation="subdivision" if kind == "cup" else kind,
        segments=candidate.form.fineness if meshed else usual.segments,
        base="cup" if kind == "cup" else "cube",
        proportions=recipe.model.proportions if kind == "subdivision" else usual.proportions,
        blocks=0 if meshed else candidate.form.fineness,
        latent=candidate.latent,
        light=candidate.light,
        symmetry=candidate.symmetry,
        light_bins=recipe.model.light_bins if candidate.light == "varying" else usual.light_bins,
    )
    config = replace(recipe, model=model)
    check_settings(config)
    return config
