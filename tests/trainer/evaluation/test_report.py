"""What the judge writes: JSON for programs, a table and lines for people."""

import dataclasses
import json

import pytest

from trainer.evaluation.metrics import Interval
from trainer.evaluation.report import BaselineFigures, FrameFigures, Report, as_json, as_markdown, as_text

FRAME_NAMES = {field.name for field in dataclasses.fields(FrameFigures)}
FIGURES = FrameFigures(*(Interval(0.1 * place, 0.05, 0.95) for place in range(1, 11)))
REPORT = Report(
    aligned=FIGURES,
    unaligned=dataclasses.replace(FIGURES, iou=Interval(0.25, 0.2, 0.3)),
    baselines=BaselineFigures(Interval(0.5, 0.4, 0.6), Interval(0.55, 0.45, 0.65)),
    light_error_degrees=None,
    picture_error=Interval(0.0312345, 0.03, 0.04),
    inside_out=Interval(0.25, 0.2, 0.3),
    azimuth_offset_degrees=-1e-7,
    azimuth_temperature=1.5,
    symmetric_objects={"2": 3, "continuous": 1},
    pictures=24,
    views_per_instance=1,
    objects=3,
    skipped_meshes=2,
)
NOT_FITTED = {"aligned": None, "baselines": None, "azimuth_offset_degrees": None, "azimuth_temperature": None}
ALONE = dataclasses.replace(REPORT, **NOT_FITTED, skipped_meshes=0)


def test_json_is_flat_and_has_all_names_always() -> None:
    flat = json.loads(json.dumps(as_json(REPORT), allow_nan=False))
    intervals = FRAME_NAMES | {f"{name}_unaligned" for name in FRAME_NAMES}
    intervals |= {"mean_shape_iou", "nearest_neighbour_iou", "light_error_degrees", "picture_error", "inside_out"}
    others = {"azimuth_offset_degrees", "symmetric_objects", "pictures", "views_per_instance", "objects"}
    others |= {"azimuth_temperature", "skipped_meshes"}
    assert flat.keys() == intervals | {f"{name}_interval" for name in intervals} | others
    assert flat.keys() == as_json(ALONE).keys()
    assert {"iou", "azimuth_error_degrees", "azimuth_accuracy", "chamfer_distance", "flipped"} <= intervals


def test_json_holds_the_figures() -> None:
    flat = as_json(REPORT)
    assert (flat["iou"], flat["iou_interval"]) == (0.1, [0.05, 0.95])
    assert (flat["iou_unaligned"], flat["iou_unaligned_interval"]) == (0.25, [0.2, 0.3])
    assert flat["normal_consistency"] == 1.0
    assert flat["azimuth_temperature"] == 1.5
    assert flat["nearest_neighbour_iou_interval"] == [0.45, 0.65]
    assert flat["picture_error"] == 0.0312
    assert flat["inside_out_interval"] == [0.2, 0.3]
    assert flat["light_error_degrees"] is flat["light_error_degrees_interval"] is None
    assert flat["symmetric_objects"] == {"2": 3, "continuous": 1}
    assert str(flat["azimuth_offset_degrees"]) == "0.0"


def test_what_is_not_known_is_null() -> None:
    flat = as_json(ALONE)
    assert {flat[name] for name in FRAME_NAMES} == {None}
    assert flat["mean_shape_iou"] is flat["azimuth_offset_degrees"] is None
    assert flat["iou_unaligned"] == 0.25


def test_the_table_has_both_frames_and_names_what_was_skipped() -> None:
    page = as_markdown(REPORT, "chair", ("a.obj: broken", "b.glb: empty"))
    assert page.startswith("# chair: 3 objects in 24 pictures\n")
    assert "| figure | after one azimuth offset of 0.0° and a temperature of 1.50 | without |" in page
    assert "| IoU at 32³ | 0.100 [0.050, 0.950] | 0.250 [0.200, 0.300] |" in page
    assert "| azimuth error, median | 0.2° [0.1, 0.9] | 0.2° [0.1, 0.9] |" in page
    assert "| IoU of the nearest neighbour | 0.550 [0.450, 0.650] | |" in page
    assert "| light error, median | – | |" in page
    assert "| inside out | 0.250 [0.200, 0.300] | |" in page
    assert "Rotational symmetries: 3 of order 2, 1 continuous." in page
    assert page.endswith("2 mesh files could not be read and were left out:\n\n- a.obj: broken\n- b.glb: empty\n")
    assert "--validation" not in page


@pytest.mark.parametrize("told", [as_markdown(ALONE, "chair"), as_text(ALONE, "chair")])
def test_the_want_of_validation_pictures_is_told(told: str) -> None:
    assert "neither azimuth offset nor temperature are fitted" in " ".join(told.split())
    assert "0.250" in told
    assert "nan" not in told.lower()


def test_lines_for_a_terminal_leave_out_what_is_not_known() -> None:
    lines = as_text(REPORT, "chair").splitlines()
    assert lines[0] == "3 objects, 24 pictures of chair"
    assert not any("light" in line for line in lines)
    assert "IoU at 32³                    0.100 [0.050, 0.950]" in lines
    assert "skipped                       2 mesh files that cannot be read" in lines
    assert lines[-2:] == ["canonical frame               turned by 0°", "temperature of the bins       1.50"]
    assert not any("baseline" in line or "mean shape" in line for line in as_text(ALONE, "chair").splitlines()[:-1])
    none = dataclasses.replace(REPORT, symmetric_objects={})
    assert "rotational symmetries         none" in as_text(none, "chair").splitlines()
