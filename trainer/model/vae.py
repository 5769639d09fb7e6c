"""The generative model and its inference network (sections 3 and 4 of the paper)."""

import math

import torch
from jaxtyping import Float
from torch import Tensor, nn

from trainer import processes, recording
from trainer.config import ModelConfig, Symmetry, TrainConfig
from trainer.geometry.cup import subdivided_cup
from trainer.geometry.topology import BaseMesh, subdivided_cube
from trainer.model.block_decoder import BlockDecoder
from trainer.model.decoder import SubdivisionDecoder
from trainer.model.encoder import Encoder
from trainer.model.lattice import Lattice
from trainer.model.posterior import Posterior, PosteriorHeads

# Side of the base cube, in diagonals of the object's bounding box: a compact start in the middle of the picture.
BASE_CUBE_SIDE = 0.4
# Across which axes shapes are their own mirror images.
MIRRORS: dict[Symmetry, tuple[int, ...]] = {"none": (), "mirror": (0,), "two-mirrors": (0, 2)}
# Blocks of an object (Appendix B).
ORTHO_BLOCKS, FULL_BLOCKS = 6, 12

Decoder = SubdivisionDecoder | BlockDecoder


class Model(nn.Module):
    """x → Q(z, θ, λ | x), and z → vertices. There is a λ only where the light varies, and a lattice inside of shapes
    where it is asked for, of a displaced cube."""

    def __init__(self, config: ModelConfig, width: int, height: int, lattice: bool = False) -> None:
        super().__init__()
        self.config = config
        self.width, self.height = width, height
        self.encoder = Encoder(config.encoder_channels, width, height)
        light_bins = config.light_bins if config.light == "varying" else 0
        self.heads = PosteriorHeads(config.encoder_channels[-1], config.latent, config.azimuth_bins, light_bins)
        self.decoder = decoder_of(config)
        inner_points = math.prod(config.segments * times - 1 for times in config.proportions)
        self.lattice = Lattice(config.hidden, inner_points) if lattice else None

    @property
    def faces(self) -> Tensor:
        return self.decoder.faces

    def encode(self, images: Float[Tensor, "B 3 H W"]) -> Posterior:
        """Q for pictures in linear RGB, 0..1, on black."""
        posterior: Posterior = self.heads(self.encoder(images))
        return posterior

    def decode(self, shape_code: Float[Tensor, "B Z"]) -> Float[Tensor, "B V 3"]:
        """Vertices in the object frame."""
        vertices: Tensor = self.decoder(shape_code)
        return vertices

    def inner_offsets(self, shape_code: Float[Tensor, "B Z"]) -> Float[Tensor, "B I 3"]:
        """What `Lattice` says of shapes; only of a model that has one."""
        assert self.lattice is not None
        assert isinstance(self.decoder, SubdivisionDecoder)
        offsets: Tensor = self.lattice(self.decoder.hidden(shape_code))
        return offsets


def model_of(config: TrainConfig) -> Model:
    """The model of a training, new; with a lattice where the loss asks for it."""
    return Model(config.model, config.width, config.height, lattice=config.loss.inner_points == "learnt")


def decoder_of(config: ModelConfig) -> Decoder:
    """The decoder of a parameterisation, new."""
    mirrored = MIRRORS[config.symmetry]
    match config.parameterisation:
        case "subdivision":
            return SubdivisionDecoder(config.latent, config.hidden, _base_of(config), mirrored)
        case "ortho-block":
            blocks = config.blocks or ORTHO_BLOCKS
            return BlockDecoder(config.latent, config.hidden, blocks, BASE_CUBE_SIDE, turning=False, mirrored=mirrored)
        case "full-block":
            blocks = config.blocks or FULL_BLOCKS
            return BlockDecoder(config.latent, config.hidden, blocks, BASE_CUBE_SIDE, turning=True, mirrored=mirrored)


def _base_of(config: ModelConfig) -> BaseMesh:
    """What is displaced."""
    if config.base == "cup":
        return subdivided_cup(config.segments, BASE_CUBE_SIDE)
    return subdivided_cube(config.segments, BASE_CUBE_SIDE, config.proportions)


def sample_normal(
    mean: Float[Tensor, "*N"], deviation: Float[Tensor, "*N"], generator: torch.Generator
) -> Float[Tensor, "*N"]:
    """The reparameterisation trick: a sample whose gradient reaches mean and deviation. The noise is the generator's,
    whatever device the mean is on. Processes that train together draw that of the whole batch, and take their own."""
    size = len(mean) * processes.count()
    noise = recording.normal_noise((size, *mean.shape[1:]), generator, mean.dtype, mean.device)
    return mean + deviation * noise[processes.share(size)]
