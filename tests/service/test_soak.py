"""The benchmark of long loads, for seconds: it tells right answers from wrong ones, and finds only right ones."""

import math
from collections.abc import Iterator
from dataclasses import replace
from http.client import HTTPConnection
from pathlib import Path

import numpy as np
import pytest

from benchmarks.service_load import outcome_of
from benchmarks.service_memory import MemoryTrace, growth
from benchmarks.service_pictures import Question, make_questions
from benchmarks.service_process import Service, serving
from benchmarks.service_soak import flooded, mixed_questions, steady

SHIPPED = Path(__file__).parents[2] / "models"


@pytest.fixture(scope="module")
def service(bundle_directory: Path) -> Iterator[Service]:
    with serving(bundle_directory, 2) as service:
        yield service


@pytest.fixture(scope="module")
def questions(service: Service) -> list[Question]:
    return make_questions(service, "car", 8)


def test_many_clients_get_the_answers_to_their_own_pictures(service: Service, questions: list[Question]) -> None:
    found = steady(service, questions, clients=16, seconds=math.inf, requests=240)
    assert found["requests"] == 240
    assert found["outcomes"] == {"right": 240}
    assert "mebibytes_per_100000_requests" in found
    assert found["memory"]["most_mebibytes"] >= found["memory"]["first_mebibytes"] > 20


def test_what_cannot_be_served_is_refused_and_the_rest_served(service: Service, questions: list[Question]) -> None:
    found = flooded(service, questions, rate=800, seconds=0.5, clients=128)
    assert set(found["outcomes"]) == {"right", "429 with Retry-After"}
    assert sum(found["outcomes"].values()) == found["offered"] == 400
    assert found["served_p99_ms"] >= found["served_p50_ms"] > 0
    # Nothing of it is left behind.
    assert steady(service, questions, 2, math.inf, 8)["outcomes"] == {"right": 8}


def test_questions_of_several_categories_come_in_turns(tmp_path: Path) -> None:
    for category in ("car", "chair"):
        (tmp_path / category).symlink_to(SHIPPED / category)
    with serving(tmp_path, 1) as service:
        questions = mixed_questions(service, ("car", "chair"), 3)
    assert [b"car" in question.body[:200] for question in questions] == [True, False, True, False]


def test_a_wrong_answer_and_a_lost_one_are_told(service: Service, questions: list[Question]) -> None:
    connection = HTTPConnection(service.host, service.port, timeout=20)
    assert outcome_of(connection, questions[0]) == "right"
    assert outcome_of(connection, replace(questions[0], answer=questions[1].answer)) == "mixed up"
    assert outcome_of(connection, replace(questions[0], body=b"")) == "422"
    connection.close()
    nobody = HTTPConnection("127.0.0.1", 1, timeout=20)
    assert outcome_of(nobody, questions[0]) == "lost: ConnectionRefusedError"


def test_growth_is_the_slope_after_the_first_tenth() -> None:
    seconds = np.arange(0.0, 101.0)
    mebibytes = np.where(seconds <= 10, 7 * seconds, 200 + 0.02 * seconds)
    assert growth(MemoryTrace(seconds.tolist(), mebibytes.tolist()), 50_000) == pytest.approx(4.0)
    assert growth(MemoryTrace([0.0, 1.0], [1.0, 2.0]), 10) is None
    assert growth(MemoryTrace(), 10) is None
