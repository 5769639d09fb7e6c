"""What fuzzing begins with: small pictures of every format and kind, and the files of a bundle of three vertices."""

import hashlib
import io
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import onnx
import onnxruntime
from onnx import helper
from PIL import Image

from service.bundle import MANIFEST_FILE
from service.manifest import (
    DECODER_FILE,
    DECODER_INPUT,
    DECODER_OUTPUTS,
    ENCODER_FILE,
    ENCODER_INPUT,
    ENCODER_OUTPUTS,
    PROBE_FILE,
    Block,
    Camera,
    Conventions,
    Errors,
    HeldOut,
    Light,
    Manifest,
    Picture,
    encode_manifest,
    model_identity,
)

SIDE, BINS = 8, 2
_OPSET = 20


@cache
def pictures() -> dict[str, bytes]:
    """Files of a disc before a plain background, or before none, by name."""
    y, x = np.mgrid[-1:1:30j, -1.33:1.33:40j]
    disc = (x**2 + y**2 < 0.5)[..., None]
    shaded = np.stack((0.5 + y / 3, 0.5 + x / 4, 0.5 - y / 3), -1)
    colour = Image.fromarray((255 * np.where(disc, shaded, 0.9)).astype(np.uint8))
    alone = Image.fromarray((255 * np.concatenate((shaded, disc), -1)).astype(np.uint8))
    palette = colour.quantize(16)
    behind = palette.getpixel((0, 0))
    deep = Image.fromarray((65535 * np.where(disc, shaded, 0.9)[..., 0]).astype(np.uint16))
    turned = Image.Exif()
    turned[0x0112] = 6
    return {
        "rgb.png": _file(colour, "PNG"),
        "rgba.png": _file(alone, "PNG"),
        "grey.png": _file(colour.convert("L"), "PNG"),
        "grey-alpha.png": _file(alone.convert("LA"), "PNG"),
        "palette.png": _file(palette, "PNG", transparency=behind),
        "bits.png": _file(colour.convert("1"), "PNG"),
        "deep.png": _file(deep, "PNG"),
        "turned.png": _file(colour, "PNG", exif=turned, dpi=(72, 72)),
        "moving.png": _file(colour, "PNG", save_all=True, append_images=[colour.rotate(90)]),
        "rgb.jpg": _file(colour, "JPEG", quality=85),
        "grey.jpg": _file(colour.convert("L"), "JPEG"),
        "cmyk.jpg": _file(colour.convert("CMYK"), "JPEG"),
        "progressive.jpg": _file(colour, "JPEG", progressive=True, exif=turned),
        "two.mpo": _file(colour, "MPO", save_all=True, append_images=[colour]),
        "rgb.webp": _file(colour, "WEBP"),
        "lossless.webp": _file(alone, "WEBP", lossless=True, exif=turned),
        "moving.webp": _file(alone, "WEBP", save_all=True, append_images=[alone.rotate(90)], duration=10),
        "palette.gif": _file(palette, "GIF"),
        "moving.gif": _file(palette, "GIF", save_all=True, append_images=[palette.rotate(90)], transparency=behind),
        "rgb.bmp": _file(colour, "BMP"),
        "palette.bmp": _file(palette, "BMP"),
        "bits.bmp": _file(colour.convert("1"), "BMP"),
    }


def _file(image: Image.Image, file_format: str, **options: Any) -> bytes:
    buffer = io.BytesIO()
    image.save(buffer, file_format, **options)
    return buffer.getvalue()


@cache
def bundle() -> dict[str, bytes]:
    """The four files of a bundle that is served: a picture of 8 × 8 moves a triangle."""
    graphs = {ENCODER_FILE: _encoder(), DECODER_FILE: _decoder()}
    contents = {**graphs, PROBE_FILE: _probe(graphs)}
    return {**contents, MANIFEST_FILE: sealed(contents)}


def sealed(contents: dict[str, bytes]) -> bytes:
    """The manifest of a bundle with these graphs and this probe."""
    digests = {name: hashlib.sha256(content).hexdigest() for name, content in contents.items()}
    return encode_manifest(replace(_manifest(), files=digests, identity=model_identity(digests)))


@cache
def _manifest() -> Manifest:
    unsealed = dict.fromkeys((ENCODER_FILE, DECODER_FILE, PROBE_FILE), "0" * 64)
    return Manifest(
        format_version=1,
        category="triangle",
        identity=model_identity(unsealed),
        conventions=Conventions(),
        picture=Picture(SIDE, SIDE),
        camera=Camera(30.0, 2.0, 30.0),
        lights=(Light(30.0, 45.0, (0.9, 0.5, 0.1)),),
        ambient=(0.1, 0.1, 0.1),
        azimuth_bin_centres_degrees=(0.0, 180.0),
        azimuth_offset_degrees=12.5,
        latent=1,
        vertices=3,
        training={"seconds": 1.5},
        metrics={"iou": 0.5, "none": None},
        parity={"vertices": 1e-6},
        files=unsealed,
        blocks=(Block("body", 0, 1),),
        faces=((0, 1, 2),),
        held_out=HeldOut(8, Errors(0.1, 0.2), None),
    )


def _encoder() -> bytes:
    size = 3 * SIDE * SIDE
    weights = np.linspace(-1, 1, size * (BINS + 1), dtype=np.float32).reshape(size, -1) / size
    nodes = [
        helper.make_node("Flatten", [ENCODER_INPUT], ["flat"]),
        helper.make_node("MatMul", ["flat", "weights"], ["features"]),
        helper.make_node("Split", ["features", "parts"], ["shape_mean", "logits"], axis=1),
        helper.make_node("Exp", ["shape_mean"], ["shape_deviation"]),
        helper.make_node("Softmax", ["logits"], ["azimuth_probabilities"], axis=1),
        helper.make_node("Squeeze", ["shape_mean", "last"], ["azimuth_fine_mean"]),
        helper.make_node("Squeeze", ["shape_deviation", "last"], ["azimuth_fine_deviation"]),
        helper.make_node("Tanh", ["azimuth_fine_mean"], ["azimuth"]),
    ]
    constants = {"weights": weights, "parts": np.array([1, BINS]), "last": np.array([1])}
    shapes: dict[str, list[int]] = {"shape_mean": [1], "shape_deviation": [1], "azimuth_probabilities": [BINS]}
    outputs = {name: shapes.get(name, []) for name in ENCODER_OUTPUTS}
    return _graph(nodes, {ENCODER_INPUT: [3, SIDE, SIDE]}, outputs, constants)


def _decoder() -> bytes:
    corners = np.array([[0.5, 0, 0, 0, 0.5, 0, 0, 0, 0.5]], np.float32)
    nodes = [
        helper.make_node("Gemm", [DECODER_INPUT, "moves", "corners"], ["flat"]),
        helper.make_node("Reshape", ["flat", "shape"], ["vertices"]),
        helper.make_node("LpNormalization", ["vertices"], ["normals"], axis=2, p=2),
    ]
    constants = {"moves": corners / 10, "corners": corners[0], "shape": np.array([-1, 3, 3])}
    return _graph(nodes, {DECODER_INPUT: [1]}, {name: [3, 3] for name in DECODER_OUTPUTS}, constants)


def _graph(
    nodes: list[onnx.NodeProto],
    inputs: dict[str, list[int]],
    outputs: dict[str, list[int]],
    constants: dict[str, np.ndarray],
) -> bytes:
    def described(tensors: dict[str, list[int]]) -> list[onnx.ValueInfoProto]:
        return [
            helper.make_tensor_value_info(name, onnx.TensorProto.FLOAT, ["batch", *shape])
            for name, shape in tensors.items()
        ]

    weights = [onnx.numpy_helper.from_array(value, name) for name, value in constants.items()]
    graph = helper.make_graph(nodes, "triangle", described(inputs), described(outputs), weights)
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", _OPSET)], ir_version=10)
    return bytes(model.SerializeToString())


def _probe(graphs: dict[str, bytes]) -> bytes:
    images = np.linspace(0, 1, 2 * 3 * SIDE * SIDE, dtype=np.float32).reshape(2, 3, SIDE, SIDE)
    codes = np.array([[0.5], [-0.5]], np.float32)
    arrays = {ENCODER_INPUT: images, DECODER_INPUT: codes}
    for file, feed in ((ENCODER_FILE, {ENCODER_INPUT: images}), (DECODER_FILE, {DECODER_INPUT: codes})):
        session = onnxruntime.InferenceSession(graphs[file], providers=["CPUExecutionProvider"])
        names = [tensor.name for tensor in session.get_outputs()]
        arrays |= dict(zip(names, session.run(names, feed), strict=True))
    buffer = io.BytesIO()
    np.savez(buffer, allow_pickle=False, **arrays)
    return buffer.getvalue()
