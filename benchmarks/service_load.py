"""How fast pictures are answered: by the service to several clients, and by the two ONNX graphs alone."""

import itertools
import threading
import time
from collections import Counter
from collections.abc import Callable, Sequence
from http.client import HTTPConnection, HTTPException
from typing import Any

import numpy as np

from benchmarks.service_pictures import HEADERS, Question
from benchmarks.service_process import Service
from service.image import read_picture
from service.inference import Array, Engine, decode, encode

Step = Callable[[int], str]


def measure_service(
    service: Service, questions: Sequence[Question], clients: int, seconds: float, requests: int | None = None
) -> dict[str, Any]:
    """Latencies and throughput at as many clients, each on a connection that it keeps, each asking as soon as it is
    answered, until the time is over or as many requests are made. Every answer is compared with what its picture was
    answered alone."""
    connections = [HTTPConnection(service.host, service.port, timeout=60) for _ in range(clients)]

    def step(connection: HTTPConnection) -> Step:
        return lambda turn: outcome_of(connection, questions[turn % len(questions)])

    try:
        return _measure([step(connection) for connection in connections], seconds, requests)
    finally:
        for connection in connections:
            connection.close()


def outcome_of(connection: HTTPConnection, question: Question) -> str:
    """What becomes of a question: "right" where the answer is that which its picture got alone."""
    try:
        connection.request("POST", "/v1/reconstruct", question.body, HEADERS)
        response = connection.getresponse()
        content = response.read()
    except (OSError, HTTPException) as error:
        connection.close()
        return f"lost: {type(error).__name__}"
    if response.status == 200:
        return "right" if content == question.answer else "mixed up"
    return f"{response.status} with Retry-After" if response.getheader("Retry-After") else str(response.status)


def measure_graphs(engine: Engine, pictures: Sequence[Array], threads: int, seconds: float) -> dict[str, Any]:
    """The same of the graphs alone: encoder and decoder in as many threads, on pictures that are prepared already."""

    def step(turn: int) -> str:
        decode(engine, encode(engine, pictures[turn % len(pictures)]).shape_mean)
        return "right"

    return _measure([step] * threads, seconds)


def prepared(engine: Engine, questions: Sequence[Question]) -> list[Array]:
    """What the encoder sees of each picture [3, H, W]."""
    picture, camera = engine.manifest.picture, engine.manifest.camera
    return [
        read_picture(
            question.jpeg,
            picture.width,
            picture.height,
            25_000_000,
            camera.distance,
            camera.field_of_view_degrees,
            zoom=picture.zoom,
        ).picture
        for question in questions
    ]


def _measure(steps: Sequence[Step], seconds: float, count: int | None = None) -> dict[str, Any]:
    """Each step over and over in a thread of its own; what began before the end counts; `count` steps in all at
    most."""
    most = float("inf") if count is None else count
    begun = itertools.count()
    latencies: list[list[float]] = [[] for _ in steps]
    outcomes: list[Counter[str]] = [Counter() for _ in steps]
    start = threading.Barrier(len(steps) + 1)
    end = 0.0

    def run(number: int) -> None:
        start.wait()
        # Begun at different pictures, so that no two clients go through them side by side.
        turn = 7 * number
        while (began := time.perf_counter()) < end and next(begun) < most:
            outcomes[number][steps[number](turn)] += 1
            latencies[number].append(time.perf_counter() - began)
            turn += 1

    workers = [threading.Thread(target=run, args=(number,)) for number in range(len(steps))]
    for worker in workers:
        worker.start()
    began = time.perf_counter()
    end = began + seconds
    start.wait()
    for worker in workers:
        worker.join()
    took = time.perf_counter() - began
    found = np.concatenate([np.array(one) for one in latencies]) * 1000
    if not found.size:
        raise RuntimeError("expected at least one answer, found none; measure longer with --seconds")
    return {
        "requests": int(found.size),
        "outcomes": dict(sum(outcomes, Counter())),
        "p50_ms": round(float(np.quantile(found, 0.5)), 3),
        "p99_ms": round(float(np.quantile(found, 0.99)), 3),
        "per_second": round(found.size / took, 2),
    }
