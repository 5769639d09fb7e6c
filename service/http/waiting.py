"""Work in threads, and the requests that wait for one: no more than may, no longer than they may, none for nobody."""

from asyncio import Semaphore, create_task
from collections.abc import Callable
from http import HTTPStatus
from typing import TypeVar

from anyio import CancelScope, CapacityLimiter, move_on_after, to_thread
from starlette.requests import ClientDisconnect
from starlette.types import Receive

from service.http.metrics import Metrics
from service.http.problem import RETRY_AFTER, HttpError

Result = TypeVar("Result")


class WaitingRoom:
    """Lets `threads` pieces of work run at the same time, and `places` more wait, first come, first served."""

    def __init__(self, threads: int, places: int, seconds: float, metrics: Metrics) -> None:
        self.places = places
        self.seconds = seconds
        """How long work may wait to begin; 0 is for ever."""
        self.waiting = 0
        self._free = Semaphore(threads)
        self._threads = CapacityLimiter(threads)
        self._refusals = metrics.refusals
        metrics.waiting.set_function(lambda: self.waiting)

    async def work(self, receive: Receive, function: Callable[[], Result]) -> Result:
        """What a function returns, called in a thread as soon as one is free. What has begun is finished.

        Raises:
            HttpError: 429 where all places are taken, 503 where the work did not begin in time.
            ClientDisconnect: the client went away before the work began.
        """
        if self._free.locked():
            await self._wait(receive)
        else:
            # At once, because a thread is free.
            await self._free.acquire()
        try:
            return await to_thread.run_sync(function, limiter=self._threads)
        finally:
            self._free.release()

    async def _wait(self, receive: Receive) -> None:
        if self.waiting >= self.places:
            self._refusals.labels("full").inc()
            raise HttpError(
                HTTPStatus.TOO_MANY_REQUESTS,
                "too-busy",
                f"expected at most {self.places} requests to wait, found that many already; try again in a second",
                RETRY_AFTER,
            )
        begun = False
        self.waiting += 1
        try:
            with CancelScope() as left, move_on_after(self.seconds or None):
                watcher = create_task(_watch(receive, left))
                try:
                    begun = await self._free.acquire()
                finally:
                    watcher.cancel()
        finally:
            self.waiting -= 1
        if begun:
            return
        if left.cancel_called:
            self._refusals.labels("departed").inc()
            raise ClientDisconnect
        self._refusals.labels("late").inc()
        raise HttpError(
            HTTPStatus.SERVICE_UNAVAILABLE,
            "too-late",
            f"expected the work to begin within {self.seconds:g} s, found others before it; try again in a second",
            RETRY_AFTER,
        )


async def _watch(receive: Receive, left: CancelScope) -> None:
    """Cancels the scope once the client is gone."""
    try:
        while (await receive())["type"] != "http.disconnect":
            # Of a body that nobody asked for.
            continue
    except HttpError:
        # That body is too large or too slow. It does not matter, and there is no more to be seen behind it.
        return
    left.cancel()
