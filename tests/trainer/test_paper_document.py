"""`docs/paper.md` leads to what is there: every file, function, test, setting, preset and command that it names."""

import ast
import re
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from trainer.commands.line import COMMANDS
from trainer.config import TrainConfig
from trainer.mapping import to_mapping
from trainer.presets import load_preset

ROOT = Path(__file__).parents[2]
DOCUMENT = (ROOT / "docs/paper.md").read_text()
NAMES = sorted(set(re.findall(r"`([^`\n]+)`", DOCUMENT)))
CODE = [name for name in NAMES if re.fullmatch(r"[\w/.-]+/[\w.-]+\.py(: .+)?", name)]
TESTS = [name for name in NAMES if name.startswith("test_")]
SETTINGS = [name for name in NAMES if re.fullmatch(r"(model|loss|optimiser)\.\w+", name)]
PRESETS = sorted(
    {*re.findall(r"--preset ([a-z][\w/-]*)", DOCUMENT), *re.findall(r"`((?:table|figure)-\d/[\w/-]+)`", DOCUMENT)}
)
CALLED = sorted(set(re.findall(r"`python -m trainer (\w+)", DOCUMENT)))


def rows_of(section: str) -> list[list[str]]:
    """The cells of a section's table, without its heading."""
    (text,) = (part for part in DOCUMENT.split("\n## ") if part.startswith(section))
    lines = [line for line in text.splitlines() if line.startswith("|")][2:]
    return [[cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]] for line in lines]


@cache
def defined_in(path: Path) -> frozenset[str]:
    """What a module names at its top."""
    names: set[str] = set()
    for node in ast.parse(path.read_text()).body:
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            names.add(node.name)
        elif isinstance(node, ast.Assign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            names |= {child.id for target in targets for child in ast.walk(target) if isinstance(child, ast.Name)}
    return frozenset(names)


@cache
def all_tests() -> frozenset[str]:
    found = {name for path in (ROOT / "tests").rglob("test_*.py") for name in defined_in(path)}
    return frozenset(name for name in found if name.startswith("test_"))


@pytest.mark.parametrize("name", CODE)
def test_every_file_and_function_is_there(name: str) -> None:
    path, _, names = name.partition(": ")
    assert (ROOT / path).is_file()
    assert set(names.split(", ") if names else ()) <= defined_in(ROOT / path)


@pytest.mark.parametrize("name", TESTS)
def test_every_test_is_there(name: str) -> None:
    """An ellipsis stands for the rest of a long name."""
    begin = name.removesuffix("…")
    matching = [test for test in all_tests() if (test.startswith(begin) if name.endswith("…") else test == begin)]
    assert len(matching) == 1


@pytest.mark.parametrize("name", SETTINGS)
def test_every_setting_is_there(name: str) -> None:
    section, _, field = name.partition(".")
    assert field in to_mapping(TrainConfig())[section]


@pytest.mark.parametrize("name", PRESETS)
def test_every_preset_is_there(name: str) -> None:
    assert isinstance(load_preset(name), TrainConfig)


@pytest.mark.parametrize("name", CALLED)
def test_every_command_is_there(name: str) -> None:
    assert name in COMMANDS


def test_hyperparameters_are_those_of_the_paper_s_preset() -> None:
    named = 0
    for _, _, setting, value, *_ in rows_of("Hyperparameters"):
        if setting == "–":
            continue
        found: Any = to_mapping(load_preset("paper"))
        for key in setting.strip("`").split("."):
            found = found[key]
        assert (", ".join(map(str, found)) if isinstance(found, list) else str(found)) == value, setting
        named += 1
    assert named == 17


@pytest.mark.parametrize("section", ["Equations", "Hyperparameters", "Figures"])
def test_every_row_leads_to_code_and_to_a_test(section: str) -> None:
    for row in rows_of(section):
        *_, function, test = row
        assert any(f"`{name}`" in function for name in CODE) or function == "the same", row
        assert re.search(r"`(test_|tests/)", test), row


def test_nothing_of_the_paper_is_left_out() -> None:
    told = " ".join(row[0] for row in rows_of("Equations"))
    equations = {
        int(number) for group in re.findall(r"Eq\. ([\d, ]+)", told) for number in group.split(",") if number.strip()
    }
    assert equations == set(range(1, 15))
    assert [row[0] for row in rows_of("Figures")] == [f"Figure {number}" for number in range(1, 12)]
    tables = {row[0] for row in rows_of("Tables")}
    assert {f"Table {number}" for number in range(1, 8)} <= tables


def test_the_page_names_much() -> None:
    """Should its form change, the tests above would be of nothing."""
    assert min(len(CODE) - 40, len(TESTS) - 35, len(SETTINGS) - 12, len(PRESETS) - 4, len(CALLED) - 4) >= 0
