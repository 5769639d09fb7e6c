import subprocess
import sys

SCRIPT = """
import sys

class Blocked:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {"torch", "trainer", "exporter", "onnx", "trimesh", "scipy", "jaxtyping"}:
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
