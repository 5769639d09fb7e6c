"""The whole road, on the commands that a user has: pictures → training → judge → bundle → service → GLB.

Everything goes through the command lines and through HTTP; nothing here knows how any of it works.
"""

import argparse
import json
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import httpx
import numpy as np
import trimesh
from command import run
from PIL import Image

from imaging.srgb import decode_table, encode
from trainer.config import SceneConfig
from trainer.data.meshes import load_mesh, mesh_files
from trainer.data.picture import draw
from trainer.data.shapes.solid import Mesh
from trainer.data.writing import write_bytes, write_png
from trainer.evaluation.sheet import write_sheet

CATEGORY = "car"
SIDES_DEGREES = (-45.0, 135.0)
SECONDS_TO_START = 60.0


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--output", type=Path, required=True, help="folder for everything that the demo makes")
    parser.add_argument(
        "--real-meshes", type=Path, default=Path("../shared/meshes") / CATEGORY, help="mesh files, if any"
    )
    parser.add_argument("--pictures", type=int, default=4000, help="training pictures, one of each object")
    parser.add_argument("--steps", type=int, default=0, help="training steps; 0 means the preset's")
    arguments = parser.parse_args()
    out: Path = arguments.output
    seconds: dict[str, float] = {}

    with timed("render", seconds):
        for seed, (name, count) in enumerate((("train", arguments.pictures), ("validation", 200), ("test", 200))):
            run("trainer", "render", "--class", CATEGORY, "--seed", seed, "--instances", count,
                "--output", out / "pictures" / name)  # fmt: skip
    with timed("train", seconds):
        steps = ["--optimiser.steps", arguments.steps] if arguments.steps else []
        run("trainer", "train", "--preset", "sharp", "--images", out / "pictures/train", "--run", out / "run",
            "--class", CATEGORY, *steps)  # fmt: skip
    judged = ["trainer", "evaluate", "--checkpoint", out / "run", "--validation", out / "pictures/validation"]
    with timed("evaluate", seconds):
        run(*judged, "--images", out / "pictures/test", "--output", out / "evaluation")
        if real := arguments.real_meshes.is_dir():
            run(*judged, "--meshes", arguments.real_meshes, "--output", out / "evaluation_real")
    with timed("export", seconds):
        run("exporter", "--checkpoint", out / "run", "--output", out / "models" / CATEGORY,
            "--metrics", out / "evaluation/metrics.json", "--images", out / "pictures/validation",
            "--samples-from", out / "pictures/train")  # fmt: skip
        run("trainer", "sample", "--checkpoint", out / "run", "--images", out / "pictures/train",
            "--output", out / "samples.png")  # fmt: skip
    unseen = {"test": sorted((out / "pictures/test").rglob("*.png"))[0]}
    if real:
        unseen["real"] = out / "real.png"
        picture, _ = draw(load_mesh(mesh_files(arguments.real_meshes)[0]), np.radians(40.0), 0.0, SceneConfig())
        write_png(unseen["real"], Image.fromarray(encode(picture)))
    with timed("serve", seconds), service(out / "models") as client:
        rows = []
        for name, path in unseen.items():
            glb, azimuth = reconstruct(client, path)
            target = out / ("reconstruction.glb" if name == "test" else f"reconstruction_{name}.glb")
            write_bytes(target, glb)
            rows.append(comparison(path, target, azimuth))
        for seed in (0, 1):
            sample = client.get("/sample", params={"seed": seed}).raise_for_status()
            write_bytes(out / f"sample_{seed}.glb", sample.content)
    titles = ["input", "reconstruction", *(f"from {side:+.0f}°" for side in SIDES_DEGREES)]
    write_sheet(out / "comparison.png", rows, titles)

    metrics = json.loads((out / "evaluation/metrics.json").read_text())
    if real:
        on_real = json.loads((out / "evaluation_real/metrics.json").read_text())
        for key in ("iou", "azimuth_error_degrees", "azimuth_accuracy", "mean_shape_iou"):
            metrics[f"{key}_real"] = on_real[key]
    metrics["seconds_per_stage"] = {stage: round(value, 1) for stage, value in seconds.items()}
    write_bytes(out / "metrics.json", (json.dumps(metrics, indent=2) + "\n").encode())
    print(summary(out, metrics))
    return 0


@contextmanager
def timed(stage: str, seconds: dict[str, float]) -> Iterator[None]:
    print(f"\n── {stage}", flush=True)
    began = time.monotonic()
    yield
    seconds[stage] = time.monotonic() - began


@contextmanager
def service(models: Path) -> Iterator[httpx.Client]:
    """A client of a service on a free port, from ready until the block ends."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    command = [sys.executable, "-m", "service", "--host", "127.0.0.1", "--port", str(port), "--models", str(models)]
    process = subprocess.Popen(command)
    try:
        deadline = time.monotonic() + SECONDS_TO_START
        with httpx.Client(base_url=f"http://127.0.0.1:{port}", timeout=30) as client:
            while True:
                try:
                    client.get("/readyz").raise_for_status()
                    break
                except httpx.HTTPError as error:
                    if process.poll() is not None or time.monotonic() > deadline:
                        raise SystemExit(f"the service did not become ready: {error}") from error
                    time.sleep(0.1)
            yield client
    finally:
        process.terminate()
        process.wait(timeout=30)


def reconstruct(client: httpx.Client, picture: Path) -> tuple[bytes, float]:
    """(GLB, azimuth in degrees) of a picture, through POST /reconstruct."""
    answer = client.post("/reconstruct", files={"image": picture.read_bytes()}).raise_for_status()
    return answer.content, float(answer.headers["chiaro-azimuth-degrees"])


def comparison(picture: Path, glb: Path, azimuth_degrees: float) -> list[np.ndarray]:
    """The input, the GLB from the same view, and the GLB from two other sides."""
    scene = SceneConfig()
    loaded = trimesh.load(glb, force="mesh", process=False)
    mesh = Mesh(np.asarray(loaded.vertices, np.float64), np.asarray(loaded.faces, np.int64))
    smooth = np.asarray(loaded.vertex_normals, np.float64)[mesh.faces]
    with Image.open(picture) as opened:
        given = decode_table()[np.asarray(opened.convert("RGB").resize((scene.width, scene.height)))]
    views = [
        draw(mesh, np.radians(angle), 0.0, scene, normals=smooth)[0] for angle in (azimuth_degrees, *SIDES_DEGREES)
    ]
    return [given, *views]


def summary(out: Path, metrics: dict[str, object]) -> str:
    lines = [
        "",
        f"{out}/metrics.json        IoU {metrics['iou']:.2f} (mean shape {metrics['mean_shape_iou']:.2f}), "
        f"azimuth error {metrics['azimuth_error_degrees']:.1f}°, within 30° {metrics['azimuth_accuracy']:.2f}, "
        "on unseen cars",
    ]
    if "iou_real" in metrics:
        lines.append(
            f"{'':{len(str(out))}}                     IoU {metrics['iou_real']:.2f}, azimuth error "
            f"{metrics['azimuth_error_degrees_real']:.1f}°, within 30° {metrics['azimuth_accuracy_real']:.2f}, "
            "on real meshes"
        )
    lines += [
        f"{out}/comparison.png      input | reconstruction from the same view | two other sides",
        f"{out}/reconstruction.glb  what POST /reconstruct answered: mesh, camera, lights",
        f"{out}/sample_0.glb        what GET /sample?seed=0 answered: an invented car (sample_1.glb another)",
        f"{out}/samples.png         six invented cars from four sides",
        f"{out}/evaluation/         the judge's figures and its contact sheet",
        f"{out}/models/             the bundle; serve it with: make serve MODELS={out}/models",
    ]
    return "\n".join(lines)


if __name__ == "__main__":
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        print("interrupted; make demo begins anew", file=sys.stderr)
        sys.exit(130)
