"""ShapeNetCore, versions 1 and 2, as they are downloaded and unpacked.

    ROOT/02958343/<model>/model.obj                      version 1
    ROOT/02958343/<model>/models/model_normalized.obj    version 2
    ROOT/all.csv, or beside ROOT                         the official split, where it was downloaded, too

Its models stand upright along +Y and look towards -Z; ours look towards +Z.
"""

import csv
import hashlib
import logging
from pathlib import Path
from typing import Literal

from trainer.data.meshes import load_mesh
from trainer.data.shapes.catalogue import check_category
from trainer.data.shapes.solid import Mesh
from trainer.errors import DataError

Split = Literal["all", "train", "validation", "test"]

SYNSETS = {
    "airplane": "02691156",
    "bathtub": "02808440",
    "bench": "02828884",
    "car": "02958343",
    "chair": "03001627",
    "jar": "03593526",
    "lamp": "03636649",
    "loudspeaker": "03691459",
    "pot": "03991062",
    "rifle": "04090263",
    "sofa": "04256520",
    "table": "04379243",
    "vessel": "04530566",
}
"""The folder of each class: the offset of its synset in WordNet 3.0."""

SPLIT_FILE = "all.csv"

_FILES = ("model.obj", "models/model_normalized.obj")
_SPLIT_COLUMNS = ("synsetId", "modelId", "split")
_OFFICIAL: dict[str, Split] = {"train": "train", "val": "validation", "test": "test"}

logger = logging.getLogger(__name__)


def synset_of(category: str) -> str:
    """Raises ConfigError for a class that does not exist."""
    check_category(category)
    return SYNSETS[category]


def model_names(root: Path, synset: str, split: Split) -> list[str]:
    """The models of a class that belong to a part of the split, in order of their names.

    The official split decides where there is an all.csv in ROOT or beside it. Without it, and for models that it does
    not list (a warning counts them), a hash of the model's name does: 70 % train, 10 % validation, 20 % test, as in
    the official one; train and validation together are the paper's 80 %.

    Raises DataError where ROOT is not ShapeNetCore, lacks the class, or holds a split file that cannot be understood.
    """
    models = _folders(_class_folder(root, synset))
    if not any(_file(root / synset / model) for model in models):
        raise DataError(
            f"{root / synset}: expected a folder for each model of ShapeNetCore, with {' or '.join(_FILES)} in it, "
            f"found {f'none of these in {len(models)} folders' if models else 'no folder'}; for a folder of other "
            "meshes use --meshes"
        )
    if split == "all":
        return models
    official = _official_split(root, synset)
    if official is not None:
        unlisted = [model for model in models if model not in official]
        absent = set(official).difference(models)
        if unlisted:
            logger.warning(
                "%d of %d models are not in %s, and fall where a hash of their names puts them; first: %s",
                len(unlisted), len(models), SPLIT_FILE, unlisted[0],
            )  # fmt: skip
        if absent:
            logger.warning("%s lists %d models that are not there; first: %s", SPLIT_FILE, len(absent), min(absent))
    chosen = [model for model in models if (official or {}).get(model, hashed_split(model)) == split]
    if not chosen:
        raise DataError(f"{root / synset}: none of the {len(models)} models belongs to {split}; use another --split")
    return chosen


def hashed_split(model: str) -> Split:
    """Where a model belongs that no file assigns: by its name alone, hence the same everywhere."""
    share = int.from_bytes(hashlib.sha256(model.encode()).digest()[:8]) / 2**64
    return "train" if share < 0.7 else "validation" if share < 0.8 else "test"


def load_model(root: Path, synset: str, model: str) -> Mesh:
    """A model in our frame: centred, with a unit bounding-box diagonal, its front at +Z.

    Raises DataError where it is missing, as some are in either version, or cannot be read.
    """
    path = _file(root / synset / model)
    if path is None:
        raise DataError(f"{root / synset / model}: expected {' or '.join(_FILES)}, found neither; download it again")
    vertices, faces = load_mesh(path)
    return Mesh(vertices * (-1.0, 1.0, -1.0), faces)


def _file(model: Path) -> Path | None:
    return next((model / name for name in _FILES if (model / name).is_file()), None)


def _folders(folder: Path) -> list[str]:
    return sorted(entry.name for entry in folder.iterdir() if entry.is_dir() and not entry.name.startswith("."))


def _is_synset(name: str) -> bool:
    return len(name) == 8 and name.isdigit()


def _class_folder(root: Path, synset: str) -> Path:
    expected = f"expected ShapeNetCore at {root}, that is folders such as {synset}"
    if not root.is_dir():
        raise DataError(f"{expected}; found {'a file' if root.exists() else 'nothing'}; check the path")
    if (root / synset).is_dir():
        return root / synset
    if (root / f"{synset}.zip").is_file():
        raise DataError(f"{expected}; found {synset}.zip; unpack it there")
    if _is_synset(root.name):
        raise DataError(f"{expected}; found the folder of one class; name the folder above it, {root.parent}")
    names = _folders(root)
    synsets = [name for name in names if _is_synset(name)]
    if synsets:
        raise DataError(f"{expected}; found {', '.join(synsets[:5])}, but not this class; download {synset}")
    inner = [name for name in names if any(map(_is_synset, _folders(root / name)))]
    if inner:
        raise DataError(f"{expected}; found them one level further down; name {root / inner[0]}")
    found = ", ".join(names[:5]) or "no folder"
    raise DataError(f"{expected}; found {found}; check the path, or for a folder of other meshes use --meshes")


def _official_split(root: Path, synset: str) -> dict[str, Split] | None:
    """Where all.csv puts each model of a class, or None where there is no such file."""
    path = next((place for place in (root / SPLIT_FILE, root.parent / SPLIT_FILE) if place.is_file()), None)
    if path is None:
        return None
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            reader = csv.DictReader(file)
            missing = [column for column in _SPLIT_COLUMNS if column not in (reader.fieldnames or ())]
            if missing:
                raise DataError(
                    f"{path}: expected the columns {', '.join(_SPLIT_COLUMNS)}, found "
                    f"{', '.join(reader.fieldnames or ()) or 'an empty file'}; download it again, or remove it"
                )
            # A spreadsheet takes the leading zero of a synset away.
            rows = [
                (line, row) for line, row in enumerate(reader, start=2) if (row["synsetId"] or "").zfill(8) == synset
            ]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise DataError(
            f"{path}: expected a CSV file in UTF-8, found {error}; download it again, or remove it"
        ) from error
    return {row["modelId"] or "": _part(row["split"], f"{path}, line {line}") for line, row in rows}


def _part(name: str, where: str) -> Split:
    if name not in _OFFICIAL:
        raise DataError(f"{where}: expected a split of train, val or test, found {name!r}; correct it")
    return _OFFICIAL[name]
