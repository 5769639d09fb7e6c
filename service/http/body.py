"""Limits on the size of request bodies, of one and of all together, and on their time, kept while they stream in."""

from asyncio import get_running_loop, timeout, timeout_at
from http import HTTPStatus
from typing import Final

from starlette.types import ASGIApp, Message, Receive, Scope, Send

from service.http.problem import RETRY_AFTER, HttpError

# A client that is still sending does not read the answer, and a closed connection would destroy it on its way. So what
# comes beyond the limit is thrown away for a while, and the answer follows.
_DISCARDED_BYTES: Final = 64 * 2**20
_DISCARDING_SECONDS: Final = 5.0


class BodyLimit:
    """ASGI middleware: whoever reads a body of more than `limit` bytes gets an HttpError 413 instead of the excess, 408
    where the body is not whole after `seconds`, and 429 where all requests' bodies together pass `total` bytes.

    A declared length is refused before anything is kept, an undeclared one (chunked) as soon as it passes the limit.
    """

    def __init__(self, app: ASGIApp, limit: int, seconds: float, total: int) -> None:
        self.app = app
        self.limit = limit
        self.seconds = seconds
        self.total = total
        self.held = 0
        """Bytes of the bodies of all requests that are not answered yet."""

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        headers = dict(scope["headers"])
        length = headers.get(b"content-length", b"")
        declared = int(length) if length.isdigit() else None
        asks_first = headers.get(b"expect", b"").lower() == b"100-continue"
        has_body = bool(declared) or b"transfer-encoding" in headers
        received = 0
        deadline: float | None = get_running_loop().time() + self.seconds

        async def limited() -> Message:
            nonlocal received, deadline
            if declared is not None and declared > self.limit:
                # Who asks first (Expect: 100-continue) has not begun to send.
                if not asks_first:
                    await _discard(receive)
                raise self._refusal(f"{declared}")
            try:
                async with timeout_at(deadline):
                    message = await receive()
            except TimeoutError:
                raise self._too_slow(received) from None
            size = len(message.get("body", b""))
            received += size
            self.held += size
            if received > self.limit or self.held > self.total:
                refusal = self._refusal("more") if received > self.limit else self._too_many()
                if message.get("more_body", False):
                    await _discard(receive)
                raise refusal
            if not message.get("more_body", False):
                # What follows a whole body is the client's departure, for which one may wait.
                deadline = None
            return message

        async def closing(message: Message) -> None:
            # Else whoever goes on sending after the answer would keep the connection for ever.
            if message["type"] == "http.response.start" and has_body and deadline is not None:
                kept = [header for header in message["headers"] if header[0].lower() != b"connection"]
                message = {**message, "headers": [*kept, (b"connection", b"close")]}
            await send(message)

        try:
            await self.app(scope, limited, closing)
        finally:
            self.held -= received

    def _refusal(self, found: str) -> HttpError:
        return HttpError(
            HTTPStatus.REQUEST_ENTITY_TOO_LARGE,
            "upload-too-large",
            f"expected a body of at most {self.limit} bytes, found {found}; send a smaller picture",
        )

    def _too_many(self) -> HttpError:
        return HttpError(
            HTTPStatus.TOO_MANY_REQUESTS,
            "too-busy",
            f"expected at most {self.total} bytes in the bodies of all requests, found more; try again in a second",
            RETRY_AFTER,
        )

    def _too_slow(self, received: int) -> HttpError:
        return HttpError(
            HTTPStatus.REQUEST_TIMEOUT,
            "slow-upload",
            f"expected a whole body within {self.seconds:g} s, found {received} bytes by then; "
            "send it faster, or a smaller picture",
        )


async def _discard(receive: Receive) -> None:
    discarded = 0
    try:
        async with timeout(_DISCARDING_SECONDS):
            more = True
            while more and discarded < _DISCARDED_BYTES:
                message = await receive()
                discarded += len(message.get("body", b""))
                more = message["type"] == "http.request" and message.get("more_body", False)
    except TimeoutError:
        return
