"""Pictures in tar files of some thousand each, in the convention of WebDataset: for data that no folder should hold.

    OUT/scene.json               camera, lights, size
    OUT/render.json              the other settings
    OUT/shards.json              the shards, and how many pictures and objects each holds
    OUT/shard-000000.tar …       of each picture <key>.png and <key>.json (metadata.csv's columns)

All pictures of an object are in one shard.
"""

import io
import json
import math
import tarfile
from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple

from trainer.data.metadata import Row
from trainer.data.writing import write_bytes
from trainer.errors import DataError

INDEX_FILE = "shards.json"
PICTURES = ("png", "jpg", "jpeg", "webp")


class Shard(NamedTuple):
    name: str
    pictures: int
    objects: int


def shard_name(number: int) -> str:
    return f"shard-{number:06d}.tar"


def write_shard(path: Path, samples: Iterable[tuple[Row, bytes]]) -> None:
    """Writes pictures (PNG) and what is known of each. The same samples make the same bytes. Raises StorageError."""
    content = io.BytesIO()
    with tarfile.open(fileobj=content, mode="w", format=tarfile.USTAR_FORMAT) as archive:
        for row, picture in samples:
            known = {name: value for name, value in row._asdict().items() if name != "file_name"}
            # To readers of this convention all before the first dot is the key.
            key = row.file_name.removesuffix(".png").replace(".", "_")
            for ending, part in (("png", picture), ("json", json.dumps(known).encode())):
                member = tarfile.TarInfo(f"{key}.{ending}")
                member.size = len(part)
                archive.addfile(member, io.BytesIO(part))
    write_bytes(path, content.getvalue())


def read_shard(path: Path) -> list[tuple[Row, bytes]]:
    """Each picture file of a shard and what is known of it. Raises DataError where it is none, or is cut short."""
    return [(row, picture) for row, picture in _samples(path, with_pictures=True)]


def rows_of(path: Path) -> list[Row]:
    """The same without the pictures, which are passed over."""
    return [row for row, _ in _samples(path, with_pictures=False)]


def _samples(path: Path, with_pictures: bool) -> list[tuple[Row, bytes]]:
    known: dict[str, dict[str, object]] = {}
    pictures: dict[str, bytes] = {}
    try:
        with path.open("rb") as file:
            # tarfile takes a file that was cut short for one that ends there.
            file.seek(-min(tarfile.BLOCKSIZE, path.stat().st_size), io.SEEK_END)
            if any(file.read()):
                raise ValueError("no end of the archive")
        with tarfile.open(path, "r:") as archive:
            for member in archive:
                part = archive.extractfile(member) if member.isfile() else None
                if part is None:
                    continue
                folder, _, name = member.name.rpartition("/")
                stem, _, ending = name.partition(".")
                key = f"{folder}/{stem}" if folder else stem
                if ending == "json":
                    known[key] = json.loads(part.read())
                elif ending in PICTURES:
                    pictures[key] = part.read() if with_pictures else b""
        return [(_row(key, known.get(key, {})), picture) for key, picture in pictures.items()]
    except (OSError, tarfile.TarError, ValueError, AttributeError) as error:
        raise DataError(
            f"{path}: expected a tar file of pictures and JSON, found something else ({error}). Render or copy it "
            "again."
        ) from error


def _row(key: str, known: dict[str, object]) -> Row:
    """Raises ValueError for an angle that is no number."""
    angles = []
    for name in ("azimuth_degrees", "light_azimuth_degrees"):
        value = known.get(name)
        if value is not None and (not isinstance(value, int | float) or not math.isfinite(value)):
            raise ValueError(f"{key}: expected a number of degrees as {name}, found {value!r}")
        angles.append(None if value is None else float(value))
    return Row(key, str(known.get("instance", key)), *angles)


def write_index(folder: Path) -> list[Shard]:
    """Counts what the shards hold, and writes that down. Raises DataError or StorageError."""
    shards = []
    for path in sorted(folder.glob("*.tar")):
        rows = rows_of(path)
        shards.append(Shard(path.name, len(rows), len({row.instance for row in rows})))
    content = {"shards": [shard._asdict() for shard in shards]}
    write_bytes(folder / INDEX_FILE, (json.dumps(content, indent=1) + "\n").encode())
    return shards


def read_index(folder: Path) -> list[Shard]:
    """The shards of a folder, counted where nobody has yet. Raises DataError where there is none, or one has gone."""
    path = folder / INDEX_FILE
    if not path.exists():
        if not any(folder.glob("*.tar")):
            raise DataError(
                f"expected shards (*.tar) in {folder}, found none; write some with `trainer render --shards`"
            )
        return write_index(folder)
    try:
        shards = [Shard(str(one["name"]), int(one["pictures"]), int(one["objects"])) for one in _listed(path)]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise DataError(f"{path}: expected a list of shards, found something else ({error}); delete it") from error
    gone = [shard.name for shard in shards if not (folder / shard.name).is_file()]
    if gone or not shards:
        raise DataError(
            f"{path} names {len(shards)} shards, of which {len(gone)} are not there; first: {', '.join(gone[:1])}. "
            f"Bring them back, or delete {INDEX_FILE} to do without them."
        )
    return shards


def _listed(path: Path) -> list[dict[str, Any]]:
    listed: list[dict[str, Any]] = json.loads(path.read_text())["shards"]
    return listed
