"""A training says once that other programs want its cores, and not where they do not."""

import sys
import threading
from collections.abc import Iterator

import pytest
import torch

from trainer.training.contention import Contention, seconds_without_core


@pytest.fixture(autouse=True)
def threads() -> Iterator[None]:
    """Two of them, unless a test takes another number."""
    before = torch.get_num_threads()
    torch.set_num_threads(2)
    yield
    torch.set_num_threads(before)


def _told(waits: list[dict[str, float]], times: list[float]) -> list[str | None]:
    contention = Contention(iter(waits).__next__, iter(times).__next__)
    return [contention.told() for _ in times[1:]]


def test_what_waits_for_its_core_is_told_once() -> None:
    waits = [{"1": 5.0, "2": 0.0}, {"1": 5.1, "2": 1.0}, {"1": 5.2, "2": 17.0, "3": 0.5}]
    first, early, crowded, after = _told(waits, [0.0, 21.0, 40.0, 42.0, 80.0])
    assert first is None
    assert early is None
    assert crowded is not None
    assert "2 threads waited 76 % of the time" in crowded
    assert "--threads 1" in crowded
    assert after is None


def test_where_a_system_counts_no_waits_nothing_is_told() -> None:
    assert _told([{}, {}, {}], [0.0, 21.0, 42.0]) == [None, None]


def test_one_thread_has_no_fewer() -> None:
    torch.set_num_threads(1)
    assert _told([{"1": 0.0}, {"1": 20.0}], [0.0, 21.0]) == [None]


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux tells how long a thread has waited for a core")
def test_the_system_tells_of_every_thread() -> None:
    held, ready = threading.Event(), threading.Event()

    def wait() -> None:
        ready.set()
        held.wait()

    thread = threading.Thread(target=wait)
    thread.start()
    try:
        ready.wait()
        waits = seconds_without_core()
        assert str(thread.native_id) in waits
        assert all(seconds >= 0 for seconds in waits.values())
    finally:
        held.set()
        thread.join()
