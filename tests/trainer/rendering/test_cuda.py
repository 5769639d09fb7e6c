"""The Triton kernels against the readable reference: on a GPU where there is one, else in Triton's interpreter."""

import os
import subprocess
import sys
from collections.abc import Callable

import numpy as np
import pytest
import torch
from torch import Tensor

from rasteriser.pictures import HARD
from rasteriser.topology import build_topology
from tests.rasteriser.scenes import Scene, random_scene
from trainer.recording import Recording
from trainer.rendering import cuda, reference

DEVICE = "cuda" if torch.cuda.is_available() else "cpu"
pytestmark = [pytest.mark.gpu] if DEVICE == "cuda" else []

ONE_CUBE = (2, 10, 14, 17)
PARTLY_OUTSIDE = (0, 8)
COLLAPSED_FACES = (5, 233)
INTERPENETRATING = (52, 70, 87, 109, 120, 144, 145, 247, 259)
TINY_PICTURES = (27, 34, 65, 126, 142, 291)
BEHIND_THE_CAMERA = (200, 239, 263)
ONE_UPON_ANOTHER = (36, 38)
SEEDS = (
    ONE_CUBE
    + PARTLY_OUTSIDE
    + COLLAPSED_FACES
    + INTERPENETRATING
    + TINY_PICTURES
    + BEHIND_THE_CAMERA
    + ONE_UPON_ANOTHER
)
# The interpreter takes its time: SCENES=1000 looks at a thousand.
SCENES = int(os.environ.get("SCENES", "0"))


def _reference(
    scene: Scene, screen: Tensor, colours: Tensor, value_of: Callable[[Tensor], Tensor]
) -> tuple[Tensor, Tensor, Tensor]:
    """Of one mesh: a value of its picture, and gradients of vertices and colours, in float64."""
    screen, colours = (part.detach().cpu().double().requires_grad_() for part in (screen, colours))
    faces = torch.tensor(scene.topology.faces.astype(np.int64))
    value = value_of(reference.draw(screen, colours, faces, *scene.size))
    gradients = torch.autograd.grad(value.sum(), (screen, colours), allow_unused=True, materialize_grads=True)
    return value.detach(), *gradients


def _assert_close(found: Tensor, expected: Tensor, message: str = "") -> None:
    tolerance = 1e-5 * max(1.0, expected.abs().max().item() if expected.numel() else 0.0)
    np.testing.assert_allclose(found.detach().cpu(), expected, rtol=0, atol=tolerance, err_msg=message)


def _merged(gradient: Tensor, screen: np.ndarray) -> Tensor:
    """Summed over vertices at the same place: which of two coincident edges moves a picture is anybody's choice."""
    _, place = np.unique(screen, axis=0, return_inverse=True)
    return torch.zeros(gradient.shape, dtype=torch.float64).index_add(
        0, torch.tensor(place.reshape(-1)), gradient.cpu().double()
    )


@pytest.mark.parametrize("seed", range(SCENES) if SCENES else SEEDS)
def test_pictures_and_their_gradients_are_the_reference_s(seed: int) -> None:
    scene = random_scene(seed)
    upstream = torch.tensor(np.random.default_rng(seed).normal(size=(2, *scene.target.shape)))
    shift = torch.tensor([[0.0, 0.0, 0.0], [0.37, -0.61, 0.0]])
    screen = (torch.tensor(scene.screen) + shift[:, None]).to(DEVICE).requires_grad_()
    colours = torch.tensor(np.stack((scene.colours, 1 - scene.colours)), device=DEVICE, requires_grad=True)
    pictures = cuda.draw(screen, colours, scene.topology, *scene.size)
    (pictures * upstream.to(pictures)).sum().backward()
    assert screen.grad is not None
    assert colours.grad is not None
    for n in range(2):
        picture, *_ = _reference(scene, screen[n], colours[n], lambda picture: picture)
        _assert_close(pictures[n], picture)
        _, *gradients = _reference(scene, screen[n], colours[n], lambda picture, n=n: picture * upstream[n])
        for found, expected in zip((screen.grad[n], colours.grad[n]), gradients, strict=True):
            _assert_close(_merged(found, scene.screen), _merged(expected, scene.screen))


def _hypotheses(seed: int) -> tuple[Scene, Tensor, Tensor, Tensor]:
    """A scene with three hypotheses for each of two pictures."""
    scene = random_scene(seed)
    shift = np.random.default_rng(0).normal(scale=0.7, size=(2, 3, 1, 3)) * [1, 1, 0]
    screen = torch.tensor(scene.screen + shift, dtype=torch.float32, device=DEVICE)
    colours = torch.tensor(scene.colours, device=DEVICE).expand(2, 3, -1, -1)
    pictures = torch.tensor(np.stack((scene.target, scene.target[:, ::-1])).copy(), device=DEVICE)
    return scene, screen, colours, pictures


@pytest.mark.parametrize("binarise", [0.0, 0.1])
def test_log_likelihoods_are_the_reference_s_and_what_is_negligible_gets_no_gradient(binarise: float) -> None:
    scene, screen, colours, pictures = _hypotheses(10)
    screen, colours = screen.requires_grad_(), colours.clone().requires_grad_()
    weights = torch.tensor([[1.0, -0.5, 2e-4], [0.3, 0.0, 5e-5]])
    values = cuda.log_likelihood(screen, colours, pictures, scene.topology, binarise=binarise)
    (values * weights.to(DEVICE)).sum().backward()
    assert values.dtype == torch.float32
    assert screen.grad is not None
    assert colours.grad is not None
    assert not screen.grad[1, 2].any()
    for b in range(2):
        target = pictures[b].cpu().double()
        for r in range(3):
            value, *gradients = _reference(
                scene,
                screen[b, r],
                colours[b, r],
                lambda picture, x=target: reference.log_likelihood(picture, x, binarise),
            )
            assert values[b, r].item() == pytest.approx(value.item(), rel=1e-5)
            scale = weights[b, r].item() if (b, r) != (1, 2) else 0.0
            for found, expected in zip((screen.grad[b, r], colours.grad[b, r]), gradients, strict=True):
                _assert_close(found, scale * expected, f"hypothesis {b}, {r}")


def test_an_expectation_is_the_weighed_sum_and_leaves_out_what_does_not_matter() -> None:
    scene, screen, colours, pictures = _hypotheses(10)
    weights = torch.tensor([[0.7, 0.3, 0.0], [0.2, 0.7995, 0.0005]], device=DEVICE)
    kept = torch.where(weights < 1e-3, 0.0, weights)
    found, twin = screen.clone().requires_grad_(), screen.clone().requires_grad_()
    value = cuda.expected_log_likelihood(found, colours, pictures, weights, scene.topology)
    expected = (cuda.log_likelihood(twin, colours, pictures, scene.topology) * kept).sum(1)
    np.testing.assert_allclose(value.detach().cpu(), expected.detach().cpu(), rtol=1e-5)
    upstream = torch.tensor([1.5, -2.0], device=DEVICE)
    value.backward(upstream)
    expected.backward(upstream)
    assert found.grad is not None
    assert twin.grad is not None
    _assert_close(found.grad, twin.grad.cpu())
    assert not found.grad[:, 2].any()
    nothing = cuda.expected_log_likelihood(screen, colours, pictures, torch.zeros_like(weights), scene.topology)
    assert nothing.tolist() == [0.0, 0.0]


@pytest.mark.parametrize("seed", [10, INTERPENETRATING[0]])
def test_room_to_spare_changes_nothing_and_too_little_is_told(seed: int) -> None:
    scene, screen, colours, pictures = _hypotheses(seed)
    weights = torch.tensor([[0.7, 0.3, 0.0], [0.2, 0.8, 0.0]], device=DEVICE)
    recording = Recording()

    def run(room: list[int] | None) -> tuple[Tensor, Tensor, list[int]]:
        moved = screen.clone().requires_grad_()
        with recording.at_work(room):
            values = cuda.expected_log_likelihood(moved, colours, pictures, weights, scene.topology, 0.0)
            (gradient,) = torch.autograd.grad(values.sum(), moved)
        return values.detach().cpu(), gradient.cpu(), [int(needed) for needed in recording.needed]

    values, gradient, needed = run(None)
    assert needed[0] == 4
    assert (needed[1] > 0) == (seed == INTERPENETRATING[0])
    spared, spared_gradient, again = run([6, needed[1] + 40, needed[2] + 1000])
    assert again == needed
    np.testing.assert_allclose(spared, values, rtol=1e-9)
    _assert_close(spared_gradient, gradient)
    for number in (0, 1, 2):
        if needed[number]:
            *_, told = run([one // 3 if number == which else one for which, one in enumerate(needed)])
            assert told[number] == needed[number]


def test_a_crease_threshold_decides_what_is_antialiased() -> None:
    scene = random_scene(10)
    screen, colours = torch.tensor(scene.screen, device=DEVICE), torch.tensor(scene.colours, device=DEVICE)
    faces = torch.tensor(scene.topology.faces.astype(np.int64))
    pictures = []
    for crease in (0.0, 1e9, HARD):
        pictures.append(cuda.draw(screen[None], colours[None], scene.topology, *scene.size, crease=crease)[0])
        expected = reference.draw(screen.cpu().double(), colours.cpu().double(), faces, *scene.size, crease=crease)
        _assert_close(pictures[-1], expected)
    assert (pictures[0] - pictures[1]).abs().max() > 1e-3
    assert (pictures[1] - pictures[2]).abs().max() > 1e-2


def test_inputs_may_lie_in_memory_as_they_like() -> None:
    scene = random_scene(2)
    screen = torch.tensor(scene.screen, dtype=torch.float64, device=DEVICE)[None].expand(2, -1, -1)
    colours = torch.tensor(scene.colours, device=DEVICE)[None].expand(2, -1, -1)
    scattered = screen.permute(2, 1, 0).contiguous().permute(2, 1, 0)
    drawn = cuda.draw(scattered, colours.transpose(1, 2).contiguous().transpose(1, 2), scene.topology, *scene.size)
    assert torch.equal(drawn, cuda.draw(screen.contiguous(), colours.contiguous(), scene.topology, *scene.size))


def test_an_axis_aligned_rectangle_is_its_exact_area_in_every_pixel() -> None:
    corners = torch.tensor([[1.25, 2.5, 0.5], [5.75, 2.5, 0.5], [5.75, 4.125, 0.5], [1.25, 4.125, 0.5]], device=DEVICE)
    topology, white = build_topology(np.array([[0, 1, 2], [0, 2, 3]])), torch.ones(1, 4, 1, device=DEVICE)
    drawn = cuda.draw(corners[None], white, topology, 8, 6)[0, 0].cpu()
    columns = np.clip(np.minimum(np.arange(8) + 1, 5.75) - np.maximum(np.arange(8), 1.25), 0, 1)
    rows = np.clip(np.minimum(np.arange(6) + 1, 4.125) - np.maximum(np.arange(6), 2.5), 0, 1)
    np.testing.assert_allclose(drawn, np.outer(rows, columns), atol=1e-6)


def test_meshes_without_faces_and_no_meshes_at_all_are_black() -> None:
    empty = build_topology(np.zeros((0, 3), np.int64))
    vertices = torch.zeros(2, 1, 4, 3, device=DEVICE, requires_grad=True)
    target = torch.tensor(np.random.default_rng(0).uniform(size=(2, 3, 6, 8)), dtype=torch.float32, device=DEVICE)
    values = cuda.log_likelihood(vertices, torch.ones_like(vertices), target, empty)
    values.sum().backward()
    expected = [reference.log_likelihood(torch.zeros_like(x), x).item() for x in target.cpu().double()]
    np.testing.assert_allclose(values.detach().cpu()[:, 0], expected, rtol=1e-5)
    assert vertices.grad is not None
    assert not vertices.grad.any()
    nobody = torch.zeros(0, 4, 3, device=DEVICE)
    assert cuda.draw(nobody, nobody, build_topology(np.array([[0, 1, 2]])), 5, 4).shape == (0, 3, 4, 5)


def test_faces_and_shapes_that_do_not_fit_are_refused() -> None:
    scene, screen, colours, _ = _hypotheses(10)
    with pytest.raises(ValueError, match="expected faces that name vertices 0 to 5, found 7"):
        cuda.draw(screen[0, :, :6], colours[0, :, :6], scene.topology, 8, 6)
    with pytest.raises(ValueError, match="expected screen"):
        cuda.draw(screen, colours, scene.topology, 8, 6)


COMPILE = """
import torch
import triton
from triton.backends.compiler import GPUTarget
from triton.compiler import ASTSource

from tests.rasteriser.scenes import random_scene
from trainer.rendering import cuda

POINTERS = {torch.float64: "*fp64", torch.float32: "*fp32", torch.int64: "*i64", torch.int32: "*i32", torch.bool: "*i1"}
OPTIONS = ("num_warps", "enable_fp_fusion")
DECISIONS = ("_visible", "_pairs", "_clip", "_cuts", "_pieces")
compiled = set()


def compile_only(self, *arguments, grid, warmup, **named):
    options = {name: named.pop(name) for name in OPTIONS if name in named}
    values = dict(zip(self.arg_names, arguments), **named)
    kinds = {name: "constexpr" if name in named else POINTERS.get(getattr(value, "dtype", None), "i32")
             for name, value in values.items()}
    constants = {(self.arg_names.index(name),): value for name, value in named.items()}
    kernel = triton.compile(ASTSource(self, kinds, constants), target=GPUTarget("cuda", 80, 32), options=options)
    assert kernel.asm["cubin"]
    if self.fn.__name__ in DECISIONS:
        assert "fma.rn.f64" not in kernel.asm["ptx"], self
    compiled.add((self.fn.__name__, named.get("FILL")))


triton.JITFunction.run = compile_only
cuda._check = lambda *arguments: None
scene = random_scene(0)
screen = torch.tensor(scene.screen, requires_grad=True)
picture = cuda.draw(screen[None], torch.tensor(scene.colours)[None], scene.topology, *scene.size)
picture.sum().backward()
print(len(compiled))
"""


@pytest.mark.skipif(DEVICE == "cuda", reason="where there is a GPU, the other tests compile every kernel")
def test_every_kernel_compiles_for_a_gpu() -> None:
    """For compute capability 8.0, with the types that the program passes; decisions must not be contracted."""
    environment = {name: value for name, value in os.environ.items() if name != "TRITON_INTERPRET"}
    done = subprocess.run(
        [sys.executable, "-c", COMPILE], capture_output=True, text=True, env=environment, check=False, timeout=300
    )
    assert done.returncode == 0, done.stderr
    assert int(done.stdout) == 11  # kernels, of which two in two forms


def test_tensors_on_the_cpu_are_refused_outside_the_interpreter(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("triton.knobs.runtime.interpret", False)
    points = torch.zeros(1, 3, 3)
    with pytest.raises(ValueError, match="expected tensors on a GPU, found them on cpu"):
        cuda.draw(points, points, build_topology(np.array([[0, 1, 2]])), 4, 4)


def test_triton_is_not_imported_unless_this_backend_is() -> None:
    program = "import sys, trainer.rendering.cpu, trainer.training.loop; sys.exit('triton' in sys.modules)"
    subprocess.run([sys.executable, "-c", program], check=True, timeout=120)
