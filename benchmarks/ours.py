"""Our own contenders: the kernels, the kernels under torch's autograd, the fused likelihood, and its parts in torch.

They antialias contours alone, as the peers do; one more contender is exact at every border.
"""

import math
from collections.abc import Callable

import numba
import numpy as np
import torch
from torch import Tensor
from torch.nn import functional

from benchmarks.contender import Contender, FloatArray, Gradients, Renderer
from benchmarks.scene import Scene
from rasteriser import likelihood, pictures
from trainer.rendering import cpu

CONTOURS_ALONE = math.inf
EXACT = 0.0


def use_cores(cores: int) -> None:
    numba.set_num_threads(cores)
    torch.set_num_threads(cores)


def kernels(scene: Scene, crease: float = CONTOURS_ALONE) -> Renderer:
    """The numba kernels on numpy arrays."""
    mesh = scene.screen, scene.colours, scene.topology

    def forward() -> FloatArray:
        return pictures.draw(*mesh, scene.width, scene.height, crease)

    def step() -> Gradients:
        residual = pictures.draw(*mesh, scene.width, scene.height, crease)
        residual -= scene.targets
        residual *= 2.0
        return Gradients(*pictures.draw_gradient(*mesh, residual, crease))

    return Renderer(forward, step)


def autograd(scene: Scene) -> Renderer:
    """The same under torch's autograd, the loss in torch."""

    def loss(pictures: Tensor, targets: Tensor) -> Tensor:
        return functional.mse_loss(pictures, targets, reduction="sum")

    return _through_torch(scene, lambda pictures: pictures, loss)


def fused(scene: Scene) -> Renderer:
    """Log-likelihood with its pyramid and gradients in one kernel; no picture reaches main memory."""
    mesh, scales = (scene.screen, scene.colours, scene.topology), np.ones(scene.count)

    def forward() -> FloatArray:
        return likelihood.log_likelihood(*mesh, scene.targets, CONTOURS_ALONE)

    def step() -> Gradients:
        _, gradients = likelihood.log_likelihood_gradient(*mesh, scene.targets, scales, CONTOURS_ALONE)
        return Gradients(*gradients)

    return Renderer(forward, step)


def composed(scene: Scene) -> Renderer:
    """The same log-likelihood from parts: pictures by autograd, their pyramid by torch's convolutions."""
    targets = torch.from_numpy(scene.targets)

    def loss(pictures: Tensor, _: Tensor) -> Tensor:
        return log_likelihoods(pictures, targets).sum()

    return _through_torch(scene, lambda pictures: log_likelihoods(pictures, targets), loss)


def log_likelihoods(pictures: Tensor, targets: Tensor) -> Tensor:
    """Log-likelihoods [N] of targets [N, C, H, W] given pictures, as `trainer.rendering.reference` defines them."""
    count, channels, height, width = pictures.shape
    row = pictures.new_tensor([1.0, 4.0, 6.0, 4.0, 1.0]) / 16
    kernel = torch.outer(row, row)[None, None]
    level, weight = (pictures - targets).reshape(count * channels, 1, height, width), 1.0
    total = pictures.new_zeros(count)
    while True:
        total = total - 0.5 * weight * level.square().reshape(count, -1).sum(1)
        if min(level.shape[2:]) == 1:
            return total
        level, weight = functional.conv2d(_reflected(level), kernel, stride=2), 4.0 * weight


def _reflected(level: Tensor) -> Tensor:
    """Two more pixels on each side; torch reflects by less than a level's size only."""
    if min(level.shape[2:]) > 2:
        return functional.pad(level, (2, 2, 2, 2), mode="reflect")
    for axis in (2, 3):
        size = level.shape[axis]
        period = max(2 * (size - 1), 1)
        wrapped = torch.arange(-2, size + 2) % period
        level = level.index_select(axis, torch.minimum(wrapped, period - wrapped) % size)
    return level


def _through_torch(
    scene: Scene, output: Callable[[Tensor], Tensor], loss: Callable[[Tensor, Tensor], Tensor]
) -> Renderer:
    screen, colours = torch.from_numpy(scene.screen.copy()), torch.from_numpy(scene.colours.copy())
    targets = torch.from_numpy(scene.targets)

    def draw(screen: Tensor, colours: Tensor) -> Tensor:
        return cpu.draw(screen, colours, scene.topology, scene.width, scene.height, CONTOURS_ALONE)

    def forward() -> FloatArray:
        with torch.no_grad():
            values: FloatArray = output(draw(screen, colours)).numpy()
        return values

    def step() -> Gradients:
        positions, shades = screen.detach().requires_grad_(), colours.detach().requires_grad_()
        gradients = torch.autograd.grad(loss(draw(positions, shades), targets), (positions, shades))
        return Gradients(*(gradient.numpy() for gradient in gradients))

    return Renderer(forward, step)


KERNELS = Contender(
    name="chiaro kernels",
    what="numba kernels on numpy arrays; the loss in numpy",
    prepare=kernels,
    use_cores=use_cores,
    ours=True,
)
EXACT_KERNELS = Contender(
    name="chiaro kernels, exact",
    what="the same, antialiased at every visible edge and interpenetration",
    prepare=lambda scene: kernels(scene, EXACT),
    use_cores=use_cores,
    ours=True,
)
AUTOGRAD = Contender(
    name="chiaro torch",
    what="the kernels as a torch autograd function; the loss in torch",
    prepare=autograd,
    use_cores=use_cores,
    ours=True,
)
FUSED = Contender(
    name="chiaro fused likelihood",
    what="log-likelihood of the Gaussian pyramid and its gradients in one kernel",
    prepare=fused,
    use_cores=use_cores,
    ours=True,
    work="likelihood",
)
COMPOSED = Contender(
    name="chiaro composed likelihood",
    what="the same log-likelihood from torch operations around the autograd function",
    prepare=composed,
    use_cores=use_cores,
    ours=True,
    work="likelihood",
)
CONTENDERS = (KERNELS, EXACT_KERNELS, AUTOGRAD, FUSED, COMPOSED)
