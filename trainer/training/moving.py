"""Hypotheses moved across the picture, so that they are compared with it apart from where in it they lie."""

import torch
from jaxtyping import Float, Int64
from torch import Tensor
from torch.nn.functional import pad

from trainer.training.views import Views


def moved_onto(views: Views, images: Float[Tensor, "B 3 H W"], faces: Int64[Tensor, "F 3"]) -> Views:
    """Each view shifted on the screen until its centre of brightness is the picture's. Differentiable.

    The camera looks at the middle of an object's bounding box. Where the bulk lies off that middle (an aeroplane's
    wings), turning the shape round moves most of what is seen, and that decides between front and back before tail
    and nose are seen at all (`loss.moved_steps`). The view's centre is that of the faces that look at the camera, by
    their area and mean colour, hidden ones included; of several lights, by their mean.
    """
    aim = brightness_centre(images)[:, None]
    corners = views.screen[:, :, faces, :2]
    first, second = corners[..., 1, :] - corners[..., 0, :], corners[..., 2, :] - corners[..., 0, :]
    # y points down on the screen, so faces that are seen from outside turn clockwise there.
    area = (first[..., 1] * second[..., 0] - first[..., 0] * second[..., 1]).clamp(min=0)
    weight = area * views.colours.flatten(3).mean(-1)[:, :, faces].mean(-1)
    centre = (corners.mean(-2) * weight[..., None]).sum(2) / weight.sum(2, keepdim=True).clamp(min=1e-6)
    return views._replace(screen=views.screen + pad(aim - centre, (0, 1))[:, :, None])


def brightness_centre(images: Float[Tensor, "B 3 H W"]) -> Float[Tensor, "B 2"]:
    """x and y of the mean place of a picture's light, pixels; (0, 0) of a black one."""
    light = images.sum(1)
    total = light.sum((1, 2)).clamp(min=1e-6)
    places = [torch.arange(count, device=light.device, dtype=light.dtype) + 0.5 for count in light.shape[:0:-1]]
    return torch.stack(
        [(light.sum(axis) * place).sum(1) / total for axis, place in zip((1, 2), places, strict=True)], 1
    )
