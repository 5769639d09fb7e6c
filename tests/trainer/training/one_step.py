"""Loss, gradients and running means of a first step, in as many processes as torchrun starts: FOLDER TARGET.

In double precision, so that what differs is not rounding: the normalisation of small batches makes much of that.
"""

import sys
import weakref
from dataclasses import replace
from pathlib import Path

import torch
from torch import Tensor, distributed

from trainer import processes
from trainer.config import LossConfig, ModelConfig, OptimiserConfig, TrainConfig
from trainer.data.images import frame_in, load_image_folder
from trainer.data.source import FolderPictures
from trainer.model.batch_norm import synchronise
from trainer.model.front_back import Sides
from trainer.model.loss import pose_in_code
from trainer.model.vae import Model, model_of
from trainer.training.descent import Given
from trainer.training.device import CPU
from trainer.training.figures import figures_of
from trainer.training.lessons import Studied, lessons
from trainer.training.longer_look import Look
from trainer.training.loop import stepping
from trainer.training.neighbours import Memory
from trainer.training.reframing import learn_reframed
from trainer.training.schedule import weights_at
from trainer.training.step import FixedGeometry

SETTINGS = {
    name: TrainConfig(
        width=32,
        height=24,
        model=ModelConfig(latent=4, azimuth_bins=6, segments=2, encoder_channels=(4, 4, 8, 8, 8, 16)),
        loss=loss,
        optimiser=OptimiserConfig(batch_size=8, views_per_instance=views),
    )
    for name, loss, views in (
        ("exact", LossConfig(), 1),
        ("paper", LossConfig(objective="paper"), 1),
        ("two views", LossConfig(), 2),
        ("neighbours", LossConfig(neighbour_weight=1.0), 1),
        ("inversion", LossConfig(inversion_weight=1e6), 1),
        ("lattice", LossConfig(inversion_weight=1e6, inner_points="learnt"), 1),
        ("front and back", LossConfig(front_back_weight=1e3), 1),
        ("front and back, unlike", LossConfig(front_back_weight=1e3, front_back_knee=2.0), 1),
    )
}


def begun(config: TrainConfig, folder: Path) -> tuple[FolderPictures, Model]:
    """All pictures of the folder, and a new model in double precision."""
    images = load_image_folder(folder, config.width, config.height)
    source = FolderPictures(images, torch.arange(len(images)), torch.arange(0))
    torch.manual_seed(0)
    model = model_of(config).double()
    if processes.count() > 1:
        synchronise(model.encoder)
    return source, model


def moved_to(geometry: FixedGeometry, device: torch.device) -> FixedGeometry:
    """With all but its topology, which stays on the host, on a device."""
    laplacian, solid, sides = geometry.laplacian, geometry.solid, geometry.sides
    return geometry._replace(
        laplacian=None if laplacian is None else laplacian.to(device),
        solid=None if solid is None else (solid[0].to(device), solid[1].to(device)),
        sides=None if sides is None else Sides(sides.source.to(device), sides.sign.to(device)),
    )


def first_step(config: TrainConfig, folder: Path) -> dict[str, Tensor]:
    source, model = begun(config, folder)
    scene = replace(source.scene, width=config.width, height=config.height)
    views = config.optimiser.views_per_instance
    batch, _, generator = next(source.minibatches(config.optimiser.batch_size, 0, 0, views))
    weights = weights_at(config.loss, 1000, config.width, config.height)
    # It averages the gradients as long as it lives.
    random = torch.Generator().manual_seed(0)
    memory = Memory(config.model.latent).double()
    codes, azimuths = torch.randn(200, config.model.latent, generator=random), 7 * torch.randn(200, generator=random)
    own = processes.share(200)
    memory.remember(codes[own].double(), azimuths[own].double())
    taking = stepping(model, scene, replace(config, precision="float32"), CPU, memory)
    result = taking(Given(batch.double(), None, weights, generator))
    result.loss().backward()
    figures = {name: torch.tensor(value) for name, value in figures_of(result, 0.0).items()}
    gradients = {name: parameter.grad for name, parameter in model.named_parameters() if parameter.grad is not None}
    return figures | gradients | dict(model.named_buffers())


def first_reframing(folder: Path) -> dict[str, Tensor]:
    """The same of the last phase, by itself: divergence, the gradient's norm and the running means."""
    config = SETTINGS["exact"]
    source, model = begun(config, folder)
    random = torch.Generator().manual_seed(0)
    count, latent = len(source.images), config.model.latent
    look = Look(torch.randn(count, latent, generator=random), 0.1 * torch.randn(count, generator=random), None)
    found = lessons(config, Studied(source.images, look.each(Tensor.double)), 0)
    taught = (one._replace(pictures=one.pictures.double()) for one in found)
    (taken,) = list(learn_reframed(model, replace(config, precision="float32"), frame_in(source.scene), taught, 1))
    assert taken is not None
    loss = processes.mean(taken.result.loss().detach())
    return {"loss": loss, "norm": torch.tensor(taken.gradient_norm)} | dict(model.named_buffers())


def telling_codes(_: Path) -> dict[str, Tensor]:
    """What codes tell of poses, where they do, and its gradient: of each process's share of eight pictures."""
    random = torch.Generator().manual_seed(0)
    bins = torch.randint(6, (8,), generator=random)
    responsibility = torch.eye(6, dtype=torch.float64)[bins]
    # Other codes on the one side of the circle than on the other.
    code = 0.1 * torch.randn(8, 3, dtype=torch.float64, generator=random) + (bins < 3)[:, None]
    own = processes.share(8)
    part = code[own].requires_grad_()
    value = pose_in_code(part, responsibility[own])
    value.backward()
    assert part.grad is not None
    # Gradients of processes are averaged, as if each had the whole loss.
    return {"value": value.detach(), "gradient": processes.whole(part.grad) / processes.count()}


PARTS = {"reframing": first_reframing, "telling codes": telling_codes}


def main() -> None:
    folder, target = map(Path, sys.argv[1:])
    torch.set_num_threads(1)
    with processes.joined():
        group = weakref.ref(distributed.group.WORLD)
        found = {name: first_step(config, folder) for name, config in SETTINGS.items()}
        found |= {name: part(folder) for name, part in PARTS.items()}
        if processes.number() == 0:
            torch.save(found, target)
    assert group() is None, "The group is still held: its threads may abort the process as Python ends."


if __name__ == "__main__":
    main()
