"""How many faces a mesh file announces, told without loading it: some are too large to be tried."""

import json
import struct
from pathlib import Path

_HEADER = 65536
_PIECE = 2**24


def announced_faces(path: Path) -> int:
    """How many faces there are at least, by the file's header or a count of its lines; 0 where these do not tell.

    A polygon counts once. Raises OSError where the file cannot be read.
    """
    counts = {
        ".obj": _of_obj,
        ".ply": _of_ply,
        ".stl": _of_stl,
        ".off": _of_off,
        ".glb": _of_glb,
        ".gltf": _of_gltf,
    }
    try:
        return counts[path.suffix.lower()](path)
    except (ValueError, LookupError, TypeError, AttributeError, struct.error):
        # The file is not what its name says. Its reader finds better words for that.
        return 0


def _of_obj(path: Path) -> int:
    return _occurrences(path, b"\nf ")


def _of_ply(path: Path) -> int:
    with path.open("rb") as file:
        header = file.read(_HEADER).partition(b"end_header")[0]
    counts = [line.split()[2] for line in header.splitlines() if line.split()[:2] == [b"element", b"face"]]
    return int(counts[0])


def _of_stl(path: Path) -> int:
    with path.open("rb") as file:
        (count,) = struct.unpack("<80xI", file.read(84))
    return int(count) if path.stat().st_size == 84 + 50 * count else _occurrences(path, b"endfacet")


def _of_off(path: Path) -> int:
    with path.open("rb") as file:
        lines = file.read(_HEADER).splitlines()
    # OFF, or a relative such as COFF; then the numbers of vertices, faces and edges.
    words = b" ".join(line.partition(b"#")[0] for line in lines).split()
    return int(words[2])


def _of_glb(path: Path) -> int:
    with path.open("rb") as file:
        (length,) = struct.unpack("<12xI4x", file.read(20))
        return _of_document(file.read(length))


def _of_gltf(path: Path) -> int:
    return _of_document(path.read_bytes())


def _of_document(document: bytes) -> int:
    content = json.loads(document)
    corners = 0
    for mesh in content["meshes"]:
        for primitive in mesh["primitives"]:
            if primitive.get("mode", 4) == 4:
                accessor = primitive.get("indices", primitive["attributes"]["POSITION"])
                corners += content["accessors"][accessor]["count"]
    return corners // 3


def _occurrences(path: Path, mark: bytes) -> int:
    count, before = 0, b"\n"
    with path.open("rb") as file:
        while piece := file.read(_PIECE):
            joined = before + piece
            count += joined.count(mark)
            # A mark may begin in one piece and end in the next.
            before = joined[1 - len(mark) :]
    return count
