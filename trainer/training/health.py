"""What tells a healthy training from a failing one, and costs too much to look at in every step."""

import math
from collections.abc import Callable

import torch
from jaxtyping import Float
from torch import Tensor

from trainer import processes
from trainer.config import SceneConfig
from trainer.data.shapes.solid import Mesh, signed_volume
from trainer.evaluation.gallery import render
from trainer.geometry.intersections import crossed_faces
from trainer.model.posterior import most_probable_azimuth, most_probable_light
from trainer.model.vae import Model
from trainer.training.step import StepResult


def health_of(
    model: Model, scene: SceneConfig, shown: Float[Tensor, "N 3 H W"], forward: Callable[[], StepResult]
) -> dict[str, float]:
    """Figures for the journal; `forward` is a training step's forward pass, and `shown` a few pictures.

    `gradient_<term>`: Euclidean norm of each term's gradient over all parameters, where the term has one.
    `rerender_error`: Σ (x − x̂)² / Σ x² between pictures and reconstructions; 1 is as bad as black.
    `prototype_volume`: what the mesh of the code 0 encloses, cubic diagonals; negative if it is inside out.
    `self_intersections`: the share of its faces that another part of it passes through.

    The model is left in evaluation mode, and otherwise as it was.
    """
    gradients = term_gradients(model, forward)
    model.eval()
    with torch.no_grad():
        prototype = model.decode(shown.new_zeros(1, model.config.latent))[0].double().cpu().numpy()
        posterior = model.encode(shown)
        azimuth, light = most_probable_azimuth(posterior), most_probable_light(posterior)
        drawn = render(model.faces, scene, model.decode(posterior.shape_mean), azimuth, light)
    faces = model.faces.cpu().numpy()
    return gradients | {
        "rerender_error": float((drawn - shown).square().sum() / shown.square().sum().clamp_min(1e-6)),
        "prototype_volume": signed_volume(Mesh(prototype, faces)),
        "self_intersections": float(crossed_faces(prototype, faces).mean()),
    }


def term_gradients(model: Model, forward: Callable[[], StepResult]) -> dict[str, float]:
    """`gradient_<term>` of `health_of`. Running means of the batch normalisation are put back."""
    model.train()
    kept = [buffer.clone() for buffer in model.buffers()]
    parameters = list(model.parameters())
    norms: dict[str, float] = {}
    for name, term in forward().terms._asdict().items():
        if term.requires_grad:
            gradients = torch.autograd.grad(term, parameters, retain_graph=True, allow_unused=True)
            norms[f"gradient_{name}"] = math.sqrt(
                sum(float(processes.mean(gradient).square().sum()) for gradient in gradients if gradient is not None)
            )
    with torch.no_grad():
        for buffer, value in zip(model.buffers(), kept, strict=True):
            buffer.copy_(value)
    return norms
