"""The one tree of settings. Every field says what it means, its unit, and where the paper states its value.

A scene (camera, lights, size) belongs to a folder of pictures and travels with it as `scene.json`; the rest is a
training's own and travels in its run directory and in every checkpoint.
"""

from dataclasses import dataclass, field
from typing import Literal

Colour = tuple[float, float, float]
Symmetry = Literal["none", "mirror", "two-mirrors"]


@dataclass(frozen=True)
class CameraConfig:
    """A perspective camera that looks at the origin from the +Z side."""

    elevation_degrees: float = 30.0
    """Height of the camera above the horizon, degrees."""
    distance: float = 2.0
    """Distance from the origin, in diagonals of the object's bounding box."""
    field_of_view_degrees: float = 30.0
    """Vertical field of view, degrees. At distance 2 an object of unit diagonal always fits."""


@dataclass(frozen=True)
class DirectionalLight:
    """Light from far away."""

    azimuth_degrees: float
    """Where the light stands around +Y: 0 is the camera's side (+Z), 90 is +X; degrees."""
    elevation_degrees: float
    """Height of the light above the horizon, degrees."""
    colour: Colour
    """Linear RGB intensity; a surface that faces the light reflects just this."""


# Three mutually orthogonal directions: |n·l| in three colours then determines a normal up to its signs.
COLOUR_RIG = (
    DirectionalLight(azimuth_degrees=30.0, elevation_degrees=35.2644, colour=(1.0, 0.0, 0.0)),
    DirectionalLight(azimuth_degrees=150.0, elevation_degrees=35.2644, colour=(0.0, 1.0, 0.0)),
    DirectionalLight(azimuth_degrees=270.0, elevation_degrees=35.2644, colour=(0.0, 0.0, 1.0)),
)

# "One white directional light plus a white ambient component" (section 5.3 of the paper, which gives no figures): a
# surface that faces the light is white.
WHITE_RIG = (DirectionalLight(azimuth_degrees=30.0, elevation_degrees=35.2644, colour=(0.8, 0.8, 0.8)),)
WHITE_AMBIENT: Colour = (0.2, 0.2, 0.2)


@dataclass(frozen=True)
class SceneConfig:
    """What pictures and renderings share: size, camera and lights."""

    width: int = 128
    """Width of a picture, pixels (paper: 128, Appendix A)."""
    height: int = 96
    """Height of a picture, pixels (paper: 96, Appendix A)."""
    camera: CameraConfig = field(default_factory=CameraConfig)
    """Where the camera stands."""
    lights: tuple[DirectionalLight, ...] = COLOUR_RIG
    """The directional lights ("three coloured directional lights", section 5.3 of the paper)."""
    ambient: Colour = (0.0, 0.0, 0.0)
    """Linear RGB of the light that comes from everywhere."""
    zoom: float = 1.0
    """How many times picture files are enlarged about their middle to be what this camera sees; 1 but for a model's."""


@dataclass(frozen=True)
class ModelConfig:
    """Encoder, posterior and decoder (Appendix A)."""

    latent: int = 12
    """Dimensions of the shape code z (paper: 12, section 5)."""
    hidden: int = 32
    """Width of the decoder's hidden layer (paper: 32, Appendix A)."""
    parameterisation: Literal["subdivision", "ortho-block", "full-block"] = "subdivision"
    """What the decoder's output means (section 3): displacements of a `subdivision` of the cube; locations and scales
    of upright blocks (`ortho-block`); or these and the blocks' rotations (`full-block`)."""
    segments: int = 4
    """`subdivision`: segments along each edge of the cube (paper: 4, that is 98 vertices)."""
    proportions: tuple[int, int, int] = (1, 1, 1)
    """`subdivision` of the cube: how many times `segments` its edges along x, y and z are cut into. What is long has
    its vertices where it is long: 2 segments, 1, 3 and 10 times, are 346 vertices, at 21 places along z."""
    base: Literal["cube", "cup"] = "cube"
    """`subdivision`: what is displaced (paper: a cube). A `cup` opens upwards, for what is hollow: its walls and floor
    are there from the beginning, where a cube has to be dented. As many segments give it more vertices (4: 178)."""
    blocks: int = 0
    """`ortho-block` and `full-block`: how many blocks; 0 is the paper's number, 6 and 12 (Appendix B)."""
    symmetry: Symmetry = "none"
    """`mirror` makes every shape its own mirror image, left to right: the decoder learns half as much. The second half
    of blocks are then the images of the first, and the last of an odd number lies in the mirror. `two-mirrors` makes it
    one front to back as well, for what has no front: the decoder learns a quarter, and the side that is seen tells the
    other."""
    azimuth_bins: int = 12
    """Coarse bins R_θ of the azimuth (paper: 12, Appendix B)."""
    light: Literal["fixed", "varying"] = "fixed"
    """`fixed` is the scene's light, and known; `varying` lights are turned together about +Y by an angle λ of their own
    in each picture, which is inferred (section 5.3)."""
    light_bins: int = 3
    """`varying` light: coarse bins R_λ of λ in 0 to π (paper: 3, Appendix B)."""
    encoder_channels: tuple[int, int, int, int, int, int] = (32, 64, 96, 128, 128, 128)
    """Channels of the five convolutions and of the fully connected layer (paper: 32, 64, 96, 128, 128, 128)."""


@dataclass(frozen=True)
class LossConfig:
    """The training objective. Weights are for a sum over the pixels of a 128 × 96 picture with ε = 1, and scale with
    the number of pixels, so that they mean the same at every resolution."""

    objective: Literal["exact", "paper"] = "exact"
    """How the coarse azimuth's posterior is found: `exact` = balanced E-step over all bins, taught to the encoder;
    `paper` = the encoder's own ρ, by gradient, with prior matching (Eq. loss)."""
    kind: Literal["shading", "silhouette"] = "shading"
    """What of the pictures is compared: `shading`, their colours; or the `silhouette` alone, where pixels p of both
    pictures become p / (p + η) first (section 5.3)."""
    eta: float = 0.05
    """`silhouette`: η, linear colour ("a small constant", section 5.3)."""
    pose_supervision: Literal["none", "azimuth"] = "none"
    """`azimuth` reads the true azimuth from metadata.csv ("iou | θ" in the paper)."""
    kl_weight: float = 8.0
    """Final weight β of the KL term (paper: 10³ at its own ε; see docs/paper.md)."""
    kl_weight_start: float = 124.0
    """Weight β at the first step; cools exponentially to `kl_weight`. Equal values mean constant, as in the paper."""
    kl_cooling_steps: float = 300.0
    """Time constant of that cooling, and of the Laplacian weight's, steps."""
    prior_matching_weight: float = 450.0
    """Weight α of batch prior matching, `paper` objective only (paper: 5·10⁵ at its own ε)."""
    independence_weight: float = 0.0
    """`exact` objective: weight of what shape codes tell of poses (`trainer.model.loss.pose_in_code`). A short training
    may otherwise learn other shapes for pictures from the front than for those from the side."""
    neighbour_weight: float = 0.0
    """`exact` objective: weight of each picture's likelihood under the shape of a like object that was seen from
    another side (`training.neighbours`), from step `e_step_centred_steps` on; 1 weighs as much as its own shape's. It
    costs up to half more time."""
    temperature_start: float = 240.0
    """`exact` objective: temperature T of the E-step at the first step, in units of log-likelihood."""
    temperature: float = 24.0
    """`exact` objective: final temperature; cools exponentially."""
    temperature_cooling_steps: float = 200.0
    """Time constant of that cooling, steps."""
    sinkhorn_iterations: int = 5
    """`exact` objective: rounds that balance the batch's posterior to the uniform prior."""
    encoder_prior: float = 1.0
    """`exact` objective: power to which the encoder's own ρ enters the E-step as a prior; 0 means a uniform one. What
    the encoder has learnt from pictures that are clear then decides those that are not."""
    encoder_prior_steps: float = 500.0
    """Time constant with which that power grows from 0, steps: a young encoder knows nothing yet."""
    moved_steps: int = 0
    """For so many steps, shapes learn from views that are moved onto their pictures (`training.moving`), afterwards
    also where they lie; the E-step compares moved views throughout. 0 moves none. For classes whose bulk may be before
    or behind the middle, as the wings of aeroplanes."""
    distillation_weight: float = 80.0
    """Weight of the cross-entropy that teaches the encoder's ρ the E-step's posterior (`exact` objective) or the poses
    that are given."""
    laplacian_weight: float = 20.0
    """Weight of the squared Laplacian of the vertex displacements (0 in the paper: no such term). `subdivision` only:
    blocks have no such displacements, and this no effect."""
    laplacian_weight_start: float = 2000.0
    """That weight at the first step; cools like the KL weight."""
    laplacian_underside: float = 30.0
    """How many times as much that term weighs at the vertices of the base cube's underside, without its rim. A camera
    above the horizon never sees them, and pictures push them out of sight only: with 1 they cave in, unless
    inversion_weight keeps them, and with 100 legs no longer part."""
    inversion_weight: float = 0.0
    """Weight of the volume that shapes turn inside out (`geometry.solid`), a volume of 1 being a cube whose side is the
    object's diagonal; 100,000 leaves hardly any. Only for displaced cubes."""
    inversion_margin: float = 0.1
    """The least volume that a tetrahedron in a shape is left, as a share of the mean of the shape's: what lacks weighs
    like what is inside out, so that what is thin keeps two sides."""
    inner_points: Literal["carried", "learnt"] = "carried"
    """Where the points inside of a shape lie, whose tetrahedra those are: `carried` by its surface, or where a layer of
    the decoder's learns to put them, so that nothing is refused that is sound, as legs and whatever else is bent.
    Only with inversion_weight."""
    front_back_weight: float = 0.0
    """Weight of how far vertices lie from the mirror images of those across the middle, front to back
    (`trainer.model.front_back`): what a picture does not show is then like what it does, unless others show it
    otherwise. `subdivision` only, of shapes that are not mirrored so anyway. For poses that are told, or once they are
    learnt (front_back_after)."""
    front_back_knee: float = 0.0
    """The sum d of a shape's distances, in its diagonals, counts as knee · log(1 + d / knee), so that the few objects
    whose front is unlike their back as a whole, as a desk lamp's arm is, may be so; 0: as d. Only with
    front_back_weight."""
    front_back_after: int = 0
    """The step from which on it weighs: before, poses are learnt from what is unlike, as a desk lamp's from its arm.
    Only with front_back_weight."""
    e_step_centred_steps: int = 500
    """`exact` objective: for so many steps, the E-step compares poses at the centres of their bins, so that bins are
    told apart before the fine angle is known; afterwards at the encoder's fine angle, by which alone front and back
    can be told where they look nearly alike."""
    antialias: Literal["contours", "borders"] = "contours"
    """Where renderings, and so their gradients, are exact: at `contours`; or at all `borders` that show, also creases
    and lines where faces interpenetrate (truer, slower, and for cars no better)."""
    antialias_e_step: Literal["none", "contours"] = "none"
    """`exact` objective: the same where the E-step compares poses, of which no gradient is asked; `none` takes
    less than half of the time of `contours`, for crumpled meshes a tenth."""


@dataclass(frozen=True)
class OptimiserConfig:
    """Adam with a clipped gradient."""

    learning_rate: float = 1e-3
    """Adam's learning rate (paper: 10⁻³, constant)."""
    decoder_factor: float = 1.0
    """How many times the learning rate the decoder's is, its rotations' apart (paper: 1). Adam moves a weight by about
    its rate a step, whatever the gradient: this is how far vertices can travel in a short training."""
    falling_share: float = 0.0
    """Share of the steps, the last ones, in which all learning rates fall to 0 along half a cosine; 0 to 1 (paper: 0).
    """
    rotation_learning_rate: float = 1e-4
    """Learning rate of the layer that decodes the rotations of `full-block` (paper: 10⁻⁴, Appendix B)."""
    gradient_clip: float = 5.0
    """Largest global Euclidean norm of the gradient (paper: 5)."""
    batch_size: int = 128
    """Pictures a step (paper: 128; 192 with three views of each object)."""
    views_per_instance: int = 1
    """Pictures of each object among those of a step (paper: 1 or 3, section 5.5); the shape is found from all of them.
    `batch_size` is a multiple of it."""
    steps: int = 20000
    """Steps in all."""


@dataclass(frozen=True)
class TrainConfig:
    """Everything that determines a training, beside its pictures."""

    width: int = 128
    """Pictures are reduced to this width before training, pixels."""
    height: int = 96
    """Pictures are reduced to this height before training, pixels."""
    zoom: float = 1.0
    """How many times pictures are enlarged about their middle first, so that margins which no object reaches are not
    computed (paper: 1). 0 is as far as the objects in the pictures allow."""
    seed: int = 0
    """Seed of initial weights, batches and samples."""
    precision: Literal["auto", "float32", "bfloat16"] = "auto"
    """Number format of the encoder's convolutions while training; `auto` is bfloat16 where the CPU computes in it."""
    validation_share: float = 0.05
    """Share of the instances that is held out, to watch the training by; 0 to 0.5."""
    model: ModelConfig = field(default_factory=ModelConfig)
    """The networks."""
    loss: LossConfig = field(default_factory=LossConfig)
    """The objective."""
    optimiser: OptimiserConfig = field(default_factory=OptimiserConfig)
    """The optimiser."""
