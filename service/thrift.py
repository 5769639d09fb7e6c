"""What a bundle's manifest says of how it was made smaller: what was left out, and how its numbers are stored."""

from typing import Annotated, Literal

from pydantic import Field
from pydantic.dataclasses import dataclass

from service.fields import STRICT, Count, Index, Magnitude, Name, Share


@dataclass(frozen=True, config=STRICT)
class Parsimony:
    """What the exporter kept of a trained model. It leaves out what changes nothing, and blocks that are never used."""

    trained_latent: Count
    """How many numbers a shape code had in training."""
    latent: Annotated[tuple[Index, ...], Field(min_length=1, max_length=65536)]
    """Those of them that a shape code of the bundle holds, counted from 0, in order."""
    latent_divergence_nats: tuple[Magnitude, ...]
    """How much held-out pictures say about each of those: mean KL divergence from the prior. A number about which they
    say next to nothing is kept where it changes samples. Empty without held-out pictures."""
    removed_blocks: tuple[Name, ...]
    """Blocks of which neither held-out pictures nor samples make use."""
    pictures: Index
    """Held-out pictures that were looked at."""
    samples: Count
    """Shape codes from the prior that were looked at."""
    largest_change: Magnitude
    """How far what was left out moves any vertex, diagonals."""

    def contradiction(self, latent: int) -> str | None:
        """What does not go together, in a bundle whose shape codes have `latent` numbers."""
        if len(self.latent) != latent:
            return f"expected {latent} numbers of the shape code, found {len(self.latent)}"
        if sorted(set(self.latent)) != list(self.latent) or self.latent[-1] >= self.trained_latent:
            return f"expected ascending numbers below {self.trained_latent}, found {str(list(self.latent))[:60]}"
        if len(self.latent_divergence_nats) not in (0, latent):
            return f"expected {latent} divergences or none, found {len(self.latent_divergence_nats)}"
        return None


@dataclass(frozen=True, config=STRICT)
class Deviation:
    """How far numbers lie from those of the float32 graphs: absolute differences, over pictures or shape codes."""

    largest: Magnitude
    mean: Magnitude


@dataclass(frozen=True, config=STRICT)
class Precision:
    """How weights are stored where not all are float32, and what that costs against the same graphs in float32.

    Inputs and outputs are float32 in any case. The manifest's `metrics` and `parity` are those of the float32 graphs.
    """

    encoder: Literal["float16", "int8"]
    """Of int8, activations are 8-bit, too; float16 is only how weights are stored."""
    decoder: Literal["float32", "float16"]
    pictures: Count
    """Held-out pictures that the encoder was compared on, none of which it was calibrated on."""
    deviations: dict[str, Deviation]
    """Per output of the graphs. Azimuths are compared where the most probable bin is the same."""
    agreement: dict[str, Share]
    """Share of those pictures whose most probable bin is the same, by the angle that the bin decides."""
