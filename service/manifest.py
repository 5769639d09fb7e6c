"""The manifest of a bundle: what the model is, which picture it expects, and what the graphs return.

The manifest is the only place where numbers travel from training to service. It holds data, no formulas: all model
mathematics is inside the graphs.
"""

import hashlib
from collections.abc import Mapping
from typing import Annotated, Final, Literal

import pydantic_core
from pydantic import Field, JsonValue, TypeAdapter, ValidationError
from pydantic.dataclasses import dataclass

from service.density import AggregatePosterior
from service.errors import BundleError
from service.fields import STRICT, Count, Degrees, Digest, Elevation, Index, Name, Side
from service.thrift import Parsimony, Precision

FORMAT_VERSION: Final = 1
ENCODER_FILE: Final = "encoder.onnx"
DECODER_FILE: Final = "decoder.onnx"
PROBE_FILE: Final = "probe.npz"
DATA_FILES: Final = (ENCODER_FILE, DECODER_FILE, PROBE_FILE)

ENCODER_INPUT: Final = "images"
ENCODER_OUTPUTS: Final = (
    "shape_mean",
    "shape_deviation",
    "azimuth_probabilities",
    "azimuth_fine_mean",
    "azimuth_fine_deviation",
    "azimuth",
)
LIGHT_OUTPUTS: Final = ("light_probabilities", "light_fine_mean", "light_fine_deviation", "light_azimuth")
"""What the encoder returns besides, where the light varies."""
DECODER_INPUT: Final = "shape_codes"
DECODER_OUTPUTS: Final = ("vertices", "normals")

MOST_BIAS: Final = 20.0
"""Nats: no category may be preferred or put back by more."""

Intensity = Annotated[float, Field(ge=0, le=100)]
Colour = tuple[Intensity, Intensity, Intensity]


@dataclass(frozen=True, config=STRICT)
class Conventions:
    """The conventions that graphs, manifest and GLB share. Another value is another format: it is refused."""

    frame: Literal["right-handed, +Y up, +Z front, counter-clockwise faces outward"] = (
        "right-handed, +Y up, +Z front, counter-clockwise faces outward"
    )
    scale: Literal["centred on the bounding box, unit diagonal"] = "centred on the bounding box, unit diagonal"
    azimuth: Literal["right-handed rotation of the object about +Y"] = "right-handed rotation of the object about +Y"
    lights: Literal["from the surface towards the light, Lambert, double-sided, fixed to the camera"] = (
        "from the surface towards the light, Lambert, double-sided, fixed to the camera"
    )
    graph_angles: Literal["radians"] = "radians"


@dataclass(frozen=True, config=STRICT)
class Picture:
    """The picture that the encoder expects: float32 [B, 3, height, width]."""

    width: Side
    height: Side
    zoom: Annotated[float, Field(ge=1, le=100)] = 1.0
    """How many times pictures that are framed already are enlarged about their middle."""
    file_colour: Literal["sRGB"] = "sRGB"
    graph_colour: Literal["linear, 0 to 1"] = "linear, 0 to 1"
    channels: Literal["RGB, row 0 on top"] = "RGB, row 0 on top"
    background: Literal["black"] = "black"


@dataclass(frozen=True, config=STRICT)
class Camera:
    """A perspective camera on the +Z side that looks at the origin; distance in bounding-box diagonals."""

    elevation_degrees: Elevation
    distance: Annotated[float, Field(gt=0, le=1000)]
    field_of_view_degrees: Annotated[float, Field(gt=0, lt=180)]


@dataclass(frozen=True, config=STRICT)
class Light:
    """A directional light, placed relative to the camera: azimuth 0 is the camera's side, 90 is +X."""

    azimuth_degrees: Degrees
    elevation_degrees: Elevation
    colour: Colour


@dataclass(frozen=True, config=STRICT)
class Block:
    """A part of the mesh: `face_count` consecutive faces from `first_face` on."""

    name: Name
    first_face: Index
    face_count: Count


@dataclass(frozen=True, config=STRICT)
class Errors:
    """Re-render errors (`service.explanation`) of a model on pictures of its class that it has not been trained on."""

    median: Annotated[float, Field(ge=0)]
    high: Annotated[float, Field(ge=0)]
    """One in twenty is above this."""


@dataclass(frozen=True, config=STRICT)
class HeldOut:
    """What a picture of the class costs the model, so that others can be told from it."""

    pictures: Count
    framed: Errors | None
    """Of pictures in the model's own frame; None where there were none."""
    fitted: Errors | None
    """Of pictures whose object was cut out and framed."""


@dataclass(frozen=True, config=STRICT)
class Manifest:
    """Everything that the service knows about a model beside its graphs."""

    format_version: Literal[1]
    category: Name
    identity: Digest
    """sha256 over the digests of the two graphs: equal models, and only they, share it."""
    conventions: Conventions
    picture: Picture
    camera: Camera
    lights: Annotated[tuple[Light, ...], Field(max_length=64)]
    ambient: Colour
    azimuth_bin_centres_degrees: Annotated[tuple[Degrees, ...], Field(min_length=1, max_length=3600)]
    """Centres of the coarse azimuth bins, offset included."""
    azimuth_offset_degrees: Degrees
    """The offset δ that the exporter baked into the graphs: predicted azimuth + δ, object turned by −δ."""
    latent: Annotated[int, Field(ge=1, le=65536)]
    vertices: Annotated[int, Field(ge=3, le=10_000_000)]
    training: dict[str, JsonValue]
    metrics: dict[str, JsonValue]
    parity: dict[str, Annotated[float, Field(ge=0)]]
    """Largest absolute difference between torch and onnxruntime, per output of the graphs."""
    files: dict[str, Digest]
    """sha256 of every other file of the bundle."""
    blocks: Annotated[tuple[Block, ...], Field(min_length=1, max_length=1024)]
    faces: Annotated[tuple[tuple[Index, Index, Index], ...], Field(min_length=1, max_length=2_000_000)]
    light_bin_centres_degrees: Annotated[tuple[Degrees, ...], Field(max_length=3600)] = ()
    """Centres of the coarse bins of λ, by which all lights are turned together, right-handed about +Y and before the
    camera. None where the lights are fixed: the encoder then returns nothing about them."""
    held_out: HeldOut | None = None
    """None where the exporter had no pictures: no picture is then told from one of the class."""
    parsimony: Parsimony | None = None
    """None of a bundle from before the exporter left out what carries nothing."""
    azimuth_temperature: Annotated[float, Field(gt=0)] = 1.0
    """What the exporter divided the bins' logits by: fitted, like the offset, where poses are known; 1 as trained."""
    precision: Precision | None = None
    """None where all weights are float32."""
    category_bias: Annotated[float, Field(ge=-MOST_BIAS, le=MOST_BIAS)] = 0.0
    """Added to the logarithm of how probable the category is beside others, nats: a model that explains much is judged
    more strictly. Fitted by `python -m exporter.rivals` on pictures of all categories that are served together."""
    views_per_instance: Annotated[int, Field(ge=1, le=64)] = 1
    """Pictures of an object that a step of the training pooled: how those of a request are, depends on it."""
    aggregate_posterior: AggregatePosterior | None = None
    """What samples are drawn from; None where the exporter had too few pictures: then it is the prior."""


_ADAPTER = TypeAdapter(Manifest)


def model_identity(digests: Mapping[str, str]) -> str:
    """The identity of a model, from the sha256 digests of its files (hexadecimal, by file name)."""
    return hashlib.sha256(f"{digests[ENCODER_FILE]} {digests[DECODER_FILE]}".encode()).hexdigest()


def encoder_outputs(manifest: Manifest) -> tuple[str, ...]:
    """The names of what the encoder returns, in order."""
    return ENCODER_OUTPUTS + (LIGHT_OUTPUTS if manifest.light_bin_centres_degrees else ())


def tensor_shapes(manifest: Manifest) -> dict[str, tuple[int, ...]]:
    """The shape, without the batch axis, of every input and output that the two graphs can have."""
    return {
        "images": (3, manifest.picture.height, manifest.picture.width),
        "shape_mean": (manifest.latent,),
        "shape_deviation": (manifest.latent,),
        "azimuth_probabilities": (len(manifest.azimuth_bin_centres_degrees),),
        "azimuth_fine_mean": (),
        "azimuth_fine_deviation": (),
        "azimuth": (),
        "light_probabilities": (len(manifest.light_bin_centres_degrees),),
        "light_fine_mean": (),
        "light_fine_deviation": (),
        "light_azimuth": (),
        "shape_codes": (manifest.latent,),
        "vertices": (manifest.vertices, 3),
        "normals": (manifest.vertices, 3),
    }


def encode_manifest(manifest: Manifest) -> bytes:
    """The manifest as JSON text."""
    return _ADAPTER.dump_json(manifest, indent=1)


def decode_manifest(text: bytes, where: str) -> Manifest:
    """The manifest that a JSON text holds; `where` names the file in messages.

    Raises:
        BundleError: not JSON, another format version, an unknown, missing or wrong field, or fields that contradict
            each other.
    """
    try:
        raw = pydantic_core.from_json(text)
    except ValueError as error:
        raise BundleError(f"{where}: expected JSON, found something else ({error}); export the bundle again") from None
    version = raw.get("format_version") if isinstance(raw, dict) else None
    if version != FORMAT_VERSION or isinstance(version, bool):
        raise BundleError(
            f"{where}: expected format_version {FORMAT_VERSION}, found {str(version)[:40]}; "
            "export the model with the exporter of this release, or use the service of the release that wrote it"
        )
    try:
        manifest = _ADAPTER.validate_json(text)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        field = ".".join(str(part) for part in first["loc"]) or "the whole file"
        found = str(first["input"])[:60]
        raise BundleError(f"{where}: {field}: {first['msg']}, found {found}; export the bundle again") from None
    if fault := _contradiction(manifest):
        raise BundleError(f"{where}: {fault}; export the bundle again")
    return manifest


def _contradiction(manifest: Manifest) -> str | None:
    """What in a manifest does not go together."""
    if set(manifest.files) != set(DATA_FILES):
        return f"files should name just {', '.join(DATA_FILES)}, found {', '.join(sorted(manifest.files))[:99]}"
    if manifest.identity != model_identity(manifest.files):
        return "identity does not belong to the graphs' digests"
    held_out = manifest.held_out
    for errors in (held_out.framed, held_out.fitted) if held_out else ():
        if errors and not errors.median < errors.high:
            return f"held_out: expected a median below the high error, found {errors.median:g} and {errors.high:g}"
    of_codes = {"aggregate_posterior": manifest.aggregate_posterior, "parsimony": manifest.parsimony}
    for name, part in of_codes.items():
        if part and (fault := part.contradiction(manifest.latent)):
            return f"{name}: {fault}"
    highest = max(max(face) for face in manifest.faces)
    if highest >= manifest.vertices:
        return f"faces should refer to vertices 0 to {manifest.vertices - 1}, found {highest}"
    return _block_contradiction(manifest)


def _block_contradiction(manifest: Manifest) -> str | None:
    expected_first = 0
    for block in manifest.blocks:
        if block.first_face != expected_first:
            return f"block {block.name} should begin at face {expected_first}, found {block.first_face}"
        expected_first += block.face_count
    if expected_first != len(manifest.faces):
        return f"the blocks should cover {len(manifest.faces)} faces, found {expected_first}"
    return None
