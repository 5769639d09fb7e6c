"""Folders of meshes rendered: what cannot be read is skipped, and no picture is taken for another's."""

import shutil
from pathlib import Path

import pytest
import trimesh

from tests.trainer.data.test_render import SCENE, contents, run
from trainer.data.metadata import read_metadata
from trainer.data.plan import RenderSettings
from trainer.data.render import render_folder
from trainer.data.shapes.catalogue import make_shape
from trainer.errors import DataError


def test_meshes_that_cannot_be_read_are_named_and_skipped(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    meshes = tmp_path / "things"
    (meshes / "more").mkdir(parents=True)
    (meshes / "good.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    shutil.copy(meshes / "good.obj", meshes / "more" / "good.obj")
    (meshes / "bad.ply").write_text("nothing")
    report = render_folder(tmp_path / "out", RenderSettings(str(meshes)), SCENE, None, 2, 1, show_progress=False)
    assert (report.written, len(report.skipped)) == (4, 1)
    assert "bad.ply" in report.skipped[0]
    assert [record.message for record in caplog.records] == [f"skipped: {report.skipped[0]}"]
    names = [
        "things/good.obj-00.png",
        "things/good.obj-01.png",
        "things/more__good.obj-00.png",
        "things/more__good.obj-01.png",
    ]
    assert sorted(read_metadata(tmp_path / "out") or {}) == names
    assert sorted(name for name in contents(tmp_path / "out") if name.endswith(".png")) == names

    shutil.rmtree(meshes / "more")
    (meshes / "good.obj").unlink()
    with pytest.raises(DataError, match=r"none of the 1 meshes .* can be read"):
        render_folder(tmp_path / "none", RenderSettings(str(meshes)), SCENE, None, 2, 1, show_progress=False)


def test_what_was_drawn_of_a_mesh_that_broke_since_is_kept(tmp_path: Path) -> None:
    meshes, out = tmp_path / "meshes", tmp_path / "out"
    meshes.mkdir()
    for name in ("a.ply", "b.ply"):
        trimesh.Trimesh(*make_shape("chair", ord(name[0])), process=False).export(meshes / name)
    run(out, RenderSettings(str(meshes)), None, 1)
    (meshes / "b.ply").write_text("nothing")
    report = render_folder(out, RenderSettings(str(meshes)), SCENE, None, 2, 1, show_progress=False)
    assert (report.written, report.kept, len(report.skipped)) == (1, 1, 1)
    rows = read_metadata(out)
    assert rows is not None
    assert sorted(rows) == sorted(path.relative_to(out).as_posix() for path in out.rglob("*.png"))
    assert len(rows) == 3


def test_meshes_whose_pictures_would_have_one_name_are_refused(tmp_path: Path) -> None:
    (tmp_path / "meshes/a").mkdir(parents=True)
    for name in ("a/b.ply", "a__b.ply"):
        trimesh.Trimesh(*make_shape("chair", 0), process=False).export(tmp_path / "meshes" / name)
    with pytest.raises(DataError, match=r"found a/b\.ply and a__b\.ply, both .*a__b\.ply-00\.png; rename"):
        run(tmp_path / "out", RenderSettings(str(tmp_path / "meshes")), None)
    assert not (tmp_path / "out").exists()
