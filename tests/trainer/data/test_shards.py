"""Pictures in tar files: what is written is read again, and a training that reads them while it goes is repeatable."""

import io
import json
import shutil
import tarfile
from contextlib import closing
from dataclasses import replace
from itertools import islice
from pathlib import Path

import numpy as np
import pytest

from imaging.framing import frame_of
from tests.trainer.command_line import SMALL, answer
from trainer import processes
from trainer.config import SceneConfig
from trainer.data.decoding import Decoded, decode_content
from trainer.data.images import load_image_folder
from trainer.data.plan import RenderSettings
from trainer.data.render import RenderReport, render_folder
from trainer.data.shards import INDEX_FILE, read_index, read_shard, rows_of
from trainer.data.source import Minibatch
from trainer.data.streaming import ShardPictures, open_shards
from trainer.errors import DataError
from trainer.training.checkpoint import load_checkpoint

SCENE = SceneConfig(32, 24)
SETTINGS = RenderSettings("chair", seed=3, supersampling=2, shard_pictures=6)


def _render(folder: Path, settings: RenderSettings = SETTINGS, instances: int = 10) -> RenderReport:
    return render_folder(folder, settings, SCENE, instances, 2, 1, show_progress=False)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Ten chairs, two pictures each: three shards of three objects and one of one."""
    folder = tmp_path_factory.mktemp("shards") / "chair"
    assert _render(folder).written == 20
    return folder


@pytest.fixture
def source(folder: Path) -> ShardPictures:
    return open_shards(folder, 32, 24, SCENE, 0.25, 2)


def test_shards_hold_what_a_folder_would(folder: Path, tmp_path: Path) -> None:
    _render(tmp_path, replace(SETTINGS, shard_pictures=0))
    loose = load_image_folder(tmp_path, 32, 24)
    frame = frame_of(32, 24, loose.scene.camera.distance, loose.scene.camera.field_of_view_degrees)
    assert [(shard.pictures, shard.objects) for shard in read_index(folder)] == [(6, 3), (6, 3), (6, 3), (2, 1)]
    found = [sample for shard in read_index(folder) for sample in read_shard(folder / shard.name)]
    assert [row.file_name + ".png" for row, _ in found] == list(loose.names)
    assert [row.instance for row, _ in found] == [loose.instance_names[number] for number in loose.instances]
    assert loose.azimuths is not None
    np.testing.assert_allclose([row.azimuth_degrees for row, _ in found], np.degrees(loose.azimuths), atol=1e-9)
    for (_, content), expected in zip(found, loose.pictures, strict=True):
        decoded = decode_content(content, "one", frame, framed=True)
        assert isinstance(decoded, Decoded)
        np.testing.assert_array_equal(decoded.codes, expected)


def test_finished_shards_stay_and_an_unfinished_one_is_drawn_again(tmp_path: Path) -> None:
    assert _render(tmp_path, instances=4).written == 8
    before = (tmp_path / "shard-000000.tar").stat().st_mtime_ns
    report = _render(tmp_path, instances=7)
    # The second held one object, and now holds three.
    assert (report.written, report.kept) == (8, 6)
    assert (tmp_path / "shard-000000.tar").stat().st_mtime_ns == before
    assert [shard.pictures for shard in read_index(tmp_path)] == [6, 6, 2]


def test_shards_and_single_files_do_not_mix(tmp_path: Path) -> None:
    _render(tmp_path, instances=2)
    with pytest.raises(DataError, match="shard_pictures"):
        _render(tmp_path, replace(SETTINGS, shard_pictures=0), instances=2)


def _first(source: ShardPictures, count: int, start: int = 0, views: int = 1) -> list[Minibatch]:
    with closing(source.minibatches(4, 7, start, views)) as minibatches:
        return list(islice(minibatches, count))


def test_minibatches_depend_on_seed_and_step_alone(source: ShardPictures) -> None:
    assert (source.training, source.validation) == (18, 2)
    straight = _first(source, 12)
    for start in (1, 5, 11):
        for one, again in zip(straight[start:], _first(source, 12 - start, start), strict=True):
            assert one.pictures.equal(again.pictures)
            assert one.azimuths is not None
            assert again.azimuths is not None
            assert one.azimuths.equal(again.azimuths)
            assert one.generator.get_state().equal(again.generator.get_state())


def test_every_shard_comes_once_an_epoch_in_another_order(source: ShardPictures) -> None:
    orders = []
    for epoch in range(4):
        windows = list(source.windows(4, 7, epoch))
        assert [len(window.shards) for window in windows] == [2, 1]
        assert [window.steps for window in windows] == [3, 1]
        order = [shard.name for window in windows for shard in window.shards]
        assert sorted(order) == [shard.name for shard in source.shards]
        orders.append(order)
    assert len(set(map(tuple, orders))) > 1


def test_pictures_of_an_object_stay_together(source: ShardPictures) -> None:
    objects = {tuple(sorted(one)) for one in _pairs(source)}
    for batch in _first(source, 6, views=2):
        assert batch.azimuths is not None
        for pair in batch.azimuths.unflatten(0, (-1, 2)):
            assert tuple(sorted(round(float(azimuth), 4) for azimuth in pair)) in objects


def _pairs(source: ShardPictures) -> list[list[float]]:
    images = source.load(source.shards)
    assert images.azimuths is not None
    return [
        [round(float(azimuth), 4) for azimuth in images.azimuths[images.instances == number].astype(np.float32)]
        for number in range(len(images.instance_names))
    ]


def test_processes_read_shards_of_their_own(source: ShardPictures, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(processes, "count", lambda: 2)
    names = []
    for number in (0, 1):
        monkeypatch.setattr(processes, "number", lambda number=number: number)
        names.append({shard.name for window in source.windows(4, 7, 0) for shard in window.shards})
        (batch,) = _first(source, 1)
        assert len(batch.pictures) == 2
    assert not names[0] & names[1]
    assert names[0] | names[1] == {shard.name for shard in source.shards}


def test_more_processes_than_shards_are_refused(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(processes, "count", lambda: 4)
    with pytest.raises(DataError, match=r"for each of 4 processes, found 3"):
        open_shards(folder, 32, 24, SCENE, 0.25, 2)


def test_shards_from_elsewhere_need_no_index(folder: Path, tmp_path: Path, source: ShardPictures) -> None:
    """And may say nothing of their pictures."""
    with tarfile.open(tmp_path / "others.tar", "w") as archive:
        for number, (_, content) in enumerate(read_shard(folder / "shard-000000.tar")):
            member = tarfile.TarInfo(f"{number}.png")
            member.size = len(content)
            archive.addfile(member, io.BytesIO(content))
    (shard,) = read_index(tmp_path)
    assert (shard.pictures, shard.objects) == (6, 6)
    assert (tmp_path / INDEX_FILE).exists()
    assert open_shards(tmp_path, 32, 24, SCENE, 0.25, 2).load((shard,)).azimuths is None


def test_what_is_no_shard_is_named(folder: Path, tmp_path: Path) -> None:
    with pytest.raises(DataError, match=r"expected shards .* found none"):
        read_index(tmp_path)
    content = (folder / "shard-000000.tar").read_bytes()
    for broken in (content[: len(content) // 2], b"no tar at all", content[:512]):
        (tmp_path / "one.tar").write_bytes(broken)
        with pytest.raises(DataError, match=r"one\.tar: expected a tar file of pictures"):
            rows_of(tmp_path / "one.tar")
    (tmp_path / INDEX_FILE).write_text(json.dumps({"shards": [{"name": "two.tar", "pictures": 1, "objects": 1}]}))
    with pytest.raises(DataError, match=r"1 are not there; first: two\.tar"):
        read_index(tmp_path)
    (tmp_path / INDEX_FILE).write_text("[]")
    with pytest.raises(DataError, match="expected a list of shards"):
        read_index(tmp_path)


def test_a_picture_that_cannot_be_read_is_left_out(folder: Path, tmp_path: Path, source: ShardPictures) -> None:
    content = (folder / "shard-000000.tar").read_bytes()
    at = content.index(b"IDAT")
    (tmp_path / "one.tar").write_bytes(content[:at] + b"XXXX" + content[at + 4 :])
    images = open_shards(tmp_path, 32, 24, SCENE, 0.0, 1).load(tuple(read_index(tmp_path)))
    assert len(images) == 5
    assert len(images.skipped) == 1


def test_the_commands_write_read_and_resume_them(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    shards, directory = tmp_path / "shards", tmp_path / "run"
    objects = ["--class", "chair", *SMALL, "--instances", "8"]
    status, said, _ = answer(capsys, "render", *objects, "--shards", "4", "--output", shards)
    assert (status, "8 pictures written" in said) == (0, True)
    small = [*SMALL, "--optimiser.batch-size", "2", "--preset", "fast"]
    train = ["train", "--shards", shards, "--run", directory, "--class", "chair"]
    status, _, said = answer(capsys, *train, *small, "--shards-at-once", "3", "--optimiser.steps", "2")
    assert (status, "4 pictures in shards (1 of them, 1 held out)" in said) == (0, True)
    status, _, said = answer(capsys, "train", "--run", directory, "--resume", "--optimiser.steps", "3")
    assert (status, "finished at step 3" in said) == (0, True)
    assert load_checkpoint(directory).run["shards_at_once"] == 3  # What a step sees depends on it.
    status, _, said = answer(capsys, *train, "--shards-at-once", "0")
    assert (status, "--shards-at-once from 1 to 1024, found 0" in said) == (2, True)


def test_a_shard_that_vanishes_while_others_are_read_is_named(folder: Path, tmp_path: Path) -> None:
    there = Path(shutil.copytree(folder, tmp_path / "shards"))
    source = open_shards(there, 32, 24, SCENE, 0.25, 1)
    with closing(source.minibatches(6, 0, 0)) as minibatches:
        next(minibatches)
        gone = [shard.name for shard in source.shards]
        for name in gone:
            (there / name).unlink()
        with pytest.raises(DataError, match=r"shard-00000\d\.tar: expected a tar file .* No such file"):
            list(islice(minibatches, 20))


def test_a_training_goes_on_when_a_shard_is_back(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    shards, directory = tmp_path / "shards", tmp_path / "run"
    answer(capsys, "render", "--class", "chair", *SMALL, "--instances", "12", "--output", shards, "--shards", "4")
    settings = [*SMALL, "--optimiser.batch-size", "4", "--preset", "fast", "--reframing-share", "0"]
    train = ["train", "--shards", shards, "--run", directory, "--class", "chair", *settings]
    assert answer(capsys, *train, "--optimiser.steps", "1")[0] == 0
    (shards / "shard-000002.tar").rename(tmp_path / "elsewhere.tar")
    again = ["train", "--run", directory, "--resume", "--reframing-share", "0", "--optimiser.steps", "2"]
    status, _, said = answer(capsys, *again)
    assert (status, "1 are not there; first: shard-000002.tar. Bring them back" in said) == (2, True)
    assert load_checkpoint(directory).step == 1
    (tmp_path / "elsewhere.tar").rename(shards / "shard-000002.tar")
    status, _, said = answer(capsys, *again)
    assert (status, "finished at step 2" in said) == (0, True)
