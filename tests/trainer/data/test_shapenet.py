"""ShapeNetCore on disk, as both versions unpack: its models, its axes, its split, and what is not ShapeNetCore."""

import logging
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from trainer.data.plan import RenderSettings, category_of, instance_names, load_instance
from trainer.data.shapenet import SYNSETS, Split, hashed_split, load_model, model_names, synset_of
from trainer.data.shapes.catalogue import CATEGORIES
from trainer.errors import ConfigError, DataError

CAR = "02958343"
NAMES = [f"{number:032x}" for number in range(40)]
# A spire at the back right, seen as ShapeNet has it: up +y, front -z, hence the model's own right at +x.
SPIRE = "v 0 0 0\nv 1 0 0\nv 1 0 2\nv 0 0 2\nv 1 1 2\nl 1 2\nusemtl paint\nf 1 2 3 4\nf 2 3 5\n"
PARTS: tuple[Split, ...] = ("train", "validation", "test")


def tree(root: Path, version: int, names: list[str] = NAMES, synset: str = CAR) -> Path:
    for name in names:
        folder = root / synset / name
        if version == 1:
            (folder / "images").mkdir(parents=True)
            path = folder / "model.obj"
        else:
            (folder / "models").mkdir(parents=True)
            (folder / "screenshots").mkdir()
            path = folder / "models" / "model_normalized.obj"
        path.write_text(f"mtllib {path.stem}.mtl\n{SPIRE}")
    return root


def table(rows: list[str], columns: str = "id,synsetId,subSynsetId,modelId,split") -> str:
    return "\n".join([columns, *rows]) + "\n"


@pytest.mark.parametrize("version", [1, 2])
def test_models_of_either_version_are_turned_to_our_front(tmp_path: Path, version: int) -> None:
    tree(tmp_path, version)
    assert model_names(tmp_path, CAR, "all") == NAMES
    mesh = load_model(tmp_path, CAR, NAMES[3])
    spire = mesh.vertices[np.argmax(mesh.vertices[:, 1])]
    # Ours: up +y, front +z, hence the own right at -x. Turned, not mirrored.
    np.testing.assert_allclose(spire, np.array([-0.5, 0.5, -1.0]) / np.sqrt(6), atol=1e-9)


def test_a_rendering_knows_its_models_by_name(tmp_path: Path) -> None:
    tree(tmp_path, 2)
    settings = RenderSettings(str(tmp_path), synset=CAR, split="test")
    names = instance_names(settings, None)
    assert names == model_names(tmp_path, CAR, "test")
    assert instance_names(settings, 2) == names[:2]
    assert category_of(settings) == "car"
    np.testing.assert_array_equal(
        load_instance(settings, names[0]).vertices, load_model(tmp_path, CAR, names[0]).vertices
    )


def test_shapenet_as_an_ordinary_folder_is_warned_of(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    tree(tmp_path, 2)
    assert len(instance_names(RenderSettings(str(tmp_path)), None)) == 40
    assert caplog.messages == [
        f"{tmp_path} looks like ShapeNetCore, whose front is -z: with --shapenet it would be turned"
    ]


def test_without_a_file_a_hash_splits_by_the_name_alone(tmp_path: Path) -> None:
    tree(tmp_path, 1)
    parts = [model_names(tmp_path, CAR, part) for part in PARTS]
    assert sorted(name for part in parts for name in part) == NAMES
    assert all(parts)
    tree(tmp_path / "fewer", 2, NAMES[:30], "03001627")
    assert model_names(tmp_path / "fewer", "03001627", "test") == [name for name in parts[2] if name in NAMES[:30]]
    # Written down, so that no later version of the hash moves a model from one side to the other.
    assert [hashed_split(name) for name in "abhg"] == ["validation", "train", "train", "test"]
    shares = Counter(hashed_split(f"{number:032x}") for number in range(10_000))
    for part, share in zip(PARTS, (0.7, 0.1, 0.2), strict=True):
        assert abs(shares[part] / 10_000 - share) < 0.015


@pytest.mark.parametrize("above", [False, True])
def test_the_official_split_decides_and_disagreements_are_counted(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, above: bool
) -> None:
    root = tree(tmp_path / "ShapeNetCore", 2)
    parts = ["train", "val", "test", "test"]
    # A spreadsheet took the leading zero away; a model of another class has the same name; two are not on the disk.
    rows = [f"{number},2958343,2958343,{name},{parts[number % 4]}" for number, name in enumerate(NAMES[:36])]
    rows += [f"90,03001627,03001627,{NAMES[0]},test", f"91,02958343,02958343,{'f' * 32},test"]
    rows += [f"92,02958343,02958343,{'e' * 32},test"]
    (root.parent if above else root).joinpath("all.csv").write_text(table(rows))
    unlisted = {name: hashed_split(name) for name in NAMES[36:]}
    for part, expected in (
        ("train", NAMES[:36:4]),
        ("validation", NAMES[1:36:4]),
        ("test", NAMES[2:36:4] + NAMES[3:36:4]),
    ):
        more = [name for name, where in unlisted.items() if where == part]
        assert model_names(root, CAR, part) == sorted([*expected, *more])
    assert [record.levelno for record in caplog.records] == [logging.WARNING] * 6
    assert caplog.messages[0].startswith("4 of 40 models are not in all.csv, and fall where a hash of their names puts")
    assert caplog.messages[1] == f"all.csv lists 2 models that are not there; first: {'e' * 32}"
    caplog.clear()
    assert model_names(root, CAR, "all") == NAMES
    assert not caplog.messages


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("", "expected the columns synsetId, modelId, split, found an empty file"),
        (table([], "id,modelId,split"), "found id, modelId, split; download it again"),
        (
            table([f"1,{CAR},{CAR},{NAMES[0]},training"]),
            "line 2: expected a split of train, val or test, found 'training'",
        ),
        (table([f"1,{CAR}"]), "line 2: expected a split of train, val or test, found None"),
    ],
)
def test_a_split_file_that_cannot_be_understood_is_named(tmp_path: Path, content: str, message: str) -> None:
    tree(tmp_path, 2)
    (tmp_path / "all.csv").write_text(content)
    with pytest.raises(DataError, match=message):
        model_names(tmp_path, CAR, "train")


def test_a_split_file_that_is_no_text_is_named(tmp_path: Path) -> None:
    tree(tmp_path, 2)
    (tmp_path / "all.csv").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(DataError, match="expected a CSV file in UTF-8"):
        model_names(tmp_path, CAR, "test")


def test_what_is_not_shapenet_is_told_with_what_to_do(tmp_path: Path) -> None:
    def said(root: Path) -> str:
        with pytest.raises(DataError) as refusal:
            model_names(root, CAR, "all")
        return str(refusal.value)

    assert "found nothing; check the path" in said(tmp_path / "absent")
    (tmp_path / "file").write_text("x")
    assert "found a file" in said(tmp_path / "file")
    (tmp_path / "empty").mkdir()
    assert "found no folder; check the path, or for a folder of other meshes use --meshes" in said(tmp_path / "empty")
    (tmp_path / "other" / "chairs").mkdir(parents=True)
    assert "found chairs; check the path" in said(tmp_path / "other")
    (tmp_path / "zipped").mkdir()
    (tmp_path / "zipped" / f"{CAR}.zip").write_bytes(b"PK")
    assert f"found {CAR}.zip; unpack it there" in said(tmp_path / "zipped")
    tree(tmp_path / "chairs", 1, NAMES[:2], "03001627")
    assert f"found 03001627, but not this class; download {CAR}" in said(tmp_path / "chairs")
    assert f"name the folder above it, {tmp_path / 'chairs'}" in said(tmp_path / "chairs" / "03001627")
    tree(tmp_path / "outer" / "ShapeNetCore.v2", 2, NAMES[:2])
    assert f"found them one level further down; name {tmp_path / 'outer/ShapeNetCore.v2'}" in said(tmp_path / "outer")
    (tmp_path / "hollow" / CAR / "a").mkdir(parents=True)
    assert "model_normalized.obj in it, found none of these in 1 folders" in said(tmp_path / "hollow")


def test_a_model_without_its_file_is_named(tmp_path: Path) -> None:
    """ShapeNetCore has some."""
    tree(tmp_path, 2, NAMES[:2])
    (tmp_path / CAR / NAMES[1] / "models" / "model_normalized.obj").unlink()
    assert model_names(tmp_path, CAR, "all") == NAMES[:2]
    with pytest.raises(DataError, match=rf"{NAMES[1]}: expected model.obj or .*, found neither; download it again"):
        load_model(tmp_path, CAR, NAMES[1])


def test_a_part_without_models_is_told(tmp_path: Path) -> None:
    name = next(name for name in NAMES if hashed_split(name) == "train")
    tree(tmp_path, 2, [name])
    with pytest.raises(DataError, match="none of the 1 models belongs to test; use another --split"):
        model_names(tmp_path, CAR, "test")


def test_every_class_has_its_synset() -> None:
    assert SYNSETS.keys() == CATEGORIES.keys()
    assert len(set(SYNSETS.values())) == 13
    assert synset_of("car") == CAR
    with pytest.raises(ConfigError, match="found 'caar'; did you mean 'car'"):
        synset_of("caar")
