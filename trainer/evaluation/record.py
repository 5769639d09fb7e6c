"""A judgement on the disk: figures, a page, and contact sheets."""

import json
from pathlib import Path
from typing import Any

from trainer.data.writing import write_bytes
from trainer.evaluation.contact import write_sheets
from trainer.evaluation.pictures import Pictures, Validation
from trainer.evaluation.protocol import Judgement, judge
from trainer.evaluation.report import as_json, as_markdown
from trainer.evaluation.subject import Subject


def judge_and_record(
    subject: Subject, pictures: Pictures, validation: Validation | None, output: Path
) -> tuple[Judgement, dict[str, Any]]:
    """Judges a model, writes metrics.json, report.md and contact sheets to `output`, and returns what metrics.json
    holds beside the judgement.

    Raises StorageError where a file cannot be written.
    """
    judgement = judge(subject, pictures, validation)
    figures = as_json(judgement.report) | {"category": subject.category} | subject.training
    write_bytes(output / "metrics.json", (json.dumps(figures, indent=2, allow_nan=False) + "\n").encode())
    report = as_markdown(judgement.report, subject.category, pictures.skipped)
    write_bytes(output / "report.md", report.encode())
    write_sheets(output, subject, pictures, judgement)
    return judgement, figures
