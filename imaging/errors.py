"""Why a picture cannot be used. Messages say what was expected and what was found; who catches them knows what to do.

PictureError
├── FormatError       not one of the formats that are read
├── PixelLimitError   more pixels than are allowed
├── DamageError       empty, damaged or cut off
└── BackgroundError   the object cannot be told from what is around it
"""


class PictureError(Exception):
    """A picture that cannot be used."""


class FormatError(PictureError):
    pass


class PixelLimitError(PictureError):
    pass


class DamageError(PictureError):
    pass


class BackgroundError(PictureError):
    pass
