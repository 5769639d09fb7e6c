"""A URL's parameters: those that its route knows, and no others."""

from difflib import get_close_matches
from http import HTTPStatus

from fastapi import Request
from fastapi.routing import APIRoute

from service.http.problem import HttpError


async def only_known_parameters(request: Request) -> None:
    """Refuses a URL with a parameter that its route would pass over, so that nobody believes in one that does nothing.

    Raises:
        HttpError: 422, with the parameters that there are.
    """
    route: APIRoute = request.scope["route"]
    known = [field.alias for field in route.dependant.query_params]
    unknown = next((name for name in request.query_params if name not in known), None)
    if unknown is not None:
        # A head may be long, and so may what it calls a parameter.
        name = unknown[:40]
        found = f"found “{name}” in the URL{_nearest(name, known)}; see /docs for what is expected"
        detail = f"expected {_expectation(known)}, {found}"
        raise HttpError(HTTPStatus.UNPROCESSABLE_ENTITY, "unknown-parameter", detail)


def _expectation(known: list[str]) -> str:
    if known:
        return f"no parameters but {', '.join(known)}"
    return "no parameters, as what is wanted is told in the form (curl -F category=car)"


def _nearest(unknown: str, known: list[str]) -> str:
    nearest = get_close_matches(unknown, known, n=1)
    return f" (did you mean {nearest[0]}?)" if nearest else ""
