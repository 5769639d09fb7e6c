"""The multipart form of `POST /reconstruct`, kept in memory: nothing that is uploaded touches a disk."""

from dataclasses import dataclass
from http import HTTPStatus

from fastapi import Request
from starlette.datastructures import UploadFile
from starlette.formparsers import MultiPartException, MultiPartParser

from service.http.problem import HttpError

_ADVICE = "send multipart/form-data with a file named image, as in: curl -F image=@car.png"


@dataclass(frozen=True)
class Upload:
    """An uploaded picture as it came, and the category that it is said to show."""

    image: bytes
    category: str | None


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
    parser = MultiPartParser(request.headers, request.stream(), max_files=1, max_fields=1, max_part_size=1024)
    # Parts spill over to a file from this size on: with the body's own limit, never.
    parser.spool_max_size = limit + 1
    try:
        form = await parser.parse()
    except MultiPartException as error:
        raise _invalid(f"expected one file named image and at most one category, found: {error.message}") from None
    except UnicodeError as error:
        raise _invalid(f"expected field names and a category in UTF-8, found: {error}") from None
    try:
        unknown = sorted(set(form) - {"image", "category"})
        if unknown:
            raise _invalid(f"expected the fields image and category, found {', '.join(unknown)[:80]}")
        image, category = form.get("image"), form.get("category")
        if not isinstance(image, UploadFile):
            found = "a field without a file name" if image is not None else "none"
            raise _invalid(f"expected a file named image, found {found}")
        if isinstance(category, UploadFile):
            raise _invalid("expected category to be text, found a file")
        return Upload(await image.read(), category or None)
    finally:
        await form.close()


def _invalid(sentence: str) -> HttpError:
    return HttpError(HTTPStatus.UNPROCESSABLE_ENTITY, "invalid-form", f"{sentence}; {_ADVICE}")
