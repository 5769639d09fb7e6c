"""From a request to its answer: picture or seed → graphs → GLB and report. Knows no HTTP, runs in any thread."""

from dataclasses import asdict, dataclass
from time import perf_counter

from service.glb import write_glb
from service.image import read_picture
from service.inference import Engine, decode, encode, sample_shape_code
from service.report import Report, report_reconstruction, report_sample


@dataclass(frozen=True)
class Answer:
    """A GLB, what is to be said about it, and how long each stage took, milliseconds."""

    glb: bytes
    report: Report
    timings_ms: dict[str, float]


def reconstruct(engine: Engine, content: bytes, max_pixels: int) -> Answer:
    """The object in an uploaded picture, with the picture's camera and lights.

    Raises:
        ImageError: the upload is no picture that can be read.
        InferenceError: the model gave something that is no mesh.
    """
    started = perf_counter()
    size = engine.manifest.picture
    picture = read_picture(content, size.width, size.height, max_pixels)
    read = perf_counter()
    posterior = encode(engine, picture)
    encoded = perf_counter()
    surface = decode(engine, posterior.shape_mean)
    decoded = perf_counter()
    report = report_reconstruction(engine.manifest, posterior)
    glb = write_glb(surface, engine.manifest, posterior.azimuth, asdict(report))
    written = perf_counter()
    timings = {
        "picture": read - started,
        "encoder": encoded - read,
        "decoder": decoded - encoded,
        "glb": written - decoded,
    }
    return Answer(glb, report, _milliseconds(timings))


def sample(engine: Engine, seed: int) -> Answer:
    """An object drawn from the model's prior; the same seed gives the same bytes.

    Raises:
        InferenceError: the model gave something that is no mesh.
    """
    started = perf_counter()
    shape_code = sample_shape_code(seed, engine.manifest.latent)
    surface = decode(engine, shape_code)
    decoded = perf_counter()
    report = report_sample(engine.manifest, seed, shape_code)
    glb = write_glb(surface, engine.manifest, 0.0, asdict(report))
    return Answer(glb, report, _milliseconds({"decoder": decoded - started, "glb": perf_counter() - decoded}))


def _milliseconds(seconds: dict[str, float]) -> dict[str, float]:
    return {stage: round(1000 * value, 3) for stage, value in seconds.items()}
