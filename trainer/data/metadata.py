"""`metadata.csv`: what is known about each picture of a folder (the ImageFolder convention)."""

import csv
import io
import math
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

from trainer.data.writing import write_bytes
from trainer.errors import DataError

METADATA_FILE = "metadata.csv"


class Row(NamedTuple):
    """One picture. Columns of the file have these names; all but `file_name` may be absent or empty there."""

    file_name: str
    """Path relative to the folder, with forward slashes."""
    instance: str
    """The object that the picture shows; equal names are views of one object."""
    azimuth_degrees: float | None
    """The object's azimuth θ, degrees."""
    light_azimuth_degrees: float | None
    """How far the lights are turned, degrees."""


def write_metadata(folder: Path, rows: Iterable[Row]) -> None:
    """Writes `metadata.csv`. Raises StorageError where that is impossible."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(Row._fields)
    writer.writerows(["" if value is None else value for value in row] for row in rows)
    write_bytes(folder / METADATA_FILE, text.getvalue().encode())


def read_metadata(folder: Path) -> dict[str, Row] | None:
    """The rows by file name, or None where the folder has no `metadata.csv`. Other columns are ignored.

    A row without an instance is an object of its own. Raises DataError, naming the line, where `file_name` is missing
    or repeated, or an angle is not a number.
    """
    path = folder / METADATA_FILE
    if not path.exists():
        return None
    rows: dict[str, Row] = {}
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            reader = csv.DictReader(file)
            if "file_name" not in (reader.fieldnames or ()):
                found = ", ".join(reader.fieldnames or ()) or "an empty file"
                raise DataError(f"{path}: expected a column file_name, found {found}; add it or delete the file")
            for line, cells in enumerate(reader, start=2):
                row = _row(cells, f"{path}, line {line}")
                if row.file_name in rows:
                    raise DataError(f"{path}, line {line}: {row.file_name} has a row already; keep one of them")
                rows[row.file_name] = row
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise DataError(f"{path}: expected a CSV file in UTF-8, found {error}; mend it or delete it") from error
    return rows


def _row(cells: dict[str, str | None], where: str) -> Row:
    name = (cells.get("file_name") or "").strip().replace("\\", "/").removeprefix("./")
    if not name:
        raise DataError(f"{where}: expected a file name, found none; delete the line or fill it in")
    return Row(
        name,
        (cells.get("instance") or "").strip() or name,
        _angle(cells.get("azimuth_degrees"), f"{where}: azimuth_degrees"),
        _angle(cells.get("light_azimuth_degrees"), f"{where}: light_azimuth_degrees"),
    )


def _angle(cell: str | None, where: str) -> float | None:
    if cell is None or not cell.strip():
        return None
    try:
        value = float(cell)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise DataError(f"{where}: expected a number of degrees, found {cell!r}; correct it or leave it empty")
    return value
