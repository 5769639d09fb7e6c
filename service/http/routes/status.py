"""What the service is and how it fares: `/categories`, `/healthz`, `/readyz`, `/metrics`"""

from http import HTTPStatus

from fastapi import APIRouter, Response

from service.errors import NotReadyError
from service.http.backend import Backend
from service.http.metrics import MEDIA_TYPE
from service.http.schema import METRICS, Status, problems
from service.models import Models, report_model


def status_routes(backend: Backend) -> APIRouter:
    """The routes for operators and their machines."""
    router = APIRouter()
    catalogue, metrics = backend.catalogue, backend.metrics
    unavailable = problems(HTTPStatus.SERVICE_UNAVAILABLE)

    @router.get("/categories", summary="The models", responses=unavailable)
    async def get_categories() -> Models:
        """What each model is: its conventions, camera, lights, shape code and figures."""
        return Models(tuple(report_model(engine) for engine in catalogue.all_engines()))

    @router.get("/healthz", summary="Does the service live?")
    async def get_health() -> Status:
        """Answers as long as the process does."""
        return Status("alive", tuple(sorted(catalogue.engines)))

    @router.get("/readyz", summary="Is the service ready?", responses=unavailable)
    async def get_readiness() -> Status:
        """Answers 200 once every bundle gave the numbers that it gave where it was exported."""
        if not catalogue.ready:
            first = next(iter(catalogue.failures.values()), None)
            raise NotReadyError(first or "the models are being loaded; try again in a second")
        return Status("ready", tuple(sorted(catalogue.engines)))

    @router.get("/metrics", summary="Figures for Prometheus", response_class=Response, responses=METRICS)
    async def get_metrics() -> Response:
        """Requests, times, stages and models, in the text format of Prometheus."""
        return Response(metrics.text(), headers={"Content-Type": MEDIA_TYPE, "Cache-Control": "no-store"})

    return router
