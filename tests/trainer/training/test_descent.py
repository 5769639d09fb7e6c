"""What one step of the optimiser leaves behind."""

from typing import NamedTuple

import torch
from torch import Tensor, nn

from trainer.training.descent import Given, Unrecorded


class Distances(NamedTuple):
    each: Tensor
    unit: str = "nats"


class Result(NamedTuple):
    distances: Distances
    largest: Tensor

    def loss(self) -> Tensor:
        return self.distances.each.sum()


def test_what_a_step_gives_holds_its_values_and_no_graph() -> None:
    model = nn.Linear(3, 1, bias=False)
    nn.init.ones_(model.weight)

    def forward(given: Given) -> Result:
        each = model(given.pictures)
        return Result(Distances(each), each.max())

    pictures = torch.arange(6.0).reshape(2, 3)
    taken = Unrecorded(model, 1e3, forward)(Given(pictures, None, None, torch.Generator()))
    assert taken is not None
    assert model.weight.grad is not None
    assert model.weight.grad.tolist() == [[3.0, 5.0, 7.0]]
    assert taken.result.distances.each.tolist() == [[3.0], [12.0]]
    assert taken.result.distances.unit == "nats"
    assert taken.result.largest == 12.0
    assert taken.result.distances.each.grad_fn is None
    assert taken.result.largest.grad_fn is None
