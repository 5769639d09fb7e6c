"""How the tests ask the service, and what they expect of a problem."""

from typing import Any

import httpx


def problem(response: httpx.Response, status: int, kind: str) -> str:
    """The sentence of a problem, its form checked."""
    assert response.status_code == status, response.text
    assert response.headers["content-type"] == "application/problem+json"
    content: dict[str, Any] = response.json()
    assert set(content) == {"type", "title", "status", "detail"}
    assert content["status"] == status
    assert content["type"] == f"urn:chiaro:problem:{kind}"
    detail: str = content["detail"]
    return detail


def post(client: httpx.Client, content: bytes, headers: dict[str, str] | None = None, **data: str) -> httpx.Response:
    return client.post("/reconstruct", files={"image": ("picture", content)}, data=data, headers=headers)
