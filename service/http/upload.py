"""The multipart form of `POST /reconstruct`, kept in memory: nothing that is uploaded touches a disk."""

from dataclasses import dataclass
from http import HTTPStatus
from typing import Final

from fastapi import Request
from starlette.datastructures import FormData, UploadFile
from starlette.formparsers import MultiPartException, MultiPartParser

from service.exposure import Blocks
from service.http.problem import HttpError

AUTOMATIC: Final = "auto"
"""The category of a picture of which the service shall tell the category."""
MOST_PICTURES: Final = 16
MOST_HYPOTHESES: Final = 360
MOST_ITERATIONS: Final = 50

FIELDS: Final = ("image", "category", "hypotheses", "refine", "blocks")
_ADVICE: Final = "send multipart/form-data with a file named image, as in: curl -F image=@car.png"


@dataclass(frozen=True)
class Upload:
    """Uploaded pictures as they came, the category that they are said to show, and what is wanted."""

    images: tuple[bytes, ...]
    category: str | None
    hypotheses: int
    """How many turns to tell."""
    refine: int
    """Iterations of refinement."""
    blocks: Blocks
    """Which blocks of the object a GLB shall hold."""


async def read_upload(request: Request, limit: int) -> Upload:
    """The form in a request's body.

    Raises:
        HttpError: 415 for another kind of body, 422 for a form that is broken or lacks its picture.
    """
    kind = request.headers.get("content-type", "")
    if kind.partition(";")[0].strip().lower() != "multipart/form-data":
        found = f"{kind[:80]}" if kind else "no Content-Type"
        raise HttpError(
            HTTPStatus.UNSUPPORTED_MEDIA_TYPE,
            "unsupported-media-type",
            f"expected multipart/form-data, found {found}; {_ADVICE}",
        )
    parser = MultiPartParser(
        request.headers, request.stream(), max_files=MOST_PICTURES, max_fields=len(FIELDS) - 1, max_part_size=1024
    )
    # Parts spill over to a file from this size on: with the body's own limit, never.
    parser.spool_max_size = limit + 1
    try:
        form = await parser.parse()
    except MultiPartException as error:
        raise _invalid(
            f"expected 1 to {MOST_PICTURES} files named image and at most one category, found: {error.message}"
        ) from None
    except UnicodeError as error:
        raise _invalid(f"expected field names and a category in UTF-8, found: {error}") from None
    try:
        unknown = sorted(set(form) - set(FIELDS))
        if unknown:
            raise _invalid(f"expected no fields but {', '.join(FIELDS)}, found {', '.join(unknown)[:80]}")
        images = [await file.read() for file in _files(form)]
        hypotheses = _number(_text(form, "hypotheses"), "hypotheses", 1, MOST_HYPOTHESES, 3)
        refine = _number(_text(form, "refine"), "refine", 0, MOST_ITERATIONS, 0)
        blocks = _blocks(_text(form, "blocks"))
        return Upload(tuple(images), _text(form, "category") or None, hypotheses, refine, blocks)
    finally:
        await form.close()


def _files(form: FormData) -> list[UploadFile]:
    parts = form.getlist("image")
    files = [part for part in parts if isinstance(part, UploadFile)]
    if not parts or len(files) < len(parts):
        found = "a field without a file name" if parts else "none"
        raise _invalid(f"expected a file named image, found {found}")
    return files


def _text(form: FormData, name: str) -> str:
    """A field's text, empty where there is none."""
    parts = form.getlist(name)
    if len(parts) > 1:
        raise _invalid(f"expected one {name} at most, found {len(parts)}")
    text = parts[0] if parts else ""
    if not isinstance(text, str):
        raise _invalid(f"expected {name} to be text, found a file")
    return text


def _number(text: str, name: str, lowest: int, highest: int, absent: int) -> int:
    if not text:
        return absent
    known = text.isascii() and text.isdigit() and len(text) <= len(str(highest))
    if not (known and lowest <= int(text) <= highest):
        raise _invalid(f"expected {name} from {lowest} to {highest}, found “{text[:40]}”")
    return int(text)


def _blocks(text: str) -> Blocks:
    match text:
        case "" | "all":
            return "all"
        case "used":
            return "used"
        case _:
            raise _invalid(f"expected blocks to be all or used, found “{text[:40]}”")


def _invalid(sentence: str) -> HttpError:
    return HttpError(HTTPStatus.UNPROCESSABLE_ENTITY, "invalid-form", f"{sentence}; {_ADVICE}")
