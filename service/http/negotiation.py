"""Which representation a client wants (RFC 9110, section 12.5.1)."""

from collections.abc import Sequence
from http import HTTPStatus

from service.http.problem import HttpError


def negotiate(accept: str | None, offered: Sequence[str]) -> str:
    """The offered media type that the Accept header likes best; among equals, the first offered.

    Raises:
        HttpError: 406, the header rules out all that is offered.
    """
    ranges = [_media_range(part) for part in (accept or "").split(",") if part.strip()] or [("*/*", 1.0)]
    best = max(offered, key=lambda media_type: _quality(media_type, ranges))
    if _quality(best, ranges) == 0:
        raise HttpError(
            HTTPStatus.NOT_ACCEPTABLE,
            "not-acceptable",
            f"expected Accept to allow {' or '.join(offered)}, found “{(accept or '')[:100]}”; ask for one of those",
        )
    return best


def _media_range(text: str) -> tuple[str, float]:
    name, *parameters = (part.strip().lower() for part in text.split(";"))
    quality = 1.0
    for parameter in parameters:
        key, _, value = parameter.partition("=")
        if key.strip() == "q":
            try:
                quality = min(1.0, max(0.0, float(value)))
            except ValueError:
                quality = 0.0
    return name, quality


def _quality(media_type: str, ranges: Sequence[tuple[str, float]]) -> float:
    """The quality that the most specific matching range gives."""
    for candidate in (media_type, media_type.partition("/")[0] + "/*", "*/*"):
        found = [quality for name, quality in ranges if name == candidate]
        if found:
            return max(found)
    return 0.0
