"""What `trainer evaluate` finds for a cell."""

import io
from contextlib import redirect_stdout

from trainer.commands.evaluate import EvaluateCommand
from trainer.tables.cells import Cell
from trainer.tables.study import Study


def judge_cell(study: Study, cell: Cell, test_views: int) -> None:
    """Writes the evaluation into the cell's directory; `test_views` pictures of an object are taken together."""
    command = EvaluateCommand(
        checkpoint=study.run_directory(cell),
        images=study.test_pictures(cell).path,
        validation=study.validation_pictures(cell).path,
        views_per_instance=test_views,
        output=study.evaluation(cell, test_views),
    )
    with redirect_stdout(io.StringIO()):
        command.run()
