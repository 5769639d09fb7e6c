"""What an answer says beside the mesh: the same words in a GLB's extras, in JSON and in headers.

Azimuths and lights are relative to the picture's camera: an azimuth of 0 shows the object's front, a light at azimuth 0
stands on the camera's side. Angles are degrees, colours linear RGB.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class CameraReport:
    """A perspective camera that looks at the origin; distance in diagonals of the object's bounding box."""

    elevation_degrees: float
    distance: float
    field_of_view_degrees: float
    aspect_ratio: float


@dataclass(frozen=True)
class LightReport:
    """A directional light; its azimuth is relative to the camera."""

    azimuth_degrees: float
    elevation_degrees: float
    colour: tuple[float, float, float]


@dataclass(frozen=True)
class BinReport:
    """A coarse bin of an azimuth: the object's, or the lights'."""

    azimuth_degrees: float
    probability: float


@dataclass(frozen=True)
class LightPosteriorReport:
    """What is known of the turn of the lights: a coarse bin, and a normal distribution around its centre."""

    confidence: float
    """Probability of the most probable bin."""
    bins: tuple[BinReport, ...]
    entropy_nats: float
    """Entropy of the bins: 0 is certain, the logarithm of their number is no idea."""
    fine_mean_degrees: float
    fine_deviation_degrees: float


@dataclass(frozen=True)
class PosteriorReport:
    """What is known beyond the best guess: a coarse bin of the azimuth, a normal distribution around its centre, and
    how sure the shape code is."""

    azimuth_confidence: float
    """Probability of the most probable bin."""
    azimuth_bins: tuple[BinReport, ...]
    azimuth_entropy_nats: float
    """Entropy of the bins: 0 is certain, the logarithm of their number is no idea."""
    azimuth_symmetry: int
    """Turned by a full turn divided by this, the object is about as probable: 1 where all turns are told apart, the
    number of bins where none is."""
    azimuth_fine_mean_degrees: float
    azimuth_fine_deviation_degrees: float
    shape_deviation: tuple[float, ...]
    """Standard deviation of each number of the shape code."""
    light: LightPosteriorReport | None
    """Null where the model knows its lights."""


@dataclass(frozen=True)
class HypothesisReport:
    """A turn that the object may have; its bin's centre plus the fine mean."""

    azimuth_degrees: float
    probability: float


@dataclass(frozen=True)
class ViewReport:
    """What was found in one of the pictures."""

    azimuth_degrees: float
    azimuth_confidence: float
    azimuth_entropy_nats: float
    azimuth_symmetry: int
    hypotheses: tuple[HypothesisReport, ...]
    light_azimuth_degrees: float
    out_of_class_score: float | None


@dataclass(frozen=True)
class RefinementReport:
    """What was gained by following the pictures downhill from what the encoder said."""

    iterations: int
    """As many as were asked for, or fewer where no more was to be gained, or time was up."""
    rerender_error_before: float
    """Share of the pictures' light that the drawing gets wrong: Σ (x − x̂)² / Σ x², the mean over the pictures."""
    rerender_error_after: float


@dataclass(frozen=True)
class InterpolationReport:
    """A shape between those of two seeds: (1 − t) · from + t · to, number by number."""

    from_seed: int
    to_seed: int
    t: float


@dataclass(frozen=True)
class Report:
    """What was found in pictures, or made of a seed or a shape code. Pose, lights and posterior are the first
    picture's."""

    category: str
    model: str
    """The model's identity: sha256 of its graphs."""
    azimuth_degrees: float
    """The object's turn about +Y in the picture, -180 to 180; the GLB's camera stands accordingly."""
    camera: CameraReport
    light_azimuth_degrees: float
    """How far all lights are turned about +Y from where the model has them, 0 to 180; 0 where it knows them."""
    lights: tuple[LightReport, ...]
    """The lights as they are turned."""
    ambient: tuple[float, float, float]
    shape_code: tuple[float, ...]
    posterior: PosteriorReport | None
    """For a picture only."""
    hypotheses: tuple[HypothesisReport, ...] | None
    """The most probable turns, best first; for a picture only."""
    out_of_class_score: float | None
    """0: explained as well as held-out pictures of the class; 1: as badly as the worst one in twenty of them. The mean
    over the pictures. Null where there is no picture, or the model was exported without held-out pictures."""
    category_probabilities: dict[str, float] | None
    """The categories, most probable first; null where the request named one, or there is only one."""
    views: tuple[ViewReport, ...] | None
    """One for each picture, in the order of the request; for pictures only."""
    refinement: RefinementReport | None
    """Null where none was asked for."""
    seed: int | None
    """For a sample only."""
    temperature: float | None
    """For a sample only: its draw's standard deviation."""
    interpolation: InterpolationReport | None
    """For an interpolation only."""
