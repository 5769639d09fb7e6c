"""A long stream of pictures from tar files: pictures per second and memory, while nobody trains on them.

`python -m benchmarks.streaming` writes streaming.json. A few thousand pictures are drawn, and their shards are linked
under as many names as it takes.
"""

import datetime
import json
import os
import shlex
import sys
import time
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import tyro
from rich.console import Console

from benchmarks.machine import machine, versions
from trainer.config import SceneConfig
from trainer.data.plan import RenderSettings
from trainer.data.render import render_folder
from trainer.data.shards import INDEX_FILE, Shard, read_index, shard_name
from trainer.data.streaming import open_shards


@dataclass(frozen=True)
class Options:
    """Options of the benchmark."""

    output: Path = Path("benchmarks")
    """Folder for streaming.json."""
    pictures: int = 100_000
    """Pictures that are streamed."""
    drawn: int = 4000
    """Different pictures among them."""
    shard: int = 1000
    """Pictures in a shard."""
    batch: int = 64
    """Pictures of a minibatch."""
    width: int = 64
    """Width at which is trained, pixels; pictures are twice as large."""
    height: int = 48
    """Height at which is trained, pixels."""


def main() -> None:
    options = tyro.cli(Options, prog="python -m benchmarks.streaming", description=__doc__)
    console = Console(stderr=True)
    with TemporaryDirectory() as name:
        folder = Path(name)
        scene = SceneConfig(2 * options.width, 2 * options.height)
        settings = RenderSettings("car", shard_pictures=options.shard)
        render_folder(folder, settings, scene, options.drawn)
        shards = linked(folder, read_index(folder), options.pictures)
        console.print(f"{len(shards)} shards of {options.shard} pictures")
        source = open_shards(folder, options.width, options.height, scene, 0.0, 8)
        begun, memory, seen = time.perf_counter(), [], 0
        with closing(source.minibatches(options.batch, 0, 0)) as minibatches:
            for batch in minibatches:
                seen += len(batch.pictures)
                if len(memory) < 20 * seen // options.pictures:
                    memory.append(round(resident_mebibytes(), 1))
                if seen >= options.pictures:
                    break
        seconds = time.perf_counter() - begun
    report = {
        "date": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        "machine": machine(),
        "versions": versions(),
        "command": shlex.join(["python", "-m", "benchmarks.streaming", *sys.argv[1:]]),
        "pictures": seen,
        "size": [options.width, options.height],
        "shards": len(shards),
        "pictures_per_second": round(seen / seconds, 1),
        "resident_mib_at_each_twentieth": memory,
    }
    options.output.mkdir(parents=True, exist_ok=True)
    (options.output / "streaming.json").write_text(json.dumps(report, indent=1) + "\n")
    console.print(f"written: {options.output / 'streaming.json'}")


def linked(folder: Path, shards: list[Shard], pictures: int) -> list[Shard]:
    """Shards that hold so many pictures, each a name of one of these."""
    found = list(shards)
    while sum(shard.pictures for shard in found) < pictures:
        of = shards[len(found) % len(shards)]
        found.append(of._replace(name=shard_name(len(found))))
        os.link(folder / of.name, folder / found[-1].name)
    (folder / INDEX_FILE).write_text(json.dumps({"shards": [shard._asdict() for shard in found]}))
    return found


def resident_mebibytes() -> float:
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 2**20


if __name__ == "__main__":
    main()
