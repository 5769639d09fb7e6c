"""What of each block shows, for boxes whose hidden areas are known; and a GLB without the blocks that do not."""

import json
import struct
from dataclasses import replace

import numpy as np
import pytest
import trimesh

from service.exposure import LEAST_AREA, POINTS, shown_area, surfaces_of, used_blocks, used_part
from service.glb import write_glb
from service.inference import Engine, Surface
from service.manifest import Block
from service.reconstruction import reconstruct

Box = tuple[tuple[float, float, float], tuple[float, float, float]]


def boxes(*placed: Box) -> tuple[np.ndarray, np.ndarray, tuple[Block, ...]]:
    """Boxes by centre and sides: vertices, faces, blocks."""
    vertices, faces, blocks = [], [], []
    for number, (centre, sides) in enumerate(placed):
        box = trimesh.creation.box(sides)
        blocks.append(Block(f"block-{number + 1}", 12 * number, 12))
        faces.append(box.faces + 8 * number)
        vertices.append(box.vertices + centre)
    return np.concatenate(vertices), np.concatenate(faces), tuple(blocks)


CUBE: Box = ((0.0, 0.0, 0.0), (0.5, 0.5, 0.5))


def test_a_box_by_itself_shows_all_of_its_surface() -> None:
    surfaces = surfaces_of(*boxes(CUBE, ((2.0, 0.0, 0.0), (0.1, 0.2, 0.3))))
    assert shown_area(surfaces, 0, [0, 1]) == pytest.approx(6 * 0.25)
    assert shown_area(surfaces, 1, [0, 1]) == pytest.approx(2 * (0.02 + 0.03 + 0.06))


@pytest.mark.parametrize("out", [0.1, 0.25, 0.4])
def test_what_stands_out_of_another_shows(out: float) -> None:
    """A bar of 0.1 × 0.1 that looks out of a cube: four sides as far as they are outside, and an end."""
    surfaces = surfaces_of(*boxes(CUBE, ((0.25 + out - 0.25, 0.0, 0.0), (0.5, 0.1, 0.1))))
    whole = 4 * 0.05 + 2 * 0.01
    assert shown_area(surfaces, 1, [0, 1]) == pytest.approx(4 * 0.1 * out + 0.01, abs=6 * whole / POINTS)
    assert shown_area(surfaces, 1, [1]) == pytest.approx(whole)


def test_a_turned_block_hides_what_is_in_it() -> None:
    vertices, faces, blocks = boxes(CUBE, ((0.0, 0.0, 0.0), (0.2, 0.2, 0.2)), ((0.0, 0.33, 0.0), (0.04, 0.04, 0.04)))
    angle = np.pi / 4
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    turned = vertices.copy()
    turned[:8] = vertices[:8] @ turn.T
    # The corner of the turned cube reaches up to 0.354.
    assert used_blocks(vertices, faces, blocks) == (0, 2)
    assert shown_area(surfaces_of(turned, faces, blocks), 2, [0, 2]) < 6 * 0.04**2
    assert used_blocks(turned, faces, blocks)[0] == 0


@pytest.mark.parametrize(
    ("placed", "used"),
    [
        ([CUBE], (0,)),
        ([CUBE, ((0.0, 0.0, 0.0), (0.4, 0.4, 0.4))], (0,)),
        ([((0.0, 0.0, 0.0), (0.4, 0.4, 0.4)), CUBE], (1,)),
        # Of two in one place, the first stays.
        ([CUBE, CUBE], (0,)),
        # Hidden by two others together, by neither alone.
        (
            [
                ((0.0, 0.0, 0.0), (0.6, 0.1, 0.1)),
                ((-0.2, 0.0, 0.0), (0.42, 0.3, 0.3)),
                ((0.2, 0.0, 0.0), (0.42, 0.3, 0.3)),
            ],
            (1, 2),
        ),
        # Next to nothing, and a plate as thin but wide.
        ([CUBE, ((0.6, 0.0, 0.0), (0.001, 0.001, 0.2))], (0,)),
        ([CUBE, ((0.6, 0.0, 0.0), (0.001, 0.2, 0.2))], (0, 1)),
        # One stays, however small.
        ([((0.0, 0.0, 0.0), (0.001, 0.001, 0.001))] * 2, (0,)),
    ],
)
def test_the_blocks_that_are_used(placed: list[Box], used: tuple[int, ...]) -> None:
    assert used_blocks(*boxes(*placed)) == used


def test_nothing_visible_is_lost() -> None:
    """Of many objects of random boxes: what is left out shows less than LEAST_AREA beside what stays."""
    generator = np.random.default_rng(0)
    left_out = 0
    for _ in range(50):
        placed = zip(generator.uniform(-0.2, 0.2, (8, 3)), generator.uniform(0.02, 0.8, (8, 3)), strict=True)
        vertices, faces, blocks = boxes(*((tuple(centre), tuple(sides)) for centre, sides in placed))
        used = used_blocks(vertices, faces, blocks)
        surfaces = surfaces_of(vertices, faces, blocks)
        left_out += len(blocks) - len(used)
        for block in set(range(len(blocks))) - set(used):
            # Several that were left out may have hidden each other.
            assert shown_area(surfaces, block, used) < 2 * LEAST_AREA
    assert left_out > 20


def test_what_is_used_is_a_whole_object(engine: Engine) -> None:
    vertices, faces, blocks = boxes(((0.0, 0.0, 0.0), (0.1, 0.1, 0.1)), CUBE, ((0.6, 0.0, 0.0), (0.2, 0.2, 0.2)))
    manifest = replace(
        engine.manifest, vertices=24, faces=tuple((int(a), int(b), int(c)) for a, b, c in faces), blocks=blocks
    )
    surface = Surface(vertices.astype(np.float32), np.tile(np.float32([0, 1, 0]), (24, 1)))
    part, remaining = used_part(surface, manifest)
    np.testing.assert_array_equal(part.vertices, surface.vertices[8:])
    assert remaining.blocks == (Block("block-2", 0, 12), Block("block-3", 12, 12))
    scene = trimesh.load(
        trimesh.util.wrap_as_stream(write_glb(part, remaining, 0.0, {})), file_type="glb", process=False
    )
    assert set(scene.geometry) == {"block-2", "block-3"}
    np.testing.assert_allclose(scene.geometry["block-3"].triangles, vertices[faces[24:]], atol=1e-6)


def test_a_reconstruction_leaves_unused_blocks_out_where_asked(engine: Engine, picture: bytes) -> None:
    """A model whose mesh is said to be one body and a part of one face that nothing shows."""
    faces = (*engine.manifest.faces, (0, 0, 0))
    count = len(engine.manifest.faces)
    blocks = (Block("body", 0, count), Block("nothing", count, 1))
    manifest = replace(engine.manifest, faces=faces, blocks=blocks)
    odd = replace(engine, manifest=manifest, faces=np.array(faces, np.int64))
    whole, used = (reconstruct([odd], [picture], 10**6, blocks=blocks) for blocks in ("all", "used"))
    assert used.report == whole.report
    assert [len(meshes(answer.content)) for answer in (whole, used)] == [2, 1]


def meshes(glb: bytes) -> list[str]:
    (length,) = struct.unpack_from("<I", glb, 12)
    return [mesh["name"] for mesh in json.loads(glb[20 : 20 + length])["meshes"]]
