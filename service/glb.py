"""Writing a mesh with its camera and lights as a GLB file (glTF 2.0, section 4: binary container)."""

import json
import struct
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

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


def write_glb(surface: Surface, manifest: Manifest, azimuth: float, extras: dict[str, Any]) -> bytes:
    """A GLB of the surface in its own frame (+Z front), seen by its picture's camera under its picture's lights.

    `azimuth` is the object's turn in that picture, radians. A block of the manifest is a node; `extras` stands on the
    scene. The material is white, matt and double-sided, and has no specular part: it shades as the model does.
    """
    faces = _faces(manifest)
    vertices = np.ascontiguousarray(surface.vertices, "<f4").tobytes()
    normals = np.ascontiguousarray(surface.normals, "<f4").tobytes()
    indices = faces.tobytes()
    buffer = _pad(vertices + normals + indices, b"\0")
    blocks = [{"name": block.name, "mesh": number} for number, block in enumerate(manifest.blocks)]
    lights = light_nodes(manifest.lights, azimuth)
    nodes = [*blocks, camera_node(manifest.camera, azimuth), *lights]
    document = {
        "asset": {"version": "2.0", "generator": "chiaro"},
        "extensionsUsed": ["KHR_materials_specular", *(["KHR_lights_punctual"] if lights else [])],
        "scene": 0,
        "scenes": [{"name": manifest.category, "nodes": list(range(len(nodes))), "extras": extras}],
        "nodes": nodes,
        "cameras": [perspective(manifest.camera, manifest.picture.width / manifest.picture.height)],
        "meshes": [
            {
                "name": block.name,
                "primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1}, "indices": 2 + number, "material": 0}],
            }
            for number, block in enumerate(manifest.blocks)
        ],
        "materials": [_material(manifest)],
        "accessors": _accessors(surface, manifest, faces.itemsize),
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": len(vertices), "target": _ARRAY_BUFFER},
            {"buffer": 0, "byteOffset": len(vertices), "byteLength": len(normals), "target": _ARRAY_BUFFER},
            {
                "buffer": 0,
                "byteOffset": len(vertices) + len(normals),
                "byteLength": len(indices),
                "target": _ELEMENT_ARRAY_BUFFER,
            },
        ],
        "buffers": [{"byteLength": len(buffer)}],
    }
    if lights:
        document["extensions"] = {"KHR_lights_punctual": {"lights": directional_lights(manifest.lights)}}
    return _pack(document, buffer)


def _faces(manifest: Manifest) -> NDArray[np.unsignedinteger[Any]]:
    """Face indices [F, 3], in two bytes where they suffice (glTF keeps 65535 free)."""
    return np.array(manifest.faces, "<u2" if manifest.vertices < 65536 else "<u4")


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


def _accessors(surface: Surface, manifest: Manifest, index_bytes: int) -> list[dict[str, Any]]:
    vectors = [
        {
            "bufferView": 0,
            "componentType": _FLOAT,
            "count": manifest.vertices,
            "type": "VEC3",
            "min": surface.vertices.min(0).tolist(),
            "max": surface.vertices.max(0).tolist(),
        },
        {"bufferView": 1, "componentType": _FLOAT, "count": manifest.vertices, "type": "VEC3"},
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
