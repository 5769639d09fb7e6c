"""More pictures than the service can answer: they come at a fixed rate, whether or not earlier ones are answered."""

import itertools
import threading
import time
from collections import Counter
from collections.abc import Sequence
from http.client import HTTPConnection
from typing import Any

import numpy as np

from benchmarks.service_load import outcome_of
from benchmarks.service_pictures import Question
from benchmarks.service_process import Service


def measure_flood(
    service: Service, questions: Sequence[Question], per_second: float, seconds: float, clients: int
) -> dict[str, Any]:
    """What becomes of `per_second` pictures offered each second by as many clients, each of which keeps a connection.

    Latencies are from the moment at which a picture was due. Where all clients wait for answers, pictures are offered
    late; how late tells whether the rate was kept.
    """
    count = int(per_second * seconds)
    turns = itertools.count()
    outcomes: list[Counter[str]] = [Counter() for _ in range(clients)]
    served: list[list[float]] = [[] for _ in range(clients)]
    refused: list[list[float]] = [[] for _ in range(clients)]
    late: list[float] = [0.0] * clients
    start = threading.Barrier(clients + 1)
    begin = 0.0

    def run(number: int) -> None:
        connection = HTTPConnection(service.host, service.port, timeout=60)
        start.wait()
        while (turn := next(turns)) < count:
            due = begin + turn / per_second
            time.sleep(max(0.0, due - time.perf_counter()))
            late[number] = max(late[number], time.perf_counter() - due)
            outcome = outcome_of(connection, questions[turn % len(questions)])
            outcomes[number][outcome] += 1
            times = {"right": served, "429 with Retry-After": refused}.get(outcome)
            if times is not None:
                times[number].append(time.perf_counter() - due)
        connection.close()

    workers = [threading.Thread(target=run, args=(number,)) for number in range(clients)]
    for worker in workers:
        worker.start()
    begin = time.perf_counter() + 0.05
    start.wait()
    for worker in workers:
        worker.join()
    took = time.perf_counter() - begin
    answered = sum(len(times) for times in served)
    return {
        "offered": count,
        "offered_per_second": round(per_second, 2),
        "outcomes": dict(sum(outcomes, Counter())),
        "served_per_second": round(answered / took, 2),
        "served_p50_ms": _quantile(served, 0.5),
        "served_p99_ms": _quantile(served, 0.99),
        "refused_p99_ms": _quantile(refused, 0.99),
        "most_late_ms": round(1000 * max(late), 1),
    }


def _quantile(times: Sequence[Sequence[float]], share: float) -> float | None:
    """Milliseconds; None where there are no times."""
    found = np.concatenate([np.array(one) for one in times])
    return round(1000 * float(np.quantile(found, share)), 1) if found.size else None
