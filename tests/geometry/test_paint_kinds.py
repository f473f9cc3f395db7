"""Kinds of gradients: derivatives, files, scaling, and that an unknown kind is refused everywhere."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
import torch
from compound import scene_of_loops
from numpy.typing import NDArray
from scenes import circle

import warpvec
from warpvec.errors import InputError
from warpvec.geometry.gradients import Gradients
from warpvec.geometry.paints.kind import GradientKind
from warpvec.geometry.paints.linear import Linear
from warpvec.geometry.paints.registry import ELLIPTIC, FLAT, KINDS, LINEAR, kind_of
from warpvec.geometry.scene import Scene
from warpvec.geometry.stops import Stops
from warpvec.kernels import gradients as kernel_gradients
from warpvec.kernels.lanes import make_lanes
from warpvec.polish.paint_slopes import PaintSlopes
from warpvec.rendering.launch import start_warp
from warpvec.rendering.stages.pixel_slopes import HitSlopes
from warpvec.svg.quantize import quantize
from warpvec.svg.read import read_svg
from warpvec.svg.write import write_svg

UNKNOWN = 77

GEOMETRY = np.array([11.3, 7.1, 25.2, 19.7, 8.4])
"""A gradient of any kind: two points, a centre and a radius, or a centre, an axis and a radius."""

kinds = pytest.mark.parametrize("number", KINDS, ids=[kind.name for kind in KINDS.values()])


def places(count: int = 50) -> NDArray[np.float64]:
    return np.random.default_rng(0).uniform(0.0, 40.0, (2, count))


def scene_with(number: int, geometry: NDArray[np.float64] = GEOMETRY) -> Scene:
    """Return a scene of one path with a gradient, in float32."""
    scene = scene_of_loops([[circle(20.0, 16.0, 12.0)]])
    numbers = torch.from_numpy(geometry)[None].to(scene.segments)
    end_color = torch.tensor([[0.2, 0.6, 0.8]]).to(scene.segments)
    needs_stops = number in KINDS and KINDS[number].needs_stops
    stops = replace(Stops.two(end_color), breadth=numbers[:, 4]) if needs_stops else None
    paints = Gradients(torch.tensor([number], dtype=torch.int32), numbers[:, :4], end_color, stops)
    return Scene(**{**vars(scene), "gradients": paints})


@kinds
def test_the_slopes_are_those_of_finite_differences(number: int) -> None:
    kind, (x, y), step = KINDS[number], places(), 1e-6
    want = [
        (kind.share(GEOMETRY + change, x, y) - kind.share(GEOMETRY - change, x, y)) / (2 * step)
        for change in step * np.eye(5)
    ]
    np.testing.assert_allclose(kind.slopes(GEOMETRY, x, y), want, rtol=1e-6, atol=1e-8)
    assert np.abs(want).max(1).min(initial=1.0, where=np.arange(5) < kind.number_count) > 1e-3


@kinds
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_many_geometries_at_once_give_the_shares_of_each(number: int, dtype: type) -> None:
    kind, (x, y) = KINDS[number], places().astype(dtype)
    many = (GEOMETRY[:, None] * np.linspace(0.8, 1.3, len(x))).astype(dtype)
    want = [kind.share(one, x[i : i + 1], y[i : i + 1])[0] for i, one in enumerate(many.T)]
    got = kind.share(many, x, y)
    assert got.dtype == dtype
    np.testing.assert_array_equal(got, want)


def moved_by(kind: GradientKind, geometry: torch.Tensor) -> tuple[torch.Tensor, Callable[..., NDArray[np.float64]]]:
    return kind.moved(geometry, 3.5, -2.25), lambda x, y: np.stack([x + 3.5, y - 2.25])


def scaled_by(kind: GradientKind, geometry: torch.Tensor) -> tuple[torch.Tensor, Callable[..., NDArray[np.float64]]]:
    return kind.scaled(geometry, 1.75, 1.75), lambda x, y: 1.75 * np.stack([x, y])


@kinds
@pytest.mark.parametrize("change", [moved_by, scaled_by])
def test_a_gradient_moves_and_grows_with_its_places(number: int, change: Callable[..., object]) -> None:
    kind, (x, y) = KINDS[number], places()
    changed, places_of = change(kind, torch.from_numpy(GEOMETRY)[None])
    np.testing.assert_allclose(kind.share(changed[0].numpy(), *places_of(x, y)), kind.share(GEOMETRY, x, y), atol=1e-12)


@kinds
def test_a_part_begins_and_ends_where_it_is_asked_to(number: int) -> None:
    kind, (x, y) = KINDS[number], places()
    start = 0.25 if kind.has_free_start else 0.0
    part = np.array(kind.between(tuple(GEOMETRY), start, 1.5))
    want = (kind.share(GEOMETRY, x, y) - start) / (1.5 - start)
    np.testing.assert_allclose(kind.share(part, x, y), want, atol=1e-12)


@kinds
def test_a_file_states_the_gradient_that_is_read_from_it(number: int) -> None:
    scene = quantize(scene_with(number), 2)
    got = read_svg(write_svg(scene, 40, 32)).scene
    assert got.gradients is not None and got.gradients.kind.tolist() == [number]
    want = scene.gradients.whole_geometry.float()
    torch.testing.assert_close(got.gradients.whole_geometry, want, rtol=0, atol=0)
    assert write_svg(got, 40, 32) == write_svg(scene, 40, 32)


def test_an_ellipse_is_stated_by_the_circle_about_its_centre_or_as_files_of_before_do() -> None:
    kind, numbers = KINDS[ELLIPTIC], ["70", "190.5", "60", "-30", "20.5"]
    attributes = kind.attributes(numbers)
    assert [attributes[side] for side in ("cx", "cy", "r")] == ["70", "190.5", "67.1"]
    matrix = "matrix(60 -30 9.1679 18.3358 70 190.5)"
    of_before = {"cx": "0", "cy": "0", "r": "1", "gradientTransform": matrix}
    assert kind.numbers(attributes) == kind.numbers(of_before) == numbers
    assert kind.numbers({**of_before, "gradientTransform": matrix.replace("9.1", "9.2")}) == []  # a skewed one


@kinds
def test_a_gradient_too_far_to_be_written_becomes_flat(number: int) -> None:
    far = GEOMETRY.copy()
    far[:2] -= 5e15
    far[2:4] += 5e15
    shown = quantize(scene_with(number, far), 2)
    assert shown.gradients is None
    share = kind_of(number).share(far, *scene_with(number).segments[0, 0].double().numpy()[:, None]).clip(0, 1)[0]
    want = torch.lerp(scene_with(number).color.float(), torch.tensor([[0.2, 0.6, 0.8]]), float(share))
    torch.testing.assert_close(shown.color.float(), want.float(), rtol=0, atol=0.51 / 255)


@kinds
def test_a_gradient_without_extent_is_not_drawn(number: int) -> None:
    drawn = torch.tensor(GEOMETRY.tolist())
    place = drawn[:2].tolist()
    is_point = torch.tensor([*place, *place, 0.0] if number == LINEAR else [*place, 0.0, 0.0, 0.0])
    geometry = torch.stack([drawn, is_point, torch.full((5,), torch.nan), torch.full((5,), torch.inf)])
    assert KINDS[number].is_drawn(geometry).tolist() == [True, False, False, False]


def test_flat_is_no_kind_of_gradient() -> None:
    with pytest.raises(InputError, match=r"gradients.kind must be 0 \(flat\), 1 \(linear\).*0"):
        kind_of(FLAT)


WHOLE_TILE = HitSlopes(
    (0, 1), *(np.zeros(1, np.int64) for _ in range(3)), np.zeros(1, np.bool_),
    np.ones((1, 256), np.float32), np.zeros((1, 4, 256), np.float32),
)  # fmt: skip


@pytest.mark.parametrize(
    "use",
    [
        lambda scene: write_svg(scene, 40, 32),
        lambda scene: PaintSlopes(scene, 40, 32, np.arange(9)).add(WHOLE_TILE),
        lambda scene: scene.gradients.scaled(2.0, 2.0),
        lambda scene: warpvec.render(scene, 32, 40),
    ],
    ids=["writer", "slopes", "scaled", "kernels"],
)
def test_an_unknown_kind_is_no_linear_one(use: Callable[[Scene], object]) -> None:
    with pytest.raises(InputError, match="gradients.kind"):
        use(scene_with(UNKNOWN))


def test_an_unknown_element_is_not_read_as_a_gradient() -> None:
    text = write_svg(quantize(scene_with(1), 2), 40, 32)
    assert read_svg(text).scene.gradients is not None
    assert read_svg(text.replace("linearGradient", "conicGradient")).scene.gradients is None


def test_a_kind_without_device_functions_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    import warp as wp

    class Conic(Linear):
        name = "conic"

    start_warp()
    monkeypatch.setitem(KINDS, UNKNOWN, Conic())
    with pytest.raises(NotImplementedError, match="conic"):
        kernel_gradients.make_functions.__wrapped__(make_lanes(1, wp.float64))


@kinds
def test_the_registry_and_the_kernels_know_the_same_kinds(number: int) -> None:
    assert (number in kernel_gradients.KNOWN) != KINDS[number].needs_stops
    assert set(kernel_gradients.KNOWN) <= set(KINDS)


@kinds
def test_the_form_gives_the_share_and_its_adjoint(number: int) -> None:
    kind, (x, y) = KINDS[number], places()
    geometry = torch.from_numpy(GEOMETRY)[None].requires_grad_()
    origin_x, origin_y, a, b, c = kind.form(geometry)[0]
    qx, qy = torch.from_numpy(x) - origin_x, torch.from_numpy(y) - origin_y
    share = (a * qx**2 + 2 * b * qx * qy + c * qy**2).sqrt() if kind.is_root else a * qx + b * qy
    np.testing.assert_allclose(share.detach().numpy(), kind.share(GEOMETRY, x, y), rtol=1e-12, atol=1e-12)
    adj_form = torch.randn(1, 5, dtype=torch.float64)
    (want,) = torch.autograd.grad(kind.form(geometry), geometry, adj_form)
    torch.testing.assert_close(kind.form_adjoint(geometry.detach(), adj_form), want)
