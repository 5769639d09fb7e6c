"""The tables of docs/parsimony.md, from docs/results/parsimony.json."""

from pathlib import Path
from typing import Any, Final

PAGE: Final = Path("docs/parsimony.md")
_BEGIN, _END = "<!-- {name} -->\n", "<!-- end of {name} -->"


def write_tables(report: dict[str, Any], page: Path) -> None:
    """Puts the tables of a report where the page has them."""
    text = page.read_text(encoding="utf-8")
    for name, lines in (("carries", carries_table(report)), ("precision", precision_table(report))):
        before, begin, rest = text.partition(_BEGIN.format(name=name))
        _, end, after = rest.partition(_END.format(name=name))
        text = before + begin + "\n".join(lines) + "\n" + end + after
    page.write_text(text, encoding="utf-8")


def carries_table(report: dict[str, Any]) -> list[str]:
    """What of each bundle is in use."""
    lines = [
        "| | numbers of the shape code | of which none could go unnoticed | pictures say little of | the least of them "
        "moves vertices by | blocks | ever in use | used in a picture |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for name, model in report["models"].items():
        one = model["carries"]
        blocks = [one["blocks"], one["blocks_that_show"], one["blocks_used_in_a_picture"]] if one["blocks"] > 1 else []
        cells = [
            name,
            one["numbers"],
            one["numbers_that_move"],
            one["numbers_pictures_say_little_of"],
            f"{one['least_activity']:.3f}",
            *(blocks or ["–"] * 3),
        ]
        lines.append(f"| {' | '.join(map(str, cells))} |")
    return lines


def precision_table(report: dict[str, Any]) -> list[str]:
    """Bytes, milliseconds and accuracy of each bundle in float32 / float16 / int8; a dash for what none was made of."""
    lines = [
        "| | kB | encoder, ms | decoder, ms | IoU | azimuth error | same bin as float32 |",
        "|---|---|---|---|---|---|---|",
    ]
    for name, model in report["models"].items():
        every = [model["precisions"].get(precision) for precision in ("float32", "float16", "int8")]
        columns = [
            [
                f"{one['bytes'] / 1000:.0f}",
                f"{one['encoder_ms']:.2f}",
                f"{one['decoder_ms']:.2f}",
                f"{one['iou']:.3f}",
                f"{one['azimuth_error_degrees']:.1f}°",
            ]
            if one
            else ["–"] * 5
            for one in every
        ]
        same = " / ".join(f"{one['same_bin']:.2f}" for one in every if one and "same_bin" in one)
        cells = [" / ".join(values) for values in zip(*columns, strict=True)]
        lines.append(f"| {' | '.join([name, *cells, same])} |")
    return lines
