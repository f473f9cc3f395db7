"""Paths of several loops, and of different numbers of segments: the reference, resvg, and gradients."""

from __future__ import annotations

import weakref
from collections.abc import Callable
from dataclasses import replace

import pytest
import reference
import torch
from assertions import assert_grad_close, assert_grad_present, check_gradients
from backends import Backend
from compound import compound_scene, ring, scene_of_loops, split_into_loops
from drawn import EIGHT_BIT, ONE_PATH, near
from exact_renderers import HEIGHT, WIDTH, in_float32, make_renderer
from oracles import inputs
from reference.compositing import composite
from scenes import circle, random_scene
from svg_files import absolute_data, svg_file
from torch import Tensor

import warpvec
from warpvec.geometry.scene import Scene
from warpvec.geometry.structure import Structure
from warpvec.rendering.exact import ExactRenderer
from warpvec.rendering.graph import RecordedStep
from warpvec.svg.measure import draw

VALUES = ("segments", "color", "opacity", "background")


def reference_image(scene: Scene, renderer: ExactRenderer) -> Tensor:
    """Return the reference's image of ``scene``, with the chords of the renderer's last call."""
    first = torch.from_numpy(renderer._flattening.segment_first_vertex.numpy()[: len(scene.segments) + 1].copy())
    counts = [[loop.tolist() for loop in path] for path in split_into_loops(first.diff(), scene.structure)]
    loops = [[loop.flatten(0, 1) for loop in path] for path in split_into_loops(scene.segments, scene.structure)]
    stack = reference.compound_coverage(loops, counts, renderer.grid.height, renderer.grid.width)
    return composite(stack, scene.color, scene.opacity, scene.background)


@pytest.mark.parametrize("seed", range(4))
def test_image_and_gradients_are_those_of_the_reference(seed: int, backend: Backend) -> None:
    scene, renderer = compound_scene(seed, 9, HEIGHT, WIDTH), make_renderer(backend)
    image = renderer.render(scene.to(backend.device)).cpu()
    leaves = [getattr(scene, name).clone().requires_grad_() for name in VALUES]
    want = reference_image(replace(scene, **dict(zip(VALUES, leaves, strict=True))), renderer)
    torch.testing.assert_close(image, want.detach(), rtol=0, atol=1e-12)
    adj_image = torch.randn(HEIGHT, WIDTH, 3, dtype=torch.float64)
    got = renderer.adjoint(scene.to(backend.device), adj_image.to(backend.device))
    gradients = torch.autograd.grad((want * adj_image).sum(), leaves)
    for name, gradient in zip(VALUES, gradients, strict=True):
        assert_grad_close(getattr(got, name), gradient, rtol=1e-12, atol=1e-13, name=name)
        assert_grad_present(getattr(got, name), gradient, name)


@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
def test_a_uniform_scene_has_the_same_bits_by_its_loops(dtype: torch.dtype, backend: Backend) -> None:
    tensors, renderer = random_scene(3, 20, HEIGHT, WIDTH), make_renderer(backend, dtype)
    uniform = inputs(tensors, renderer)
    listed = replace(uniform, structure=Structure.of_loops([[4]] * 20).to(backend.device))
    assert listed.structure.uniform_count is None
    images = [renderer.render(scene) for scene in (uniform, listed)]
    assert torch.equal(*images)
    target = renderer.prepare_target(torch.rand(HEIGHT, WIDTH, 3))
    steps = [renderer.fit_step(scene, target, True) for scene in (uniform, listed)]
    for name in (*VALUES, "loss", "removal_cost"):
        assert torch.equal(*(getattr(step, name) for step in steps)), name


COMPOUND: dict[str, tuple[list[Tensor], float]] = {
    "hole": (ring(25.3, 16.8, 14.6, 8.2), 1.0),
    "hole first": (ring(25.3, 16.8, 14.6, 8.2)[::-1], 1.0),
    "both loops run the same way": (ring(25.3, 16.8, 14.6, 8.2, turns=1), 0.0),
    "apart": ([circle(12.2, 12.7, 9.3), circle(37.1, 20.4, 10.8, 5), circle(36.2, 20.9, 4.1, 2, -1)], 1.0),
}
"""Loops of a black path on white, and the value in the middle of the image."""


@pytest.mark.parametrize("name", COMPOUND)
def test_resvg_draws_the_same(name: str) -> None:
    loops, middle = COMPOUND[name]
    black = torch.zeros(1, 3, dtype=torch.float64)
    scene = replace(scene_of_loops([loops]), color=black, opacity=black[0, :1] + 1, background=black[0] + 1)
    image = warpvec.render(scene, HEIGHT, WIDTH)
    data = "".join(absolute_data(loop.tolist()) for loop in loops)
    file = svg_file(f'<path d="{data}"/>', f'width="{WIDTH}" height="{HEIGHT}"')
    drawn = torch.from_numpy(draw(file, WIDTH, HEIGHT) / 255.0)
    bound = EIGHT_BIT + ONE_PATH * near(((image > 1e-9) & (image < 1 - 1e-9))[..., :1])
    assert ((image - drawn).abs() <= bound).all()
    assert image[16, 25, 0].item() == pytest.approx(middle, abs=1e-9)


def drawing(scene: Scene, height: int, width: int) -> Callable[..., Tensor]:
    """Return ``warpvec.render`` as a function of the four tensors."""
    return lambda *values: warpvec.render(replace(scene, **dict(zip(VALUES, values, strict=True))), height, width)


def test_gradcheck() -> None:
    scene = compound_scene(5, 3, 9, 18)
    leaves = [getattr(scene, name).clone().requires_grad_() for name in VALUES]
    # The image has kinks where an edge crosses a pixel corner. A small step meets few of them and is fine in float64.
    check_gradients(drawing(scene, 9, 18), leaves)


# torch.compile imports what torch has deprecated.
@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::DeprecationWarning:torch")
def test_it_compiles_without_a_graph_break() -> None:
    scene = compound_scene(6, 4, HEIGHT, WIDTH)
    leaves = [getattr(scene, name).clone().requires_grad_() for name in VALUES]
    plain, compiled = drawing(scene, HEIGHT, WIDTH), drawing(scene, HEIGHT, WIDTH)
    want = plain(*leaves)
    got = torch.compile(compiled, fullgraph=True, backend="aot_eager")(*leaves)
    torch.testing.assert_close(got, want)
    gradients = [torch.autograd.grad(image.square().sum(), leaves) for image in (got, want)]
    torch.testing.assert_close(*gradients)


def test_a_path_that_is_not_finite_in_one_loop_is_not_drawn(backend: Backend) -> None:
    scene, renderer = compound_scene(7, 6, HEIGHT, WIDTH), make_renderer(backend)
    segments = scene.segments.clone()
    segments[scene.structure.path_first_segment[3] + 5, 1, 0] = torch.nan  # in the second loop of a ring
    broken, rest = replace(scene, segments=segments), scene.select(torch.arange(6) != 3)
    broken, rest = broken.to(backend.device), rest.to(backend.device)
    assert torch.equal(renderer.render(broken), renderer.render(rest))
    got = renderer.adjoint(broken, torch.ones(HEIGHT, WIDTH, 3, dtype=torch.float64, device=backend.device))
    rows = (scene.structure.segment_path == 3).to(backend.device)
    assert not got.segments[rows].any() and got.segments.isfinite().all()


def test_a_recorded_step_keeps_the_arrays_of_its_structure() -> None:
    """Scenes with equal addresses are replayed, though what follows from their structures lies in other memory."""
    renderer, plain = (ExactRenderer(HEIGHT, WIDTH, threads=1, lane_width=1) for _ in range(2))
    scene, other = in_float32(compound_scene(8, 9, HEIGHT, WIDTH)), in_float32(compound_scene(9, 3, HEIGHT, WIDTH))
    step, target = RecordedStep(renderer, record=True), renderer.prepare_target(torch.rand(HEIGHT, WIDTH, 3))
    for _ in range(3):
        step.take(scene, target)
    recorded = weakref.ref(scene.structure)
    scene = replace(scene, structure=Structure(scene.structure.loop_first_segment, scene.structure.path_first_loop))
    renderer.render(other)  # holds the arrays of another structure from now on
    got, want = step.take(scene, target), plain.fit_step(scene, target)
    assert recorded() is not None  # the graph has read its arrays
    assert torch.equal(got.segments, want.segments) and torch.equal(got.color, want.color)
