import os
import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = """
import sys

class Blocked:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {"torch", "trainer", "exporter", "onnx", "trimesh", "scipy", "jaxtyping", "numba"}:
            raise ImportError(f"{name} is blocked")

sys.meta_path.insert(0, Blocked())
import pkgutil, importlib, service
names = [module.name for module in pkgutil.walk_packages(service.__path__, "service.")]
for name in names:
    importlib.import_module(name)
print(len(names))
try:
    import torch
except ImportError as error:
    print(error)
"""


def test_service_imports_without_torch_trainer_and_exporter() -> None:
    result = subprocess.run([sys.executable, "-c", SCRIPT], capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    count, blocked = result.stdout.splitlines()
    assert int(count) >= 15
    assert blocked == "torch is blocked"


SERVICE_PYTHON = Path(__file__).parents[2] / ".venv-service/bin/python"
DRIVER = """
import importlib.util, json, subprocess, sys, time, urllib.error, urllib.request
assert not any(map(importlib.util.find_spec, ("torch", "numba", "onnx", "trimesh"))), "more is installed than the service needs"
process = subprocess.Popen([sys.executable, "-m", "service", "--port", "0", "--models", sys.argv[1]], stdout=subprocess.PIPE, text=True)
try:
    address = process.stdout.readline().split()[3]
    for _ in range(1000):
        try:
            urllib.request.urlopen(address + "/readyz").read()
            break
        except urllib.error.HTTPError:
            time.sleep(0.02)
    print(urllib.request.urlopen(address + "/sample?seed=1").read()[:4])
finally:
    process.terminate()
    process.wait(20)
"""  # noqa: E501


@pytest.mark.skipif(not SERVICE_PYTHON.exists(), reason="there is no .venv-service; make install-service makes it")
def test_service_answers_in_an_environment_without_torch(bundle_directory: Path, tmp_path: Path) -> None:
    command = [str(SERVICE_PYTHON), "-c", DRIVER, str(bundle_directory)]
    result = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path, timeout=60)
    assert result.stdout == "b'glTF'\n", result.stderr


@pytest.mark.parametrize("module", ["service.inference", "exporter.parity", "trainer.evaluation.bundle"])
def test_nothing_is_told_to_others_and_nothing_written(module: str, tmp_path: Path) -> None:
    """onnxruntime would begin a file for its telemetry as soon as it is imported."""
    environment = {name: value for name, value in os.environ.items() if name != "ORT_DISABLE_TELEMETRY"}
    subprocess.run([sys.executable, "-c", f"import {module}"], check=True, env=environment | {"TMPDIR": str(tmp_path)})
    assert not list(tmp_path.iterdir())
