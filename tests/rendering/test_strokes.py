"""Strokes: the reference, resvg, finite differences, and strokes that are degenerate."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
import torch
from assertions import assert_grad_close, assert_grad_present, check_gradients
from backends import Backend
from exact_renderers import HEIGHT, WIDTH, in_float32, make_renderer
from strokes import VALUES, reference_image, stroked_scene, values_of, with_values
from sweep import sweep

import warpvec
from warpvec.errors import InputError
from warpvec.geometry.scene import Scene
from warpvec.geometry.strokes import BUTT, MITER, ROUND, SQUARE, Strokes
from warpvec.geometry.structure import Structure


@sweep("seed", range(4))
def test_image_and_adjoints_are_those_of_the_reference(seed: int, backend: Backend) -> None:
    scene, renderer = stroked_scene(seed, 9, HEIGHT, WIDTH, filled=2), make_renderer(backend)
    leaves = [value.clone().requires_grad_() for value in values_of(scene)]
    adj_image = torch.randn(HEIGHT, WIDTH, 3, dtype=torch.float64)
    image = renderer.render(scene.to(backend.device)).cpu()
    want = reference_image(with_values(scene, leaves), renderer)
    torch.testing.assert_close(image, want.detach(), rtol=0, atol=1e-11)
    got = renderer.adjoint(scene.to(backend.device), adj_image.to(backend.device))
    for name, gradient in zip(VALUES, torch.autograd.grad((want * adj_image).sum(), leaves), strict=True):
        assert_grad_close(getattr(got, name), gradient, rtol=1e-9, atol=1e-10, name=name)
        assert_grad_present(getattr(got, name), gradient, name)


@sweep("seed", range(3))
def test_float32_is_near_the_reference(seed: int, backend: Backend) -> None:
    scene, renderer = stroked_scene(seed, 9, HEIGHT, WIDTH), make_renderer(backend, torch.float32)
    exact, image = make_renderer(), renderer.render(in_float32(scene).to(backend.device)).cpu()
    # A miter of an angle that is just too sharp in one precision only, or one chord more, changes a few pixels.
    off = (image - exact.render(scene)).abs().amax(-1)
    assert off.quantile(0.99) < 1e-3 and off.mean() < 1e-4


@sweep("seed", range(2))
def test_gradcheck(seed: int) -> None:
    scene = stroked_scene(seed, 5, 14, 19, (1.0, 4.0))
    leaves = [value.clone().requires_grad_() for value in values_of(scene)]
    check_gradients(lambda *values: warpvec.render(with_values(scene, values), 14, 19), leaves)


def test_strokes_of_no_width_change_nothing(backend: Backend) -> None:
    # Scalar lanes go round a path from another vertex, which changes last bits.
    scene, renderer = stroked_scene(3, 0, HEIGHT, WIDTH, filled=5).to(backend.device), make_renderer(backend)
    target, bare = renderer.prepare_target(torch.rand(HEIGHT, WIDTH, 3)), replace(scene, strokes=None)
    torch.testing.assert_close(renderer.render(scene), renderer.render(bare), rtol=0, atol=1e-14)
    got, want = renderer.fit_step(scene, target, True), renderer.fit_step(bare, target, True)
    assert not got.width.any() and want.width is None
    for name in ("segments", "color", "opacity", "canvas_sums", "removal_cost"):
        torch.testing.assert_close(getattr(got, name), getattr(want, name), rtol=1e-10, atol=1e-14)


@sweep("lane_width", [16, 1])
def test_the_number_of_threads_changes_no_bit(lane_width: int) -> None:
    scene, target, results = in_float32(stroked_scene(4, 12, HEIGHT, WIDTH)), torch.rand(HEIGHT, WIDTH, 3), []
    for threads in (1, 2, 3):
        renderer = make_renderer(Backend("cpu", lane_width), torch.float32, threads=threads)
        step = renderer.fit_step(scene, renderer.prepare_target(target), True)
        results.append([renderer.render(scene), *(v for v in vars(step).values() if v is not None)])
    for other in results[1:]:
        assert all(map(torch.equal, results[0], other))


def line_scene(rows: list[list[tuple[float, float]]], is_open: bool, width: float, cap: int, join: int) -> Scene:
    """Return a scene of one black opaque stroke over white."""
    segments = torch.tensor(rows, dtype=torch.float64)
    structure = Structure.of_loops([[len(rows)]], None, torch.tensor([is_open]))
    one = torch.ones(1, dtype=torch.float64)
    kinds = [torch.tensor([kind], dtype=torch.int32) for kind in (cap, join)]
    strokes = Strokes(width * one, *kinds, 4.0 * one)
    return Scene(
        segments,
        structure,
        torch.zeros(1, 3).double(),
        one,
        torch.ones(3).double(),
        torch.zeros(1).long(),
        strokes=strokes,
    )


def straight(*points: tuple[float, float]) -> list[list[tuple[float, float]]]:
    """Return rows of lines through ``points``, the last of them back to the first."""
    corners = np.array([*points, points[0]])
    return [[tuple(a), tuple(a + (b - a) / 3), tuple(a + (b - a) * 2 / 3)] for a, b in pairwise(corners)]


AREAS = {
    "a line with butt caps": (straight((5.2, 7.1), (25.2, 7.1)), True, BUTT, MITER, 20.0 * 4.0),
    "a line with square caps": (straight((5.2, 7.1), (25.2, 7.1)), True, SQUARE, MITER, 24.0 * 4.0),
    "a line with round caps": (straight((5.2, 7.1), (25.2, 7.1)), True, ROUND, MITER, 80.0 + math.pi * 4.0),
    "a dot with round caps": (straight((15.2, 17.1), (15.2, 17.1)), True, ROUND, MITER, math.pi * 4.0),
    "a dot with square caps": (straight((15.2, 17.1), (15.2, 17.1)), True, SQUARE, MITER, 16.0),
    "a dot with butt caps": (straight((15.2, 17.1), (15.2, 17.1)), True, BUTT, MITER, 0.0),
    "a square with miters": (straight((8, 8), (20, 8), (20, 20), (8, 20)), False, BUTT, MITER, 256.0 - 64.0),
    "a square with round joins": (
        straight((8, 8), (20, 8), (20, 20), (8, 20)),
        False,
        BUTT,
        ROUND,
        176.0 + 4 * math.pi,
    ),
}


@sweep("name", AREAS)
def test_a_stroke_has_its_area(name: str, backend: Backend) -> None:
    rows, is_open, cap, join, area = AREAS[name]
    image = make_renderer(backend).render(line_scene(rows, is_open, 4.0, cap, join).to(backend.device))
    assert (1.0 - image[..., 0]).sum().item() == pytest.approx(area, abs=3e-3 * area + 1e-9)


@sweep("bad", [math.nan, math.inf, 1e30])
@sweep("where", ["segments", "width"])
def test_a_stroke_that_is_not_finite_is_not_drawn(bad: float, where: str, backend: Backend) -> None:
    scene, renderer = stroked_scene(1, 3, HEIGHT, WIDTH), make_renderer(backend)
    values = dict(zip(VALUES, [value.clone() for value in values_of(scene)], strict=True))
    row = int(scene.structure.path_first_segment[1])
    values[where][row if where == "segments" else 1] = bad
    wild = with_values(scene, list(values.values())).to(backend.device)
    rest = scene.select(torch.tensor([0, 2])).to(backend.device)
    assert torch.equal(renderer.render(wild), renderer.render(rest))
    got = renderer.adjoint(wild, torch.ones(HEIGHT, WIDTH, 3, dtype=torch.float64, device=backend.device))
    assert not got.width[1].any() and got.segments.isfinite().all()


def test_unknown_caps_and_joins_are_refused() -> None:
    scene = stroked_scene(1, 3, HEIGHT, WIDTH)
    for name in ("cap", "join"):
        wrong = replace(scene.strokes, **{name: torch.full_like(scene.strokes.cap, 7)})
        with pytest.raises(InputError, match=rf"strokes\.{name} must be 0 .* got 7"):
            warpvec.render(replace(scene, strokes=wrong), HEIGHT, WIDTH)
