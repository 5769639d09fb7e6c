"""A setting of the paper's experiments (section 5): what its pictures show, and what is learnt from them; or any other
configuration under a name of its own."""

import re
import tomllib
from dataclasses import dataclass, replace
from typing import Literal

from trainer.config import ModelConfig, TrainConfig
from trainer.mapping import from_mapping

Parameterisation = Literal["subdivision", "ortho-block", "full-block"]

# "Best mesh parameterisations from Table 2": where two share the best IoU, the one whose figures Table 3 repeats.
_BEST: dict[str, Parameterisation] = {"chair": "full-block", "sofa": "ortho-block"}


@dataclass(frozen=True)
class Setting:
    """The defaults are those of Table 1."""

    parameterisation: Literal["subdivision", "ortho-block", "full-block", "best"] = "subdivision"
    """`best` is the class's own in Table 2."""
    rig: Literal["colour", "white"] = "colour"
    """Three coloured lights, or a white one with white ambient."""
    light: Literal["fixed", "varying"] = "fixed"
    """`varying`: turned by another angle in each picture, which is inferred."""
    loss: Literal["shading", "silhouette"] = "shading"
    """What of the pictures is compared."""
    views: int = 1
    """Pictures of each object in training, which are taken together."""
    latent: int = 12
    """Dimensions of the shape code z."""
    pose: Literal["none", "azimuth"] = "none"
    """`azimuth`: the poses are told in training."""
    changes: tuple[str, ...] = ()
    """What else of the recipe is other than it says, each a line of a preset: `loss.kl_weight = 2`."""


@dataclass(frozen=True)
class Variant:
    """A whole configuration, for what no `Setting` can say. It is shown pictures in the coloured lights."""

    name: str
    """A file name; two variants of a study never share one."""
    config: TrainConfig

    @property
    def views(self) -> int:
        return self.config.optimiser.views_per_instance

    @property
    def light(self) -> Literal["fixed", "varying"]:
        return self.config.model.light

    @property
    def rig(self) -> Literal["colour", "white"]:
        return "colour"


def setting_for(setting: Setting, category: str) -> Setting:
    """The setting with the class's own parameterisation in the place of `best`."""
    if setting.parameterisation != "best":
        return setting
    return replace(setting, parameterisation=_BEST.get(category, "subdivision"))


def setting_name(setting: Setting | Variant) -> str:
    """What differs from Table 1, as a file name; two settings never share one. A variant's own."""
    if isinstance(setting, Variant):
        return setting.name
    told = [
        (setting.parameterisation, setting.parameterisation != "subdivision"),
        (setting.rig, setting.rig != "colour"),
        (setting.light, setting.light != "fixed"),
        (setting.loss, setting.loss != "shading"),
        (f"{setting.views}-views", setting.views != 1),
        (f"latent-{setting.latent}", setting.latent != 12),
        ("pose-given", setting.pose != "none"),
        *((re.sub(r"[^\w.-]+", "-", change).strip("-"), True) for change in setting.changes),
    ]
    return "_".join(part for part, differs in told if differs) or "baseline"


def training_config(setting: Setting | Variant, recipe: TrainConfig) -> TrainConfig:
    """The recipe, changed in what the setting says; or a variant's own.

    Several views of each object take half as many objects a step (the paper: 128 pictures, or 64 objects in three).
    """
    if isinstance(setting, Variant):
        return setting.config
    parameterisation: Parameterisation = (
        "subdivision" if setting.parameterisation == "best" else setting.parameterisation
    )
    usual = ModelConfig()
    model = replace(
        recipe.model,
        parameterisation=parameterisation,
        segments=recipe.model.segments if parameterisation == "subdivision" else usual.segments,
        base=recipe.model.base if parameterisation == "subdivision" else usual.base,
        proportions=recipe.model.proportions if parameterisation == "subdivision" else usual.proportions,
        blocks=0,
        light=setting.light,
        light_bins=recipe.model.light_bins if setting.light == "varying" else usual.light_bins,
        latent=setting.latent,
    )
    optimiser = recipe.optimiser
    objects = optimiser.batch_size
    if optimiser.views_per_instance > 1:
        objects = 2 * objects // optimiser.views_per_instance
    if setting.views > 1:
        objects = max(2, objects // 2)
    optimiser = replace(optimiser, views_per_instance=setting.views, batch_size=objects * setting.views)
    loss = replace(recipe.loss, kind=setting.loss, pose_supervision=setting.pose)
    changed = replace(recipe, model=model, loss=loss, optimiser=optimiser)
    return from_mapping(TrainConfig, tomllib.loads("\n".join(setting.changes)), "changes", changed)
