"""The commands of docs/api.md do what the page says."""

import json
import re
import shlex
import subprocess
from pathlib import Path

import pytest

TEXT = (Path(__file__).parents[2] / "docs" / "api.md").read_text()
COMMANDS = [line for line in TEXT.splitlines() if line.startswith("curl ")]
ADDRESS = "http://127.0.0.1:8000"


def test_there_is_a_command_for_every_answer_and_form() -> None:
    assert len(COMMANDS) >= 9
    for path in ("reconstruct", "sample", "decode", "interpolate", "categories"):
        assert any(f"{ADDRESS}/v1/{path}" in command for command in COMMANDS), path
    assert any("image/png" in command for command in COMMANDS)
    assert any("application/json" in command for command in COMMANDS)


@pytest.mark.parametrize("command", COMMANDS)
def test_a_command_gets_what_it_asks_for(server: str, picture: bytes, tmp_path: Path, command: str) -> None:
    for name in re.findall(r"@(\S+\.png)", command):
        (tmp_path / name).write_bytes(picture)
    arguments = shlex.split(command.replace(ADDRESS, server))
    result = subprocess.run(
        [*arguments, "--fail-with-body", "--silent", "--show-error"], cwd=tmp_path, capture_output=True, check=False
    )
    assert result.returncode == 0, result.stdout + result.stderr
    if "-o" in arguments:
        content = (tmp_path / arguments[arguments.index("-o") + 1]).read_bytes()
        assert content.startswith(b"\x89PNG" if "image/png" in command else b"glTF")
    else:
        assert set(json.loads(result.stdout)) >= ({"categories"} if "categories" in command else {"shape_code"})
