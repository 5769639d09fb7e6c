"""Writing a mesh with its camera and lights as a GLB file (glTF 2.0, section 4: binary container)."""

import json
import math
import struct
from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import chain
from typing import Any, Final

import numpy as np

from service.inference import Surface
from service.manifest import Manifest
from service.view import camera_node, directional_lights, light_nodes, perspective

_FLOAT: Final = 5126
_UNSIGNED_SHORT: Final = 5123
_UNSIGNED_INT: Final = 5125
_ARRAY_BUFFER: Final = 34962
_ELEMENT_ARRAY_BUFFER: Final = 34963
_JSON_CHUNK: Final = 0x4E4F534A
_BINARY_CHUNK: Final = 0x004E4942
_SPACING: Final = 1.15
"""From the middle of one of several objects to the next one's, diagonals."""


def write_glb(
    surface: Surface,
    manifest: Manifest,
    azimuth: float,
    extras: dict[str, Any],
    light_azimuth: float = 0.0,
    further_azimuths: Sequence[float] = (),
) -> bytes:
    """A GLB of the surface in its own frame (+Z front), seen by its picture's camera under its picture's lights.

    `azimuth` is the object's turn in that picture, `light_azimuth` that of the lights, radians; each of
    `further_azimuths` adds the camera of another picture. A block of the manifest is a node; `extras` stands on the
    scene. The material is white, matt and double-sided, and has no specular part: it shades as the model does.
    """
    names = [block.name for block in manifest.blocks]
    blocks = [{"name": name, "mesh": number} for number, name in enumerate(names)]
    lights = light_nodes(manifest.lights, azimuth, light_azimuth)
    cameras = [
        {**camera_node(manifest.camera, turn), "name": "camera" if number == 1 else f"camera {number}"}
        for number, turn in enumerate((azimuth, *further_azimuths), 1)
    ]
    nodes = [*blocks, *cameras, *lights]
    return _write([surface], [names], manifest, nodes, range(len(nodes)), extras)


def write_row_glb(
    surfaces: Sequence[Surface],
    names: Sequence[str],
    manifest: Manifest,
    azimuth: float,
    extras: dict[str, Any],
) -> bytes:
    """A GLB of several surfaces side by side, row behind row, each a node with a name of its own and its blocks below.

    The camera stands as for one of them, turned by `azimuth`, and so far away that all are seen. Otherwise as
    `write_glb`.
    """
    count, blocks = len(surfaces), len(manifest.blocks)
    across = math.ceil(math.sqrt(count))
    stands = [
        {
            "name": name,
            "translation": _place(number, across, math.ceil(count / across)),
            "children": [count + blocks * number + block for block in range(blocks)],
        }
        for number, name in enumerate(names)
    ]
    mesh_names = [[f"{name} {block.name}" for block in manifest.blocks] for name in names]
    parts = [{"name": name, "mesh": number} for number, name in enumerate(chain.from_iterable(mesh_names))]
    camera = replace(manifest.camera, distance=manifest.camera.distance * _SPACING * across)
    others = [camera_node(camera, azimuth), *light_nodes(manifest.lights, azimuth, 0.0)]
    roots = [*range(count), *range(count + len(parts), count + len(parts) + len(others))]
    return _write(surfaces, mesh_names, manifest, [*stands, *parts, *others], roots, extras)


def _place(number: int, across: int, rows: int) -> list[float]:
    """Where one of several objects stands: from left to right, from the back to the front."""
    row, column = divmod(number, across)
    return [_SPACING * (column - (across - 1) / 2), 0.0, _SPACING * (row - (rows - 1) / 2)]


def _write(
    surfaces: Sequence[Surface],
    mesh_names: Sequence[Sequence[str]],
    manifest: Manifest,
    nodes: list[dict[str, Any]],
    roots: Iterable[int],
    extras: dict[str, Any],
) -> bytes:
    """The file: a mesh for each surface and block, in that order; all share the faces."""
    indices, index_bytes = _indices(manifest.faces, manifest.vertices)
    vertices = np.ascontiguousarray([surface.vertices for surface in surfaces], "<f4").tobytes()
    normals = np.ascontiguousarray([surface.normals for surface in surfaces], "<f4").tobytes()
    buffer = _pad(vertices + normals + indices, b"\0")
    lit = ["KHR_lights_punctual"] if manifest.lights else []
    document = {
        "asset": {"version": "2.0", "generator": "chiaro"},
        "extensionsUsed": ["KHR_materials_specular", *lit],
        "scene": 0,
        "scenes": [{"name": manifest.category, "nodes": list(roots), "extras": extras}],
        "nodes": nodes,
        "cameras": [perspective(manifest.camera, manifest.picture.width / manifest.picture.height)],
        "meshes": [
            {"name": name, "primitives": [_primitive(2 * surface, 2 * len(surfaces) + block)]}
            for surface, names in enumerate(mesh_names)
            for block, name in enumerate(names)
        ],
        "materials": [_material(manifest)],
        "accessors": _accessors(surfaces, manifest, index_bytes),
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": len(vertices), "byteStride": 12, "target": _ARRAY_BUFFER},
            {
                "buffer": 0,
                "byteOffset": len(vertices),
                "byteLength": len(normals),
                "byteStride": 12,
                "target": _ARRAY_BUFFER,
            },
            {
                "buffer": 0,
                "byteOffset": len(vertices) + len(normals),
                "byteLength": len(indices),
                "target": _ELEMENT_ARRAY_BUFFER,
            },
        ],
        "buffers": [{"byteLength": len(buffer)}],
    }
    if lit:
        document["extensions"] = {"KHR_lights_punctual": {"lights": directional_lights(manifest.lights)}}
    return _pack(document, buffer)


def _primitive(first: int, indices: int) -> dict[str, Any]:
    return {"attributes": {"POSITION": first, "NORMAL": first + 1}, "indices": indices, "material": 0}


@lru_cache(maxsize=64)
def _indices(faces: tuple[tuple[int, int, int], ...], vertices: int) -> tuple[bytes, int]:
    """The corners of faces, and the bytes of each: two where they suffice (glTF keeps 65535 free), else four."""
    corners = np.array(faces, "<u2" if vertices < 65536 else "<u4")
    return corners.tobytes(), corners.itemsize


def _material(manifest: Manifest) -> dict[str, Any]:
    return {
        "name": "matt white",
        "doubleSided": True,
        "pbrMetallicRoughness": {
            "baseColorFactor": [1.0, 1.0, 1.0, 1.0],
            "metallicFactor": 0.0,
            "roughnessFactor": 1.0,
        },
        # glTF has no ambient light; on a white surface it is the same as a glow.
        "emissiveFactor": [min(1.0, value) for value in manifest.ambient],
        "extensions": {"KHR_materials_specular": {"specularFactor": 0.0}},
    }


def _accessors(surfaces: Sequence[Surface], manifest: Manifest, index_bytes: int) -> list[dict[str, Any]]:
    vector = {"componentType": _FLOAT, "count": manifest.vertices, "type": "VEC3"}
    vectors = [
        accessor
        for number, surface in enumerate(surfaces)
        for accessor in (
            {
                **vector,
                "bufferView": 0,
                "byteOffset": 12 * manifest.vertices * number,
                "min": surface.vertices.min(0).tolist(),
                "max": surface.vertices.max(0).tolist(),
            },
            {**vector, "bufferView": 1, "byteOffset": 12 * manifest.vertices * number},
        )
    ]
    indices = [
        {
            "bufferView": 2,
            "byteOffset": 3 * index_bytes * block.first_face,
            "componentType": _UNSIGNED_SHORT if index_bytes == 2 else _UNSIGNED_INT,
            "count": 3 * block.face_count,
            "type": "SCALAR",
        }
        for block in manifest.blocks
    ]
    return vectors + indices


def _pack(document: dict[str, Any], buffer: bytes) -> bytes:
    text = _pad(json.dumps(document, separators=(",", ":"), allow_nan=False, ensure_ascii=False).encode(), b" ")
    length = 12 + 8 + len(text) + 8 + len(buffer)
    return b"".join(
        (
            struct.pack("<4sII", b"glTF", 2, length),
            struct.pack("<II", len(text), _JSON_CHUNK),
            text,
            struct.pack("<II", len(buffer), _BINARY_CHUNK),
            buffer,
        )
    )


def _pad(data: bytes, filler: bytes) -> bytes:
    return data + filler * (-len(data) % 4)
