"""A frontier on the disk: data, page and charts, in the layout of docs/."""

import json
from importlib.util import find_spec
from pathlib import Path

from trainer.data.writing import write_bytes
from trainer.frontier.page import as_markdown, placed
from trainer.frontier.report import Report, as_csv
from trainer.mapping import from_mapping, to_mapping

PAGE_FILE, DATA_FILE, TABLE_FILE, CHARTS = "frontier.md", "results/frontier.json", "results/frontier.csv", "images"


def write_report(report: Report, folder: Path) -> list[str]:
    """Writes all files; what of a page stands outside its figures is kept. Charts need matplotlib, and are left out
    where it is not installed. Returns the names of what was written."""
    page = folder / PAGE_FILE
    text = page.read_text(encoding="utf-8") if page.exists() else ""
    write_bytes(folder / DATA_FILE, (json.dumps(to_mapping(report), indent=1, allow_nan=False) + "\n").encode())
    write_bytes(folder / TABLE_FILE, as_csv(report).encode())
    write_bytes(page, placed(text, as_markdown(report)).encode())
    return [PAGE_FILE, DATA_FILE, TABLE_FILE, *_charts(report, folder / CHARTS)]


def read_report(folder: Path) -> Report:
    """Raises ConfigError for data of another form."""
    file = folder / DATA_FILE
    return from_mapping(Report, json.loads(file.read_text(encoding="utf-8")), str(file))


def _charts(report: Report, folder: Path) -> list[str]:
    if find_spec("matplotlib") is None:
        return []
    from trainer.frontier.charts import write_charts  # noqa: PLC0415

    return [f"{CHARTS}/{file.name}" for file in write_charts(report, folder)]
