"""What is timed: one way to draw a scene, and to differentiate the drawing."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from benchmarks.scene import Scene

FloatArray = npt.NDArray[np.float32] | npt.NDArray[np.float64]


class Gradients(NamedTuple):
    """Of the loss of each picture."""

    positions: FloatArray
    """[N, V, 2 or 3] in the contender's own space."""
    colours: FloatArray
    """[N, V, 3]."""


class Renderer(NamedTuple):
    """A contender that has been set up for one scene; what can be prepared once is prepared."""

    forward: Callable[[], FloatArray]
    """Pictures [N, 3, H, W] or, where the work is a likelihood, log-likelihoods [N]."""
    step: Callable[[], Gradients]
    """Pictures, loss and gradients."""


@dataclass(frozen=True)
class Contender:
    """A renderer by name; `prepare` is a function of a module, so that it reaches worker processes."""

    name: str
    what: str
    """What is timed, in a sentence."""
    prepare: Callable[[Scene], Renderer]
    use_cores: Callable[[int], None]
    """Sets the number of threads in this process."""
    ours: bool = False
    work: Literal["L2", "likelihood"] = "L2"
    """The loss: Σ (picture − target)², or the Gaussian pyramid's log-likelihood."""
    space: Literal["screen", "camera"] = "screen"
    """Where the gradients of positions live."""
    second_core: Literal["threads", "processes"] = "threads"
    """How the contender uses more than one core; processes where it has no threads of its own."""
