"""What a selection is about, and where it keeps its files.

OUT/settings.json                   what was asked for; anything else is refused here
OUT/candidates/<name>/              a training each, as `trainer train` leaves it
OUT/candidates/<name>/bound-N.json  the bound of held-out pictures after N steps (`selection.record`)
OUT/selection.json, selection.md    who was dropped when, who is chosen, and why
OUT/preset.toml, winner/            the chosen setting, and its training
"""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

from trainer.config import SceneConfig, TrainConfig
from trainer.data.images import ImageSet, load_image_folder
from trainer.data.writing import write_bytes
from trainer.errors import ConfigError
from trainer.mapping import to_mapping
from trainer.selection.candidates import Candidate, config_of
from trainer.selection.halving import Budget

SETTINGS_FILE = "settings.json"


class Task(NamedTuple):
    """A candidate, and the step up to which it is trained before it is judged."""

    candidate: Candidate
    step: int


@dataclass(frozen=True)
class Selection:
    root: Path
    images: Path
    """Folder of pictures."""
    own_scene: SceneConfig
    """Camera and lights of pictures that come without a scene.json."""
    category: str
    recipe: TrainConfig
    """What all candidates share."""
    candidates: tuple[Candidate, ...]
    budget: Budget
    samples: int
    """Draws from the posterior of each held-out picture."""

    def config(self, candidate: Candidate) -> TrainConfig:
        return config_of(candidate, self.recipe)

    def run_directory(self, candidate: Candidate) -> Path:
        return self.root / "candidates" / candidate.name

    def record(self, task: Task) -> Path:
        return self.run_directory(task.candidate) / f"bound-{task.step}.json"

    def pictures(self) -> ImageSet:
        """The folder's pictures without what is known of their poses and lights. Raises as `load_image_folder` does."""
        recipe = self.recipe
        images = load_image_folder(self.images, recipe.width, recipe.height, self.own_scene, recipe.zoom)
        return replace(images, azimuths=None, light_azimuths=None)


def claim(selection: Selection, images: ImageSet) -> None:
    """Writes settings.json. Raises ConfigError where the directory holds another selection."""
    path, wanted = selection.root / SETTINGS_FILE, _identity(selection, images)
    if path.exists():
        found = json.loads(path.read_text(encoding="utf-8"))
        differing = [f"{key} {found.get(key)!r}" for key, value in wanted.items() if found.get(key) != value]
        if differing:
            raise ConfigError(
                f"{selection.root} holds a selection of other options or pictures than these: there, {differing[0]}. "
                "Call with the same ones to go on with it, or name another --output."
            )
        return
    write_bytes(path, (json.dumps(wanted, indent=2) + "\n").encode())


def _identity(selection: Selection, images: ImageSet) -> dict[str, Any]:
    """Flat, and as JSON gives it back."""
    digest = hashlib.sha256(images.pictures.tobytes() + "\n".join(images.names).encode()).hexdigest()
    return {
        **_flat(to_mapping(selection.recipe)),
        "class": selection.category,
        "candidates": [candidate.name for candidate in selection.candidates],
        **selection.budget._asdict(),
        "samples": selection.samples,
        **_flat({"scene": to_mapping(images.scene)}),
        "pictures_sha256": digest,
    }


def _flat(settings: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    flat: dict[str, Any] = {}
    for name, value in settings.items():
        flat |= _flat(value, f"{prefix}{name}.") if isinstance(value, dict) else {f"{prefix}{name}": value}
    return flat
