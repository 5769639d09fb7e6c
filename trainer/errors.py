"""The trainer's exceptions, one per boundary. Each message says what was expected, what was found, and what to do.

ChiaroError
├── ConfigError       an option, a preset or a combination of options
├── DataError         a picture, a mesh, a folder, metadata.csv
├── CheckpointError   a run directory, a checkpoint, or a bundle under judgement
└── StorageError      a disk that is full or cannot be written
"""


class ChiaroError(Exception):
    """Anything a user can mend; the command line prints its message without a traceback and exits with 2."""


class ConfigError(ChiaroError):
    pass


class DataError(ChiaroError):
    pass


class CheckpointError(ChiaroError):
    pass


class StorageError(ChiaroError):
    pass
