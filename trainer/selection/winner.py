"""What is left of a selection to go on with: the chosen setting, and its training."""

from dataclasses import replace

from trainer.data.writing import write_bytes
from trainer.selection.candidates import Candidate
from trainer.selection.preset import as_toml
from trainer.selection.selection import Selection
from trainer.training.checkpoint import FILE_NAME, load_checkpoint, save_checkpoint

PRESET_FILE = "preset.toml"
WINNER_DIRECTORY = "winner"


def keep_winner(selection: Selection, chosen: Candidate) -> None:
    """Writes preset.toml, and a copy of the chosen training as a run directory of its own, whose goal is the recipe's
    last step. What is there already is left alone: somebody may have gone on with it.

    Raises CheckpointError where the training has been deleted, StorageError where nothing can be written.
    """
    config = selection.config(chosen)
    comment = f"{chosen.name}: chosen by `python -m trainer select`; selection.md beside this file says why."
    write_bytes(selection.root / PRESET_FILE, as_toml(config, comment).encode())
    source, target = selection.run_directory(chosen), selection.root / WINNER_DIRECTORY
    if (target / FILE_NAME).exists():
        return
    for name in ("config.json", "metrics.jsonl"):
        write_bytes(target / name, (source / name).read_bytes())
    # Last: a directory with a checkpoint is whole.
    save_checkpoint(target / FILE_NAME, replace(load_checkpoint(source), config=config))
