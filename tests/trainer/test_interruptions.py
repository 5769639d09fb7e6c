"""Ctrl-C ends a command with one sentence, whatever it interrupts, and leaves no half-written file."""

import os
import signal
from pathlib import Path

import pytest

from tests.trainer.command_line import SMALL, answer, opened, start, wait_for
from trainer.__main__ import main
from trainer.commands import render as render_command


@pytest.mark.parametrize("in_a_kernel", [False, True])
def test_ctrl_c_is_one_sentence(
    in_a_kernel: bool, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: object) -> None:
        try:
            raise KeyboardInterrupt
        except KeyboardInterrupt as ctrl_c:
            if in_a_kernel:
                raise SystemError("returned a result with an exception set") from ctrl_c
            raise

    monkeypatch.setattr(render_command, "render_folder", interrupted)
    status, output, errors = answer(capsys, "render", "--output", "out", "--class", "car")
    assert (status, output) == (130, "")
    assert errors == "interrupted; finished files are kept, and nothing is half-written "


def test_other_errors_of_the_system_are_not_taken_for_ctrl_c(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*_: object) -> None:
        raise SystemError("an internal call failed")

    monkeypatch.setattr(render_command, "render_folder", broken)
    with pytest.raises(SystemError, match="internal call"):
        main(["render", "--output", "out", "--class", "car"])


def test_ctrl_c_while_several_processes_render(tmp_path: Path) -> None:
    """A terminal sends the signal to all of them: one sentence, no traceback, and whole pictures only."""
    options = ["--class", "chair", "--instances", "4000", "--workers", "2", *SMALL]
    with start("render", "--output", tmp_path / "out", *options) as process:
        wait_for(process, lambda: any((tmp_path / "out").rglob("*.png")))
        os.killpg(process.pid, signal.SIGINT)
        output, errors = process.communicate(timeout=120)
    assert process.returncode == 130
    assert output == ""
    assert errors.endswith("interrupted; finished files are kept, and nothing is half-written\n")
    assert "Traceback" not in errors
    pictures = list((tmp_path / "out").rglob("*.png"))
    assert 0 < len(pictures) < 4000
    assert {opened(path).shape for path in pictures} == {(24, 32, 3)}
    assert not list((tmp_path / "out").rglob("*.part"))


def test_a_rendering_process_that_dies_is_told_and_the_same_command_goes_on(tmp_path: Path) -> None:
    command = ["render", "--output", tmp_path / "out", "--class", "chair", "--workers", "2", *SMALL, "--instances"]
    with start(*command, "4000") as process:
        wait_for(process, lambda: any((tmp_path / "out").rglob("*.png")))
        children = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
        # The other child keeps count of what the processes share.
        (worker,) = [pid for pid in children if b"spawn_main" in Path(f"/proc/{pid}/cmdline").read_bytes()]
        os.kill(int(worker), signal.SIGKILL)
        _, errors = process.communicate(timeout=120)
    assert process.returncode == 2
    assert "Traceback" not in errors
    assert "a rendering process was ended from outside" in errors
    drawn = len(list((tmp_path / "out").rglob("*.png")))
    assert 0 < drawn < 4000
    with start(*command, str(drawn + 8)) as process:
        assert process.wait(timeout=120) == 0
