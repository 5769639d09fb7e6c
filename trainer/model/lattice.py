"""Where the points inside of a displaced cube lie, by which a loss tells what of it is inside out.

No picture shows them, and no bundle holds them. Where they are learnt, they let the surface be: a bent one is sound as
soon as any places of theirs are right.
"""

from jaxtyping import Float
from torch import Tensor, nn

from trainer.model.decoder import DISPLACEMENT_UNIT


class Lattice(nn.Module):
    """The decoder's hidden units → how far each inner point lies beside the mean of vertices that
    `geometry.solid.Solid` has for it. Starts at none."""

    def __init__(self, hidden: int, points: int) -> None:
        super().__init__()
        self.offsets = nn.Linear(hidden, 3 * points)
        nn.init.zeros_(self.offsets.weight)
        nn.init.zeros_(self.offsets.bias)

    def forward(self, hidden: Float[Tensor, "B H"]) -> Float[Tensor, "B I 3"]:
        """In the object frame. Teaches the hidden units nothing: surfaces are not to bend for it."""
        offsets: Tensor = DISPLACEMENT_UNIT * self.offsets(hidden.detach()).unflatten(1, (-1, 3))
        return offsets
