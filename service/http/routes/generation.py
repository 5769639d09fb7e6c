"""`GET /sample`, `/decode` and `/interpolate`: answers that depend on nothing but the request."""

import math
from collections.abc import Awaitable
from http import HTTPStatus
from typing import Annotated

from fastapi import APIRouter, Depends, Header, Query, Request, Response
from fastapi.responses import JSONResponse

from service.answer import Answer
from service.generation import consecutive, decode_shape, interpolate, read_shape_code, sample, sample_together
from service.http.backend import Backend
from service.http.media import JSON, REPRESENTATIONS, form_of
from service.http.negotiation import negotiate
from service.http.parameters import only_known_parameters
from service.http.response import cacheable_answer, cacheable_gallery, cacheable_list, list_body
from service.http.schema import SAMPLE, SHAPE, problems

MOST_SAMPLES = 64
# Numbers. The head of a request has to hold them, each character as three.
LONGEST_SHAPE_CODE = 512

Seed = Annotated[int, Query(ge=0, lt=2**32, description="Which object; the same seed gives the same bytes.")]
Category = Annotated[
    str | None, Query(description="Of which kind; needed where several models are served.", examples=["car"])
]
Temperature = Annotated[
    float,
    Query(
        ge=0,
        le=2,
        allow_inf_nan=False,
        description="Times the standard deviations of the draw: less is more typical, and 0 has a few shapes only.",
    ),
]
Azimuth = Annotated[
    float,
    Query(
        ge=-360,
        le=360,
        allow_inf_nan=False,
        description="How far the object is turned before the camera, degrees: 0 shows its front, 90 its front on the "
        "right.",
    ),
]
Accept = Annotated[str | None, Header()]
IfNoneMatch = Annotated[str | None, Header(description="The ETag of the answer that is known already.")]

_PROBLEMS = problems(
    HTTPStatus.NOT_ACCEPTABLE,
    HTTPStatus.UNPROCESSABLE_ENTITY,
    HTTPStatus.TOO_MANY_REQUESTS,
    HTTPStatus.SERVICE_UNAVAILABLE,
)


def generation_routes(backend: Backend) -> APIRouter:
    """The routes that make shapes up."""
    router = APIRouter(dependencies=[Depends(only_known_parameters)])
    catalogue, metrics = backend.catalogue, backend.metrics

    async def respond(work: Awaitable[Answer], media_type: str, if_none_match: str | None) -> Response:
        answer = await work
        metrics.observe_stages(answer.timings_ms)
        return cacheable_answer(answer, media_type, if_none_match)

    @router.get("/sample", summary="New objects", response_class=JSONResponse, responses={**SAMPLE, **_PROBLEMS})
    async def get_sample(
        request: Request,
        seed: Seed = 0,
        category: Category = None,
        temperature: Temperature = 1.0,
        count: Annotated[
            int, Query(ge=1, le=MOST_SAMPLES, description="How many, of consecutive seeds, side by side in one file.")
        ] = 1,
        azimuth_degrees: Azimuth = 0.0,
        accept: Accept = None,
        if_none_match: IfNoneMatch = None,
    ) -> Response:
        """Draws shape codes from where pictures of the category have theirs, and decodes them."""
        media_type = negotiate(accept, REPRESENTATIONS)
        engine, azimuth, form = catalogue.engine(category), math.radians(azimuth_degrees), form_of(media_type)
        if count == 1:
            work = backend.work(request, sample, engine, seed, temperature, azimuth, form)
            return await respond(work, media_type, if_none_match)
        seeds = consecutive(seed, count)
        if media_type == JSON:
            body = await backend.work(
                request, lambda: list_body([sample(engine, one, temperature, azimuth) for one in seeds])
            )
            return cacheable_list(engine.manifest, body, if_none_match)
        gallery = await backend.work(request, sample_together, engine, seeds, temperature, azimuth, form)
        metrics.observe_stages(gallery.timings_ms)
        return cacheable_gallery(gallery, media_type, if_none_match)

    @router.get(
        "/decode", summary="The object of a shape code", response_class=JSONResponse, responses={**SHAPE, **_PROBLEMS}
    )
    async def get_decode(
        request: Request,
        z: Annotated[
            str,
            Query(
                max_length=16 * LONGEST_SHAPE_CODE,
                description="The shape code: as many numbers as /v1/categories says, between commas.",
                examples=["0.4,-1.2,0,0,0,0,0,0,0,0,0,0"],
            ),
        ],
        category: Category = None,
        azimuth_degrees: Azimuth = 0.0,
        accept: Accept = None,
        if_none_match: IfNoneMatch = None,
    ) -> Response:
        """Decodes a shape code."""
        media_type = negotiate(accept, REPRESENTATIONS)
        engine, azimuth = catalogue.engine(category), math.radians(azimuth_degrees)
        numbers = read_shape_code(z)
        work = backend.work(request, decode_shape, engine, numbers, azimuth, form_of(media_type))
        return await respond(work, media_type, if_none_match)

    @router.get(
        "/interpolate",
        summary="An object between two others",
        response_class=JSONResponse,
        responses={**SHAPE, **_PROBLEMS},
    )
    async def get_interpolate(
        request: Request,
        from_seed: Seed,
        to_seed: Seed,
        t: Annotated[
            float,
            Query(ge=0, le=1, allow_inf_nan=False, description="How far on the way: 0 is the first, 1 the second."),
        ] = 0.5,
        category: Category = None,
        temperature: Temperature = 1.0,
        azimuth_degrees: Azimuth = 0.0,
        accept: Accept = None,
        if_none_match: IfNoneMatch = None,
    ) -> Response:
        """Decodes a shape code on the straight way between those of two samples."""
        media_type = negotiate(accept, REPRESENTATIONS)
        engine, azimuth = catalogue.engine(category), math.radians(azimuth_degrees)
        form = form_of(media_type)
        work = backend.work(request, interpolate, engine, from_seed, to_seed, t, temperature, azimuth, form)
        return await respond(work, media_type, if_none_match)

    return router
