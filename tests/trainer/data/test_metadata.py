"""metadata.csv: read back as written, tolerant of what others write, exact about what is wrong."""

from pathlib import Path

import pytest

from trainer.data.metadata import METADATA_FILE, Row, read_metadata, write_metadata
from trainer.errors import DataError


def test_rows_survive_their_file(tmp_path: Path) -> None:
    rows = [Row("car/a, b.png", 'an "odd" name', -179.9999, 12.5), Row("ü.png", "ü", None, None)]
    write_metadata(tmp_path, rows)
    assert read_metadata(tmp_path) == {row.file_name: row for row in rows}
    assert (
        (tmp_path / METADATA_FILE).read_text().startswith("file_name,instance,azimuth_degrees,light_azimuth_degrees\n")
    )


def test_other_columns_orders_and_writers_are_welcome(tmp_path: Path) -> None:
    assert read_metadata(tmp_path) is None
    text = "\ufefflabel,azimuth_degrees,file_name\r\ncat,,./one.png\r\ndog,90,sub\\two.png\r\n"
    (tmp_path / METADATA_FILE).write_text(text, encoding="utf-8", newline="")
    assert read_metadata(tmp_path) == {
        "one.png": Row("one.png", "one.png", None, None),
        "sub/two.png": Row("sub/two.png", "sub/two.png", 90.0, None),
    }


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "expected a column file_name, found an empty file"),
        ("name,instance\na,b\n", "expected a column file_name, found name, instance"),
        (
            "file_name,azimuth_degrees\na.png,north\n",
            "line 2: azimuth_degrees: expected a number of degrees, found 'north'",
        ),
        ("file_name,azimuth_degrees\na.png,1\nb.png,nan\n", "line 3: azimuth_degrees"),
        ("file_name\na.png\na.png\n", "line 3: a.png has a row already"),
        ("file_name,instance\n,x\n", "line 2: expected a file name, found none"),
    ],
)
def test_wrong_content_is_named_by_line(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / METADATA_FILE).write_text(text)
    with pytest.raises(DataError, match=message):
        read_metadata(tmp_path)


def test_what_is_not_text_is_refused(tmp_path: Path) -> None:
    (tmp_path / METADATA_FILE).write_bytes(b"file_name\n\xff\xfe\x00.png\n")
    with pytest.raises(DataError, match="expected a CSV file in UTF-8"):
        read_metadata(tmp_path)
