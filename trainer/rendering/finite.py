"""What cannot be drawn is named before it is drawn."""

from torch import Tensor

from trainer import recording


def check_finite(screen: Tensor, colours: Tensor) -> None:
    """Raises FloatingPointError, naming the first bad mesh, where a model has decoded what cannot be drawn.

    `screen` is [N, V, 3] or [B, R, V, 3], counted picture by picture; `colours` have the same first axes.
    """
    if recording.is_sound(screen.isfinite().all() & colours.isfinite().all()):
        return
    vertex = screen.ndim - 2
    bad = ~(screen.isfinite().flatten(vertex).all(-1) & colours.isfinite().flatten(vertex).all(-1)).flatten()
    first = int(bad.int().argmax())
    raise FloatingPointError(f"expected finite vertices and colours, found NaN or infinity first in mesh {first}")
