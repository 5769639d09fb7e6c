"""Meshes in memory, ready to be drawn: as many as a budget allows, the least recently used forgotten first."""

import logging
from collections import OrderedDict
from collections.abc import Callable
from threading import Lock
from typing import NamedTuple

import numpy as np
from jaxtyping import Float32, Float64, Int32
from numpy import ndarray

from trainer.data.normals import corner_normals
from trainer.data.shapes.solid import Mesh
from trainer.errors import DataError

logger = logging.getLogger(__name__)


class Ready(NamedTuple):
    """What `data.picture.draw` takes."""

    mesh: Mesh
    normals: Float64[ndarray, "F 3 3"]


class _Stored(NamedTuple):
    """A mesh in half the memory: a unit diagonal needs no more than 24 bits."""

    vertices: Float32[ndarray, "V 3"]
    faces: Int32[ndarray, "F 3"]
    normals: Float32[ndarray, "F 3 3"]

    @property
    def bytes(self) -> int:
        return self.vertices.nbytes + self.faces.nbytes + self.normals.nbytes


class MeshStore:
    """Meshes with their corner normals by name, loaded when they are first asked for, by any thread."""

    def __init__(self, load: Callable[[str], Mesh], most_bytes: int) -> None:
        self._load = load
        self._most_bytes = most_bytes
        self._lock = Lock()
        self._stored: OrderedDict[str, _Stored] = OrderedDict()
        self._bytes = 0
        self.broken: dict[str, str] = {}
        """A sentence for each mesh that could not be loaded; a warning has named it."""

    def get(self, name: str) -> Ready | None:
        """A mesh and its normals, the same on every call, or None where it cannot be loaded."""
        with self._lock:
            if name in self.broken:
                return None
            stored = self._stored.get(name)
            if stored is not None:
                self._stored.move_to_end(name)
        # Outside of the lock: others need not wait for a file.
        if stored is None:
            try:
                mesh = self._load(name)
            except DataError as error:
                self._note(name, str(error))
                return None
            stored = _Stored(
                mesh.vertices.astype(np.float32), mesh.faces.astype(np.int32), corner_normals(mesh).astype(np.float32)
            )
            self._keep(name, stored)
        mesh = Mesh(stored.vertices.astype(np.float64), stored.faces.astype(np.int64))
        return Ready(mesh, stored.normals.astype(np.float64))

    def _note(self, name: str, problem: str) -> None:
        with self._lock:
            known = name in self.broken
            self.broken[name] = problem
        if not known:
            logger.warning("skipped: %s", problem)

    def _keep(self, name: str, stored: _Stored) -> None:
        with self._lock:
            if name not in self._stored:
                self._stored[name] = stored
                self._bytes += stored.bytes
            # The newest stays even where it is larger than the budget: it is being drawn.
            while self._bytes > self._most_bytes and len(self._stored) > 1:
                self._bytes -= self._stored.popitem(last=False)[1].bytes
