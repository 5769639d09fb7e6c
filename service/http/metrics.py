"""Figures of what the service does, in the text format of Prometheus."""

from collections.abc import Mapping
from time import perf_counter
from typing import Final

from prometheus_client import (
    CONTENT_TYPE_LATEST,
    CollectorRegistry,
    Counter,
    Gauge,
    Histogram,
    PlatformCollector,
    ProcessCollector,
    generate_latest,
)
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from service.catalogue import Catalogue

MEDIA_TYPE: Final = CONTENT_TYPE_LATEST
VERSION_PREFIX: Final = "/v1"
REFUSALS: Final = ("full", "late", "departed")

_SECONDS: Final = (0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1.0, 2.5, 10.0)
_METHODS: Final = frozenset(("GET", "HEAD", "POST"))


class Metrics:
    """The figures of one application."""

    def __init__(self, catalogue: Catalogue) -> None:
        self.registry = CollectorRegistry()
        ProcessCollector(registry=self.registry)
        PlatformCollector(registry=self.registry)
        self.requests = Counter(
            "chiaro_requests", "Requests that were answered.", ("method", "route", "status"), registry=self.registry
        )
        self.latency = Histogram(
            "chiaro_request_seconds",
            "From a request's head to the last byte of its answer.",
            ("route",),
            buckets=_SECONDS,
            registry=self.registry,
        )
        self.stages = Histogram(
            "chiaro_stage_seconds", "Work on an answer, by stage.", ("stage",), buckets=_SECONDS, registry=self.registry
        )
        self.in_progress = Gauge(
            "chiaro_requests_in_progress", "Requests that wait for their answer.", registry=self.registry
        )
        self.waiting = Gauge(
            "chiaro_requests_waiting", "Requests that wait for a thread to work on them.", registry=self.registry
        )
        self.refusals = Counter(
            "chiaro_refusals",
            "Requests that were not worked on: full queue, waited too long (late), client gone (departed).",
            ("reason",),
            registry=self.registry,
        )
        for reason in REFUSALS:
            self.refusals.labels(reason)
        loaded = Gauge("chiaro_models_loaded", "Models that are loaded and proven.", registry=self.registry)
        loaded.set_function(lambda: len(catalogue.engines))
        expected = Gauge("chiaro_models", "Models that were found.", registry=self.registry)
        expected.set(len(catalogue.names))

    def observe_stages(self, timings_ms: Mapping[str, float]) -> None:
        """Counts the stages of one answer."""
        for stage, value in timings_ms.items():
            self.stages.labels(stage).observe(value / 1000)

    def text(self) -> bytes:
        """The figures as they are now."""
        return generate_latest(self.registry)


class Measured:
    """ASGI middleware: counts requests and their times."""

    def __init__(self, app: ASGIApp, metrics: Metrics) -> None:
        self.app = app
        self.metrics = metrics

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        started = perf_counter()
        # What is raised beyond here is answered with 500 by the outermost layer.
        status = 500

        async def noted(message: Message) -> None:
            nonlocal status
            if message["type"] == "http.response.start":
                status = message["status"]
            await send(message)

        self.metrics.in_progress.inc()
        try:
            await self.app(scope, receive, noted)
        finally:
            self.metrics.in_progress.dec()
            route = _route(scope)
            method = scope["method"] if scope["method"] in _METHODS else "other"
            self.metrics.requests.labels(method, route, status).inc()
            self.metrics.latency.labels(route).observe(perf_counter() - started)


def _route(scope: Scope) -> str:
    """The path of the route that answered, without the version; one name for all that is no route."""
    path: str = getattr(scope.get("route"), "path", "other")
    return path.removeprefix(VERSION_PREFIX)
