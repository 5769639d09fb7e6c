"""How much is looked at: a first look in minutes, or what the committed page rests on."""

from dataclasses import dataclass
from typing import Literal

BudgetName = Literal["small", "full"]


@dataclass(frozen=True)
class Budget:
    """Numbers of pictures, severities and steps."""

    objects: int
    """Test objects of each model; a picture of each is taken through all conditions."""
    views: int
    """Pictures of each of them that are told apart by what they show."""
    validation_objects: int
    """Other objects, on which the azimuth offset is fitted; a picture each."""
    others: int
    """Objects of each other class; a picture each."""
    every_severity: bool
    """Otherwise none, a middle one and the worst."""
    training_pictures: int
    """Of cars; half as many of chairs."""
    steps: int
    """Of each training."""
    seeds: int
    """Trainings of each regime."""
    judged_objects: int
    """Test objects of each trained model, and as many others for its offset; a picture each."""
    scenes: int
    """Random scenes at each angle, of the rasteriser."""


BUDGETS: dict[BudgetName, Budget] = {
    "small": Budget(16, 2, 40, 4, False, 200, 20, 1, 24, 1),
    "full": Budget(100, 4, 200, 30, True, 4000, 300, 3, 100, 4),
}


def severities_of(budget: Budget, all_of_them: tuple[float, ...]) -> tuple[float, ...]:
    """Those of a condition that are looked at, the first one always."""
    if budget.every_severity:
        return all_of_them
    return all_of_them[0], all_of_them[len(all_of_them) // 2], all_of_them[-1]
