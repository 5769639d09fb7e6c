"""`POST /reconstruct`"""

from http import HTTPStatus
from typing import Annotated

from fastapi import APIRouter, Depends, Header, Request, Response
from fastapi.responses import JSONResponse

from service.http.backend import Backend
from service.http.media import REPRESENTATIONS, form_of
from service.http.negotiation import negotiate
from service.http.parameters import only_known_parameters
from service.http.response import answer_response
from service.http.schema import RECONSTRUCT, UPLOAD, problems
from service.http.upload import AUTOMATIC, read_upload
from service.reconstruction import reconstruct
from service.refinement import Effort


def reconstruction_routes(backend: Backend) -> APIRouter:
    """The route that takes pictures."""
    router = APIRouter(dependencies=[Depends(only_known_parameters)])
    catalogue, settings = backend.catalogue, backend.settings

    @router.post(
        "/reconstruct",
        summary="The object in pictures",
        response_class=JSONResponse,
        responses={
            **RECONSTRUCT,
            **problems(
                HTTPStatus.NOT_ACCEPTABLE,
                HTTPStatus.REQUEST_TIMEOUT,
                HTTPStatus.REQUEST_ENTITY_TOO_LARGE,
                HTTPStatus.UNSUPPORTED_MEDIA_TYPE,
                HTTPStatus.UNPROCESSABLE_ENTITY,
                HTTPStatus.TOO_MANY_REQUESTS,
                HTTPStatus.SERVICE_UNAVAILABLE,
            ),
        },
        openapi_extra=UPLOAD,
    )
    async def post_reconstruct(request: Request, accept: Annotated[str | None, Header()] = None) -> Response:
        """Reads each picture upright, sets it on black, fits it into the model's frame, reconstructs what they show.
        Several pictures show one object; the camera and the lights of the answer are those of the first. Where no
        category is named, the model that explains the pictures best answers."""
        media_type = negotiate(accept, REPRESENTATIONS)
        upload = await read_upload(request, settings.max_upload_bytes)
        automatic = upload.category in (None, AUTOMATIC)
        engines = catalogue.all_engines() if automatic else [catalogue.engine(upload.category)]
        form, effort = form_of(media_type), Effort(upload.refine, settings.refine_seconds)
        wanted = form, upload.hypotheses, effort, upload.blocks
        answer = await backend.work(request, reconstruct, engines, upload.images, settings.max_pixels, *wanted)
        backend.metrics.observe_stages(answer.timings_ms)
        return answer_response(answer, media_type)

    return router
