"""The exporter's exception; the command line prints its message without a traceback and exits with 2."""

from trainer.errors import ChiaroError


class ExportError(ChiaroError):
    """A model that cannot become a bundle."""
