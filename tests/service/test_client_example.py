"""The Python client of the README does what it says, and tells what the service refuses."""

import re
import subprocess
import sys
from pathlib import Path

PROGRAM = re.findall(r"```python\n(.*?)```", (Path(__file__).parents[2] / "README.md").read_text(), re.DOTALL)


def run(server: str, folder: Path, picture: bytes) -> subprocess.CompletedProcess[str]:
    (folder / "car.png").write_bytes(picture)
    (program,) = PROGRAM
    command = [sys.executable, "-c", program.replace("http://127.0.0.1:8000", server)]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=60, check=False)


def test_it_writes_the_mesh_and_tells_the_pose(server: str, picture: bytes, tmp_path: Path) -> None:
    result = run(server, tmp_path, picture)
    assert (result.returncode, result.stderr) == (0, "")
    assert re.match(r"car -?\d+\.\d+ \[\{'azimuth_degrees': -?\d", result.stdout)
    assert (tmp_path / "car.glb").read_bytes().startswith(b"glTF")


def test_it_tells_what_is_refused(server: str, tmp_path: Path) -> None:
    result = run(server, tmp_path, b"no picture")
    assert result.returncode == 1
    assert result.stderr.startswith("expected a picture, found 10 bytes")
    assert not (tmp_path / "car.glb").exists()
