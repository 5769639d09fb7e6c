"""What routes share: the models, the settings, the threads that work, and the figures that are kept of it."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import ParamSpec, TypeVar

from fastapi import Request

from service.catalogue import Catalogue
from service.http.metrics import Metrics
from service.http.waiting import WaitingRoom
from service.settings import Settings

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")


@dataclass(frozen=True)
class Backend:
    """One application's."""

    catalogue: Catalogue
    settings: Settings
    room: WaitingRoom
    metrics: Metrics

    async def work(
        self,
        request: Request,
        function: Callable[Arguments, Result],
        *arguments: Arguments.args,
        **named: Arguments.kwargs,
    ) -> Result:
        """What a function of the service returns, called in a thread as soon as one is free.

        Raises:
            HttpError: 429 where too many requests wait already, 503 where this one waited too long.
            ClientDisconnect: nobody waits for the answer any more.
        """
        return await self.room.work(request.receive, lambda: function(*arguments, **named))


def make_backend(catalogue: Catalogue, settings: Settings) -> Backend:
    """The backend of an application that begins."""
    metrics = Metrics(catalogue)
    room = WaitingRoom(settings.threads, settings.queue, settings.deadline, metrics)
    return Backend(catalogue, settings, room, metrics)
