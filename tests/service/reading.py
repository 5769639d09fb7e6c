"""How the tests read GLB files."""

import json
import struct
from typing import Any

import numpy as np


def document_of(glb: bytes) -> dict[str, Any]:
    """The document of a GLB, its container checked on the way (glTF 2.0, section 4.4)."""
    magic, version, length = struct.unpack_from("<4sII", glb)
    assert (magic, version, length) == (b"glTF", 2, len(glb))
    size, kind = struct.unpack_from("<I4s", glb, 12)
    assert kind == b"JSON"
    assert size % 4 == 0
    document: dict[str, Any] = json.loads(glb[20 : 20 + size])
    return document


def array_of(glb: bytes, accessor: int) -> np.ndarray:
    """The content of an accessor: vectors of floats [count, 3], or indices of two bytes [count]."""
    document = document_of(glb)
    described = document["accessors"][accessor]
    view = document["bufferViews"][described["bufferView"]]
    (size,) = struct.unpack_from("<I", glb, 12)
    start = 20 + size + 8 + view["byteOffset"] + described["byteOffset"]
    vectors = described["type"] == "VEC3"
    assert described["componentType"] == (5126 if vectors else 5123)
    assert not vectors or view["byteStride"] == 12
    found = np.frombuffer(glb, "<f4" if vectors else "<u2", described["count"] * (3 if vectors else 1), start)
    return found.reshape(-1, 3) if vectors else found


def vertices_of(glb: bytes, mesh: int = 0) -> np.ndarray:
    """The vertices of a mesh [V, 3]."""
    return array_of(glb, document_of(glb)["meshes"][mesh]["primitives"][0]["attributes"]["POSITION"])


def rotation_matrix(quaternion: list[float]) -> np.ndarray:
    """Of a unit quaternion x, y, z, w."""
    x, y, z, w = quaternion
    assert abs(x * x + y * y + z * z + w * w - 1) < 1e-12
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
