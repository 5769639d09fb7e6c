"""Meshes in memory: as many as the budget allows, the same from every thread, and broken ones told once."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from trainer.data.mesh_store import MeshStore
from trainer.data.normals import corner_normals
from trainer.data.shapes.solid import Mesh, box
from trainer.errors import DataError

# Of a box: 10 vertices and 16 faces, with what is kept of each in 32 bits.
BYTES = 4 * (10 * 3 + 16 * 3 + 16 * 9)


class Shelf:
    """Boxes by the name of their width; counts how often each is fetched."""

    def __init__(self) -> None:
        self.fetched: list[str] = []

    def load(self, name: str) -> Mesh:
        self.fetched.append(name)
        if name == "broken":
            raise DataError("broken.obj cannot be read")
        return box((float(name), 1.0, 1.0))


def test_the_least_recently_used_is_fetched_again() -> None:
    shelf = Shelf()
    store = MeshStore(shelf.load, 2 * BYTES)
    for name in ("1", "2", "1", "2", "1", "3", "1", "2"):
        assert store.get(name) is not None
    assert shelf.fetched == ["1", "2", "3", "2"]


def test_what_is_larger_than_the_budget_can_be_drawn_all_the_same() -> None:
    shelf = Shelf()
    store = MeshStore(shelf.load, 1)
    for name in ("1", "1", "2", "1"):
        assert store.get(name) is not None
    assert shelf.fetched == ["1", "2", "1"]


def test_a_mesh_is_the_same_whether_it_was_kept_or_fetched() -> None:
    store = MeshStore(Shelf().load, 10 * BYTES)
    first, second = store.get("3"), store.get("3")
    assert first is not None
    assert second is not None
    np.testing.assert_array_equal(first.mesh.vertices, second.mesh.vertices)
    np.testing.assert_array_equal(first.normals, second.normals)
    mesh = box((3.0, 1.0, 1.0))
    np.testing.assert_allclose(first.mesh.vertices, mesh.vertices, atol=1e-6)
    np.testing.assert_array_equal(first.mesh.faces, mesh.faces)
    np.testing.assert_allclose(first.normals, corner_normals(mesh), atol=1e-6)
    assert (first.mesh.vertices.dtype, first.mesh.faces.dtype, first.normals.dtype) == (float, int, float)


def test_a_broken_mesh_is_told_once(caplog: pytest.LogCaptureFixture) -> None:
    shelf = Shelf()
    store = MeshStore(shelf.load, 2 * BYTES)
    assert [store.get("broken") for _ in range(3)] == [None] * 3
    assert shelf.fetched == ["broken"]
    assert caplog.messages == ["skipped: broken.obj cannot be read"]
    assert store.broken == {"broken": "broken.obj cannot be read"}


def test_threads_may_ask_at_once(caplog: pytest.LogCaptureFixture) -> None:
    store = MeshStore(Shelf().load, 3 * BYTES)
    names = [str(1 + number % 5) for number in range(400)] + ["broken"] * 20
    with ThreadPoolExecutor(8) as pool:
        found = list(pool.map(store.get, names))
    for name, ready in zip(names, found, strict=True):
        width = None if ready is None else np.ptp(ready.mesh.vertices[:, 0])
        assert width == (None if name == "broken" else pytest.approx(float(name)))
    assert len(caplog.messages) == 1
