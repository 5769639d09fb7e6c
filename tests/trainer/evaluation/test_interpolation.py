"""A way from one shape code to another is straight, even, and ends where it should."""

import torch

from trainer.evaluation.interpolation import shape_codes_between, there_and_back


def test_a_way_is_straight_and_its_ends_are_exact() -> None:
    first, last = torch.randn(2, 7, generator=torch.Generator().manual_seed(0)).unbind()
    codes = shape_codes_between(first, last, torch.linspace(0, 1, 5))
    assert torch.equal(codes[0], first)
    assert torch.equal(codes[-1], last)
    torch.testing.assert_close(codes.diff(dim=0), ((last - first) / 4).expand(4, -1))


def test_there_and_back_closes_on_itself() -> None:
    torch.testing.assert_close(there_and_back(8), torch.tensor([0.0, 0.25, 0.5, 0.75, 1.0, 0.75, 0.5, 0.25]))
