"""The tables of docs/results.md, README's of the models, and a passage of docs/trials.md say what the committed figures
say."""

import json
import re
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[1]
RESULTS = (ROOT / "docs" / "results.md").read_text()
TRIALS = (ROOT / "docs" / "trials.md").read_text()


def figures(path: str) -> dict[str, Any]:
    found: dict[str, Any] = json.loads((ROOT / path).read_text())
    return found


SHIPPED = figures("models/figures.json")
REFINED = figures("benchmarks/refinement.json")["models"]
CUT_OUT, FORMER, OTHER_CAMERAS_BEFORE = (
    figures(name)["models"]
    for name in ("benchmarks/cutouts.json", "docs/results/placement.json", "docs/results/cutouts-before.json")
)
SEVERAL = figures("docs/results/several.json")["models"]
INVENTED = figures("docs/results/samples.json")["models"]
INVENTED_BEFORE = figures("docs/results/self-consistency.json")["before"]
CEILINGS = figures("docs/results/ceilings.json")["iou"]


def section(title: str) -> str:
    """From that heading to the next one."""
    return RESULTS.split(f"\n## {title}\n", 1)[1].split("\n## ", 1)[0]


def rows(text: str) -> dict[str, list[str]]:
    """The cells of each line of the tables in a text, after the first cell, by that."""
    lines = [[cell.strip() for cell in line.strip("|").split("|")] for line in re.findall(r"^\|.*\|$", text, re.M)]
    return {cells[0]: cells[1:] for cells in lines if cells[0] and not set(cells[0]) <= set("-:")}


def guesses(judged: dict[str, Any]) -> str:
    return f"{judged['mean_shape_iou']:.2f} / {judged['nearest_neighbour_iou']:.2f}"


def shape(judged: dict[str, Any]) -> list[str]:
    return [f"{judged[name]:.2f}" for name in ("iou", "mean_shape_iou", "nearest_neighbour_iou")]


def pose(judged: dict[str, Any]) -> list[str]:
    return [f"{judged['symmetric_azimuth_error_degrees']:.1f}°", f"{judged['symmetric_azimuth_accuracy']:.2f}"]


@pytest.mark.parametrize("name", SHIPPED)
def test_the_models_that_ship(name: str) -> None:
    told, test, real = (
        rows(section("The models that ship"))[name],
        SHIPPED[name]["test"],
        SHIPPED[name]["real_meshes"],
    )
    assert [*told[:3], *told[4:]] == [
        *shape(test),
        *pose(test),
        f"{test['flipped']:.2f}",
        f"{test['azimuth_calibration_error']:.2f}",
        f"{test['chamfer_distance']:.3f}",
        *shape(real),
        f"{real['objects']}",
        f"{real['chamfer_distance']:.3f}",
    ]


def test_every_model_that_ships_is_in_the_table() -> None:
    _, judged = section("The models that ship").split("\n| | IoU |")
    assert rows(f"| | IoU |{judged}").keys() == SHIPPED.keys()


def test_how_much_of_them_is_inside_out() -> None:
    test, real = (
        sorted(((judged[part]["inside_out"], name) for name, judged in SHIPPED.items()), reverse=True)
        for part in ("test", "real_meshes")
    )
    named = [f"{share:.2f} of {name}s" for share, name in test if share >= 0.005]
    assert f"`inside_out`) is {', '.join(named)}, and less than 0.005 of all others" in RESULTS
    first = {name for _, name in test[:4]}
    assert all(share < 0.01 for share, name in real if name not in first)
    told = [f"{SHIPPED[name]['real_meshes']['inside_out']:.2f}" for _, name in test[:4]]
    assert f"of real ones {', '.join(told[:3])} and {told[3]} of the first four, and less than 0.01 of all" in RESULTS


@pytest.mark.parametrize("name", SHIPPED)
def test_the_readme_s_table(name: str) -> None:
    other_light = {"car-varying-light": "car, lights that turn", "car-white-light": "car, one white light"}
    told = rows((ROOT / "README.md").read_text())[other_light.get(name, name)]
    test, real = SHIPPED[name]["test"], SHIPPED[name]["real_meshes"]
    assert told == [f"{test['iou']:.2f}", guesses(test), *pose(test), f"{real['iou']:.2f}", guesses(real)]


def flagged(name: str, symmetric: bool) -> str:
    """The share of pictures of objects that half a turn leaves as they are, or not, that are told so."""
    told = figures("docs/results/symmetry.json")["models"][name]["test"]
    chosen = [
        (int(order), count)
        for own, orders in told.items()
        if (own == "continuous" or int(own) % 2 == 0) == symmetric
        for order, count in orders.items()
    ]
    return f"{100 * sum(count for order, count in chosen if order % 2 == 0) / sum(count for _, count in chosen):.0f} %"


def test_which_turns_are_flagged() -> None:
    text = " ".join(section("The models that ship").split())
    both = [flagged("bench", True), flagged("bench", False), flagged("table", True), flagged("table", False)]
    assert (
        "of {} of the benches that it leaves as they are and of {} of the others, of {} and {} of tables".format(*both)
        in text
    )
    fronts = [flagged(name, False) for name in ("car", "sofa", "chair", "bathtub", "loudspeaker", "vessel")]
    assert f"of {fronts[0]} of cars that have a front, {fronts[1]} of sofas and no chair" in text
    assert fronts[2] == "0 %"
    assert "({}, {} and {})".format(*fronts[3:]) in text
    assert flagged("lamp", True) == flagged("lamp", False) == "100 %"
    pots, jars = ([flagged(name, symmetric) for symmetric in (True, False)] for name in ("pot", "jar"))
    assert "of all lamps, of {} and {} of pots, and of {} and {} of jars".format(*pots, *jars) in text


@pytest.mark.parametrize("name", CEILINGS)
def test_how_far_such_meshes_can_come(name: str) -> None:
    told = rows(section("How far such meshes can come"))[name]
    shipped = f"{SHIPPED[name]['test']['iou']:.2f} ({SHIPPED[name]['parameterisation']})"
    assert told[:3] == [f"{CEILINGS[name]['subdivision']:.2f}", f"{CEILINGS[name]['full-block']:.2f}", shipped]


@pytest.mark.parametrize(
    ("row", "setting"),
    [
        ("1,000 chairs, each from 12 sides", "1,000 objects, 12 views"),
        ("4,000 chairs, each from one side", "as it is"),
        ("the same, noise of 0.3 on the codes", "noise 0.3"),
        ("the same, a hidden layer of 128", "hidden 128"),
        ("the same, mirrored shapes", "mirror"),
        ("the same, mirrored, a hidden layer of 128", "mirror, hidden 128"),
        ("the same, mirrored, a hidden layer of 512", "mirror, hidden 512"),
    ],
)
def test_where_that_is_lost(row: str, setting: str) -> None:
    found = figures("docs/results/free-codes.json")["found"][setting]
    told = rows(section("How far such meshes can come"))[row]
    assert told == [f"{found['iou']:.2f}", f"{found['missing_nats']:.0f} nats"]


@pytest.mark.parametrize("name", REFINED)
def test_a_longer_look(name: str) -> None:
    (encoded, refined), (real, real_refined) = (
        (REFINED[name][part]["encoded"], REFINED[name][part]["refined"]) for part in ("test", "real_meshes")
    )
    assert rows(section("A longer look"))[name] == [
        f"{encoded['iou']:.2f} → {refined['iou']:.2f}",
        *(f"{before} → {after}" for before, after in zip(pose(encoded), pose(refined), strict=True)),
        f"{encoded['untempered_calibration_error']:.2f} → {refined['untempered_calibration_error']:.2f}",
        f"{real['iou']:.2f} → {real_refined['iou']:.2f}",
        guesses(real),
        f"{pose(real)[0]} → {pose(real_refined)[0]}",
    ]


@pytest.mark.parametrize("name", SEVERAL)
def test_several_pictures_of_an_object(name: str) -> None:
    expected = []
    for part in ("test", "real_meshes"):
        served = SEVERAL[name][part]["served"]
        expected += [
            " → ".join(f"{served[count]['iou']:.2f}" for count in "1248"),
            f"{SEVERAL[name][part]['largest']['8']['iou']:.2f}",
            " → ".join(f"{served[count]['chamfer_distance']:.3f}" for count in "18"),
        ]
    assert rows(section("Several pictures of an object"))[name] == expected


@pytest.mark.parametrize("name", [*INVENTED, "mean"])
def test_invented_objects(name: str) -> None:
    ones = list(INVENTED.values()) if name == "mean" else [INVENTED[name]]
    counts = ["", ""] if name == "mean" else [f"{INVENTED[name][what]}" for what in ("numbers", "gaussians")]
    expected = []
    for measure, places in (("from_sample", 3), ("to_sample", 3), ("own_kind", 2)):
        means = (sum(one[drawn][measure] for one in ones) / len(ones) for drawn in ("prior", "served"))
        expected.append(" → ".join(f"{value:.{places}f}" for value in means))
    before = [INVENTED_BEFORE[one] for one in (INVENTED if name == "mean" else [name])]
    for measure in ("sample_to_true", "true_to_sample"):
        stages = ([one["prior"] for one in ones], before, [one["served"] for one in ones])
        expected.append(" → ".join(f"{sum(one[measure] for one in stage) / len(stage):.2f}" for stage in stages))
    assert rows(section("Invented objects"))[name] == [*expected, *counts]


JUDGED = section("The demo's recipe, without any label") + TRIALS.split("\n## The first recipe\n", 1)[1]


@pytest.mark.parametrize(("row", "file"), re.findall(r"^\| ([^|]*) \(\[json\]\((results/\S+)\)\) \|", JUDGED, re.M))
def test_the_demo_s_recipe_and_the_first(row: str, file: str) -> None:
    table = JUDGED.splitlines()
    judged = figures(f"docs/{file}")
    start = next(index for index, line in enumerate(table) if line.startswith(f"| {row} "))
    for line, part in zip(table[start : start + 2], ("procedural", "real"), strict=True):
        low, high = judged[part]["iou_interval"]
        assert [cell.strip() for cell in line.strip("|").split("|")][2:] == [
            f"{judged[part]['iou']:.2f} [{low:.2f}, {high:.2f}]",
            f"{judged[part]['mean_shape_iou']:.2f}",
            f"{judged[part]['nearest_neighbour_iou']:.2f}",
            f"{judged[part]['azimuth_error_degrees']:.1f}°",
            f"{judged[part]['azimuth_accuracy']:.2f}",
            f"{judged[part]['flipped']:.2f}",
            f"{judged[part]['chamfer_distance']:.3f}",
        ]


def test_the_decoder_s_rate() -> None:
    """Trainings are told by class, poses, learning rate, decoder's factor and falling share."""
    trainings = {
        (one["class"], one["poses"], one["learning_rate"], one["decoder_factor"], one["falling_share"]): one
        for one in figures("docs/results/decoder-rate.json")["trainings"]
        if one["width"] == 48 and one["kl_weight"] == 8
    }

    def value(name: str, *key: Any) -> float:
        return float(trainings[key][name])

    def change(name: str, category: str, places: int) -> str:
        slow, fast = ((category, "none", 0.001, *rest) for rest in ((1, 0.0), (4, 0.5)))
        return f"{value(name, *slow):.{places}f}{{}} → {value(name, *fast):.{places}f}{{}}"

    given = ("airplane", "given")
    slow, fast, decoder = (*given, 0.001, 1, 0.0), (*given, 0.003, 1, 0.0), (*given, 0.001, 5, 0.0)
    text = " ".join(TRIALS.split())
    distance = "chamfer_distance"
    assert f"(IoU {value('iou', *slow):.2f}, Chamfer distance {value(distance, *slow):.3f})" in text
    assert f"{value('iou', *fast):.2f}" == f"{value('iou', *decoder):.2f}"
    assert f"({value('iou', *fast):.2f}, {value(distance, *fast):.3f} and {value(distance, *decoder):.3f})" in text
    assert f"with ten times everywhere, {value('iou', *given, 0.01, 1, 0.0):.2f}" in text
    rifles = f"({change('iou', 'rifle', 2)}, Chamfer distance {change(distance, 'rifle', 3)})"
    assert rifles.replace("{}", "") in text
    for name in ("car", "chair"):
        error = change("symmetric_azimuth_error_degrees", name, 1).format("°", "°")
        assert re.search(re.escape(f"({change('iou', name, 2).format('', '')}, ") + f"(error )?{error}\\)", text)
    flipped = value("flipped", "airplane", "none", 0.001, 4, 0.0)
    assert f"{flipped:.0%} of them are flipped".replace("%", " %") in text


def told(judged: list[dict[str, Any]]) -> str:
    iou, right = (sum(one[key] for one in judged) / len(judged) for key in ("iou", "symmetric_azimuth_accuracy"))
    return f"{iou:.2f}, {right:.2f}"


CAMERAS = ("cut out", "darker", "brighter")
RULED, SEARCHED = "cut out, 0 rounds", "cut out, 2 rounds"


@pytest.mark.parametrize("name", [*CUT_OUT, "mean"])
@pytest.mark.parametrize(
    ("document", "head", "models", "sources", "ways"),
    [
        (RESULTS, "framed | cut out", CUT_OUT, ("test", "real_meshes"), ("framed", *CAMERAS)),
        (TRIALS, "framed | by rule", FORMER, ("test", "real_meshes"), ("framed", RULED, SEARCHED)),
        (TRIALS, "cut out | half the light", OTHER_CAMERAS_BEFORE, ("test",), CAMERAS),
    ],
    ids=["today", "before the phase", "before other cameras"],
)
def test_cut_out_objects(
    name: str, document: str, head: str, models: dict[str, Any], sources: tuple[str, ...], ways: tuple[str, ...]
) -> None:
    table = document.split(f"\n| | {head} |")[1].split("\n\n", maxsplit=1)[0]
    names = list(models) if name == "mean" else [name]
    expected = [told([models[one][source][way] for one in names]) for source in sources for way in ways]
    assert rows(table)[name] == expected


def test_auto() -> None:
    found = figures("docs/results/auto.json")
    sources, ways = ("procedural", "real meshes"), ("framed", "cut out")
    shares = [found[source][way]["right"] for source in sources for way in ways]
    named = re.search(
        r"for (\d+) % of framed pictures and (\d+) % of cut-out ones.*?for (\d+) % and (\d+) %",
        section("Cut-out objects"),
        re.S,
    )
    assert named
    assert [int(share) for share in named.groups()] == [round(100 * share) for share in shares]


@pytest.mark.parametrize(
    ("row", "where"), [("in memory", "/dev/shm (tmpfs)"), ("`/tmp`", "/tmp (ext4)"), ("`out`", "out (ext4)")]
)
def test_how_fast_pictures_are_drawn(row: str, where: str) -> None:
    rates = figures("benchmarks/rendering.json")["medians"][where]
    text = section("Pictures and judging, in seconds")
    classes = re.findall(r"\w+", text.split("\n| in memory ")[0].splitlines()[-2])
    assert dict(zip(classes, rows(text)[row], strict=True)) == {name: f"{rate:,}" for name, rate in rates.items()}


def test_how_long_judging_takes() -> None:
    found = figures("benchmarks/judging.json")
    assert "for 100 meshes in 24 views each, aligned by 200 pictures" in found["what"]
    said = re.search(r"takes (\d+) s \(`make bench-judging`", section("Pictures and judging, in seconds"))
    assert said
    assert int(said[1]) == round(found["median"])


@pytest.mark.parametrize("load", figures("benchmarks/service.json")["loads"], ids=lambda load: f"{load['clients']}")
def test_how_fast_the_service_answers(load: dict[str, Any]) -> None:
    answered, graphs = load["service"], load["graphs_one_thread"]
    assert rows(section("The service"))[str(load["clients"])] == [
        f"{answered['p50_ms']:.1f} ms",
        f"{answered['p99_ms']:.0f} ms",
        f"{answered['per_second']:.0f}",
        f"{graphs['p50_ms']:.2f} ms",
    ]
    assert set(answered["outcomes"]) == {"right"}


def test_how_the_service_fares_for_long() -> None:
    found = figures("benchmarks/service_soak.json")
    long, overload = found["long"], found["overload"]
    assert long["outcomes"] == {"right": 100_000}
    assert set(overload["outcomes"]) == {"right", "429 with Retry-After"}
    said = section("The service")
    assert f"{long['per_second']:.0f} a second came" in said
    assert f"memory grew by {long['mebibytes_per_100000_requests']:.1f} MiB" in said
    assert f"{overload['offered_per_second']:.0f} a second: {overload['served_per_second']:.0f} were answered" in said
    assert f"{overload['served_p99_ms']:.0f} ms at most" in said
