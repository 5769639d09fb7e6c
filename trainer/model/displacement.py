"""How far shapes lie from their base mesh, as the smoothing of the training measures it."""

from jaxtyping import Float
from torch import Tensor

from trainer.config import LaplacianFrom


def displacements(
    vertices: Float[Tensor, "B V 3"], base: Float[Tensor, "V 3"], since: LaplacianFrom
) -> Float[Tensor, "B V 3"]:
    """From the base mesh as it is; or `stretched` about its middle along each axis as fits each shape best by least
    squares, so that a long or flat shape is no displacement of its own. Shapes may be moved as wholes; a Laplacian
    does not see that."""
    if since == "base":
        return vertices - base
    centred = base - base.mean(0)
    stretch = (vertices * centred).sum(1, keepdim=True) / centred.square().sum(0)
    return vertices - stretch * base
