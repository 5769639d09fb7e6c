"""A report whose fronts are known."""

from trainer.frontier.accuracy import Run
from trainer.frontier.plan import Scale
from trainer.frontier.report import Machine, Measured, Report


def run(iou: float, seed: int = 0, minutes: float = 1.0) -> Run:
    return Run(
        seed=seed,
        steps=500,
        minutes=minutes,
        iou=iou,
        iou_interval=(iou - 0.02, iou + 0.02),
        azimuth_error_degrees=100 * (1 - iou),
        azimuth_accuracy=0.9,
        flipped=0.05,
        picture_error=(1 - iou) / 10,
        mean_shape_iou=0.6,
        nearest_neighbour_iou=0.65,
    )


def measured(
    name: str, factor: str, iou: float, latency_ms: float, minutes: float = 1.0, category: str = "car"
) -> Measured:
    """Two runs, 0.01 apart, of the default; one of the others."""
    ious = (iou - 0.005, iou + 0.005) if name == "default" else (iou,)
    return Measured(
        category=category,
        name=name,
        factor=factor,
        factor_title=factor.capitalize(),
        factor_default="" if factor in ("default", "paper") else "usual",
        factor_cost="training_minutes",
        label=f"the {name}",
        width=48,
        height=36,
        bundle="float32",
        refine=0,
        iou=iou,
        azimuth_error_degrees=round(100 * (1 - iou), 3),
        azimuth_accuracy=0.9,
        picture_error=(1 - iou) / 10,
        latency_ms=latency_ms,
        training_minutes=minutes,
        bundle_mb=2.0,
        memory_mb=70.0,
        multiply_adds_millions=10.0,
        parameters_thousands=500.0,
        steps=500,
        renderings_thousands=384.0,
        runs=tuple(run(value, seed, minutes) for seed, value in enumerate(ious)),
    )


POINTS = (
    measured("default", "default", 0.70, 2.0),
    # As good for half of the time.
    measured("half", "width", 0.70, 1.0),
    # Worse by less than seeds differ.
    measured("quarter", "width", 0.693, 0.5),
    # Better by more than that, and dearer.
    measured("large", "size", 0.75, 4.0, minutes=3.0),
    # Nothing speaks for it.
    measured("worse", "bins", 0.5, 3.0, minutes=2.0),
    measured("paper", "paper", 0.4, 2.0),
)

REPORT = Report(
    budget="full",
    date="2026-11-22",
    machine=Machine("A processor", 2, "Linux x86_64", "3.11.2", "2.13.0", "1.27.0"),
    scale=Scale("fast", 4000, 200, 2, 96, 72),
    points=(*POINTS, measured("default", "default", 0.3, 2.0, category="chair")),
    skipped=("bundle-int8, car: not trained",),
)
