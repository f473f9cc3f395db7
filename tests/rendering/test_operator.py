"""The torch operator: gradients, compilation, and a path trained with a loss and an optimizer of torch."""

from __future__ import annotations

import shutil
import subprocess
import sys
import threading
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import torch
import warp as wp
from assertions import assert_grad_close, check_gradients
from backends import Backend
from oracles import GRADIENTS, adjoint, cotangent, make_renderer
from scenes import SceneTensors, circle, random_scene, with_points
from torch import Tensor

import warpvec
from warpvec.errors import InputError
from warpvec.geometry.circles import circle_points, circle_sides
from warpvec.geometry.scene import Scene
from warpvec.paper import splat
from warpvec.rendering.operator import _inputs
from warpvec.rendering.streams import on_warps_stream

HEIGHT, WIDTH = 20, 35


def scene_of(tensors: SceneTensors, dtype: torch.dtype = torch.float64, device: str = "cpu") -> Scene:
    generation = torch.zeros(len(tensors.points), dtype=torch.int64)
    return Scene.uniform(*(tensor.to(device, dtype) for tensor in tensors[:4]), generation.to(device))


def with_values(scene: Scene, tensors: Sequence[Tensor]) -> Scene:
    """Return ``scene`` with the values ``tensors``, in the order of ``GRADIENTS``."""
    points, color, opacity, background = tensors
    return replace(with_points(scene, points), color=color, opacity=opacity, background=background)


def leaves_of(scene: Scene) -> list[Tensor]:
    return [getattr(scene, name).clone().requires_grad_() for name in GRADIENTS]


def drawing(scene: Scene, height: int = HEIGHT, width: int = WIDTH) -> Callable[..., Tensor]:
    """Return ``warpvec.render`` as a function of the four tensors."""
    return lambda *tensors: warpvec.render(with_values(scene, tensors), height, width)


@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
def test_image_and_gradients_are_those_of_the_renderer(dtype: torch.dtype, device: str) -> None:
    tensors = random_scene(1, 9, HEIGHT, WIDTH)
    scene = scene_of(tensors, dtype, device)
    leaves = leaves_of(scene)
    image = drawing(scene)(*leaves)
    assert image.shape == (HEIGHT, WIDTH, 3) and image.dtype == dtype and image.device == scene.points.device
    image.backward(cotangent(tensors).to(image))
    renderer = make_renderer(tensors, Backend(device), dtype, transmittance_min=1e-4)
    want = adjoint(tensors, renderer, cotangent(tensors))
    for name, leaf in zip(GRADIENTS, leaves, strict=True):
        assert_grad_close(leaf.grad, getattr(want, name), rtol=1e-6, atol=0.0, name=name)


SPLAT: dict[str, Any] = {"renderer": "splat", "samples": 9, "lines": 4}


def sides_scene(dtype: torch.dtype = torch.float64, device: str = "cpu", count: int = 5) -> Scene:
    """Return a scene of two-sided circles of degree 5."""
    center, radius = torch.rand(count, 2) * torch.tensor([WIDTH, HEIGHT]), 3.0 + 5.0 * torch.rand(count)
    tensors = (circle_sides(center, radius, 5), torch.rand(count, 3), 0.2 + 0.6 * torch.rand(count), torch.rand(3))
    generation = torch.zeros(count, dtype=torch.int64, device=device)
    return Scene.uniform(*(tensor.to(device, dtype) for tensor in tensors), generation, 5)


@pytest.mark.parametrize("switches", [{}, {"interior_gradient": False}, {"covariance_gradient": True}])
def test_splat_is_drawn_with_its_settings_and_the_degree_of_the_scene(switches: dict[str, bool], device: str) -> None:
    scene = sides_scene(device=device)
    leaves, adj_image = leaves_of(scene), torch.randn(HEIGHT, WIDTH, 3, dtype=torch.float64).to(device)
    drawn = with_values(scene, leaves)
    image = warpvec.render(drawn, HEIGHT, WIDTH, **SPLAT, **switches)
    image.backward(adj_image)
    settings = {"samples": 9, "lines": 4, "degree": 5, **switches}
    renderer = splat.SplatRenderer(HEIGHT, WIDTH, device=device, dtype=torch.float64, **settings)
    torch.testing.assert_close(image.detach(), renderer.render(scene), rtol=1e-12, atol=1e-12)
    want = renderer.adjoint(scene, adj_image)
    grads = [leaves[0].grad.view_as(want.segments), *(leaf.grad for leaf in leaves[1:])]
    for name, grad in zip(("segments", *GRADIENTS[1:]), grads, strict=True):
        assert_grad_close(grad, getattr(want, name), rtol=1e-6, atol=0.0, name=name)


def test_gradcheck() -> None:
    scene = scene_of(random_scene(3, 2, 9, 18))
    # The image has kinks where an edge crosses a pixel corner. A small step meets few of them and is fine in float64.
    check_gradients(drawing(scene, 9, 18), leaves_of(scene))


@pytest.mark.parametrize("name", ["segments", *GRADIENTS[1:]])
def test_one_input_alone_may_ask_for_a_gradient(name: str) -> None:
    scene = scene_of(random_scene(4, 3, HEIGHT, WIDTH))
    leaf = getattr(scene, name).clone().requires_grad_()
    warpvec.render(replace(scene, **{name: leaf}), HEIGHT, WIDTH).sum().backward()
    assert leaf.grad.shape == leaf.shape and leaf.grad.any()


def test_gradients_of_two_renders_add_up() -> None:
    scene = scene_of(random_scene(5, 4, HEIGHT, WIDTH))
    leaf = scene.points.clone().requires_grad_()
    grown = with_points(scene, leaf)
    # Both renders come before both adjoints. They have the same canvas size and so share buffers.
    loss = warpvec.render(grown, HEIGHT, WIDTH).square().sum() + warpvec.render(grown.scaled(0.5), HEIGHT, WIDTH).sum()
    loss.backward()
    parts = [torch.autograd.grad(part(leaf), leaf)[0] for part in two_losses(scene)]
    torch.testing.assert_close(leaf.grad, parts[0] + parts[1], rtol=1e-12, atol=1e-12)


def two_losses(scene: Scene) -> list[Callable[[Tensor], Tensor]]:
    return [
        lambda points: warpvec.render(with_points(scene, points), HEIGHT, WIDTH).square().sum(),
        lambda points: warpvec.render(with_points(scene, 0.5 * points), HEIGHT, WIDTH).sum(),
    ]


@pytest.mark.slow
@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
@pytest.mark.parametrize("path_count", [0, 5])
def test_opcheck(dtype: torch.dtype, path_count: int) -> None:
    scene = scene_of(random_scene(path_count, path_count, HEIGHT, WIDTH), dtype)
    image = torch.rand(HEIGHT, WIDTH, 3, dtype=dtype)
    operators = torch.ops.warpvec
    plain = _inputs(scene)
    splats = '{"degree": 3, "lines": 3, "samples": 8}'
    for renderer, settings, counts in (("exact", "{}", (4, 0)), ("splat", splats, (4,))):
        for count in counts:  # of segments per path; 0 if the structure alone tells
            leaves = [*(value.clone().requires_grad_() for value in plain[:4]), *plain[4:]]
            torch.library.opcheck(operators.render.default, (leaves, count, HEIGHT, WIDTH, renderer, 1, settings))
            torch.library.opcheck(operators.render_adjoint.default, (plain, image, count, renderer, 1, settings))


# inductor itself imports what torch has deprecated.
@pytest.mark.filterwarnings("ignore::DeprecationWarning:torch")
@pytest.mark.parametrize("settings", [{}, SPLAT])
@pytest.mark.parametrize("backend", ["eager", "aot_eager", pytest.param("inductor", marks=pytest.mark.slow)])
def test_compiles_without_a_graph_break(backend: str, settings: dict[str, Any]) -> None:
    if backend == "inductor" and not shutil.which("g++"):
        pytest.skip("inductor needs a C++ compiler, g++ is not on the path")
    scene = scene_of(random_scene(6, 4, HEIGHT, WIDTH), torch.float32)

    def loss(points: Tensor, color: Tensor, opacity: Tensor, background: Tensor) -> Tensor:
        moved = Scene.uniform(points + 1.0, color.sigmoid(), opacity, background, scene.generation)
        return (warpvec.render(moved, HEIGHT, WIDTH, **settings) - 0.5).square().mean()

    plain, compiled = leaves_of(scene), leaves_of(scene)
    want = loss(*plain)
    got = torch.compile(loss, fullgraph=True, backend=backend)(*compiled)
    want.backward()
    got.backward()
    torch.testing.assert_close(got, want)
    for mine, theirs in zip(compiled, plain, strict=True):
        torch.testing.assert_close(mine.grad, theirs.grad)


def test_a_path_learns_a_disc_from_a_loss_and_optimizer_of_torch() -> None:
    height, width, target = 48, 64, torch.tensor([0.9, 0.2, 0.1])
    disc = SceneTensors(circle(36.0, 22.0, 13.0)[None], target[None], torch.ones(1), torch.ones(3), height, width)
    photo = warpvec.render(scene_of(disc, torch.float32), height, width)
    points = circle_points(torch.tensor([[27.0, 27.0]]), torch.tensor([7.0]), 4).requires_grad_()
    color, opacity = torch.full((1, 3), 0.5, requires_grad=True), torch.full((1,), 0.5, requires_grad=True)
    optimizer = torch.optim.Adam([{"params": [points], "lr": 0.5}, {"params": [color, opacity], "lr": 0.02}])

    def custom_loss() -> Tensor:
        scene = Scene.uniform(points, color, opacity.clamp(0, 1), torch.ones(3), torch.zeros(1, dtype=torch.int64))
        return (warpvec.render(scene, height, width) - photo).abs().pow(1.5).sum()

    first = custom_loss().item()
    for _ in range(150):
        optimizer.zero_grad()
        loss = custom_loss()
        loss.backward()
        optimizer.step()
    assert loss.item() < 0.01 * first
    # The anchors lie on the disc. The blended colour is right; colour and opacity alone need not be.
    distance = (points.detach()[0, ::3] - torch.tensor([36.0, 22.0])).norm(dim=1)
    assert (distance - 13.0).abs().max() < 0.5
    shown = opacity * color[0] + (1 - opacity)
    assert (shown.detach() - target).abs().max() < 0.02


def test_threads_of_the_caller_take_turns() -> None:
    scenes = [scene_of(random_scene(seed, 30, 60, 70), torch.float32) for seed in range(4)]
    want = [warpvec.render(scene, 60, 70) for scene in scenes]
    found: list[Tensor | None] = [None] * 4

    def work(index: int) -> None:
        for _ in range(5):
            found[index] = warpvec.render(scenes[index], 60, 70)

    callers = [threading.Thread(target=work, args=(index,)) for index in range(4)]
    for caller in callers:
        caller.start()
    for caller in callers:
        caller.join()
    assert all(got is not None and torch.equal(got, image) for got, image in zip(found, want, strict=True))


def test_threads_change_no_bit() -> None:
    scene = scene_of(random_scene(7, 80, 100, 200), torch.float32)
    images = [warpvec.render(scene, 100, 200, threads=threads) for threads in (None, 1, 2, 3)]
    assert all(torch.equal(image, images[0]) for image in images)


@pytest.mark.parametrize(
    ("height", "width", "options", "message"),
    [
        (0, 5, {}, "height must be a whole number of at least 1, got 0; "),
        (5, -1, {}, "width must be a whole number of at least 1, got -1; "),
        (16.0, 5, {}, "height must be a whole number of at least 1, got 16.0; "),
        (5, "5", {}, "width must be a whole number of at least 1, got '5'; "),
        (5, 5, {"threads": -1}, "threads must be a whole number from 1 to 4096, got -1; "),
        (5, 5, {"threads": 0}, "threads must be a whole number from 1 to 4096, got 0; "),
        (5, 5, {"threads": 1.5}, "threads must be a whole number from 1 to 4096, got 1.5; "),
        (5, 5, {"renderer": "fast"}, "renderer must be one of exact, splat, got 'fast'"),
        (5, 5, {"samples": 9}, "samples is not a setting of the renderer exact, which has none"),
        (
            5,
            5,
            {"renderer": "splat", "degree": 5},
            "degree is not a setting of the renderer splat, which has samples, ",
        ),
        (5, 5, {"renderer": "splat", "lines": 0}, "lines must be a whole number from 1 to 1024, got 0; "),
    ],
)
def test_bad_arguments_are_told_in_one_line(height: Any, width: Any, options: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError) as caught:
        warpvec.render(scene_of(random_scene(1, 1, 5, 5)), height, width, **options)
    assert str(caught.value).startswith(message) and "\n" not in str(caught.value)


def test_exact_takes_cubics_only() -> None:
    with pytest.raises(
        InputError, match="scene must have degree 3 for the renderer exact, got 5; convert it "
    ) as caught:
        warpvec.render(sides_scene(), HEIGHT, WIDTH)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "change",
    [
        {"color": torch.float32},
        {"segments": torch.float32},
        dict.fromkeys(("segments", *GRADIENTS[1:]), torch.float16),
    ],
)
def test_mixed_or_half_precision_is_told_in_one_line(change: dict[str, torch.dtype]) -> None:
    scene = scene_of(random_scene(1, 2, 5, 5))
    scene = replace(scene, **{name: getattr(scene, name).to(dtype) for name, dtype in change.items()})
    with pytest.raises(InputError, match="float32 or float64") as caught:
        warpvec.render(scene, 5, 5)
    assert "\n" not in str(caught.value)


def test_a_device_without_a_renderer_is_told_in_one_line() -> None:
    scene = scene_of(random_scene(1, 2, 5, 5), device="meta")
    with pytest.raises(InputError, match="scene must be on the CPU or a CUDA device, got meta; ") as caught:
        warpvec.render(scene, 5, 5)
    assert "\n" not in str(caught.value)


def test_sizes_may_be_numpys() -> None:
    scene = scene_of(random_scene(1, 2, 5, 6))
    image = warpvec.render(scene, np.int64(5), np.int32(6), threads=np.int64(1))
    assert torch.equal(image, warpvec.render(scene, 5, 6))


@pytest.mark.skipif(not hasattr(torch.Tag, "cudagraph_unsafe"), reason="torch before 2.9 has no such tag")
@pytest.mark.parametrize("name", ["render", "render_adjoint"])
def test_no_cuda_graph_records_the_operators(name: str) -> None:
    assert torch.Tag.cudagraph_unsafe in getattr(torch.ops.warpvec, name).default.tags


def test_streams_of_the_caller_are_kept_in_order(device: str) -> None:
    if device == "cpu":
        pytest.skip("the CPU has no streams")
    scene, factors = scene_of(random_scene(8, 30, 100, 200), torch.float32, device), (1.0, 0.5)
    want = [image_and_gradients(scene.scaled(factor)) for factor in factors]
    before, found = wp.get_stream(device), []
    torch.cuda.synchronize()
    for factor in factors:
        with torch.cuda.stream(torch.cuda.Stream()):
            torch.cuda._sleep(100_000_000)  # all that follows on this stream comes late, the inputs too
            found.append(image_and_gradients(scene.scaled(factor)))
    torch.cuda.synchronize()
    assert wp.get_stream(device) is before
    for got, expected in zip(found, want, strict=True):
        torch.testing.assert_close(got, expected, rtol=1e-4, atol=1e-4)


def test_a_drawing_within_a_fit_stays_on_warps_stream(device: str) -> None:
    scene = scene_of(random_scene(8, 30, 100, 200), torch.float32, device)
    want, before = image_and_gradients(scene), None if device == "cpu" else wp.get_stream(device)
    with on_warps_stream(device):
        got = image_and_gradients(scene)
    assert device == "cpu" or wp.get_stream(device) is before
    torch.testing.assert_close(got, want, rtol=1e-4, atol=1e-4)


def image_and_gradients(scene: Scene) -> list[Tensor]:
    """Return the image and the gradients of the sum of its squares."""
    leaves = leaves_of(scene)
    image = drawing(scene, 100, 200)(*leaves)
    image.square().sum().backward()
    return [image.detach(), *(leaf.grad for leaf in leaves)]


def test_importing_the_package_loads_neither_torch_nor_warp() -> None:
    code = "import sys, warpvec; sys.exit(bool({'torch', 'warp'} & set(sys.modules)))"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
