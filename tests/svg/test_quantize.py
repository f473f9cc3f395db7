"""A quantized scene moves nothing by more than half a step, and only once."""

from __future__ import annotations

from dataclasses import replace

import pytest
import torch
from scenes import with_points
from svg_files import make_scene

from warpvec.svg.quantize import quantize


@pytest.mark.parametrize(("precision", "handle_step"), [(0, 1.0), (1, 0.1), (2, 0.1), (3, 0.01)])
def test_quantize_moves_nothing_by_more_than_half_a_step(precision, handle_step):
    scene = make_scene(300)
    quantized = quantize(scene, precision)
    moved = (quantized.points - scene.points).abs().unflatten(1, (-1, 3))
    # 7e-5: the spacing of float32 at 512, in which both ends are stored.
    assert moved[:, :, 0].max() <= 0.5 * 10**-precision + 7e-5
    assert moved[:, :, 1:].max() <= 0.5 * handle_step + 7e-5
    assert (quantized.color - scene.color).abs().max() <= 0.5 / 255 + 1e-7
    assert (quantized.opacity - scene.opacity).abs().max() <= 0.005 + 1e-7
    assert (quantized.background - scene.background).abs().max() <= 0.5 / 255 + 1e-7


def test_handles_are_a_whole_number_of_tenths_from_the_start_of_their_segment():
    points = (quantize(make_scene(300), 2).points.double() * 100).round().long().unflatten(1, (-1, 3))
    assert ((points[:, :, 1:] - points[:, :, :1]) % 10 == 0).all()
    assert (points[:, :, 0] % 10 != 0).any()


@pytest.mark.parametrize("size", [(768, 512), (30000, 20000)])
@pytest.mark.parametrize("precision", [0, 2, 3])
def test_quantizing_twice_changes_nothing(precision, size):
    # On the large canvas three decimals are finer than float32, whose spacing is 0.002 there.
    once = quantize(make_scene(300, size=size), precision)
    twice = quantize(once, precision)
    for name in ("points", "color", "opacity", "background", "generation"):
        assert torch.equal(getattr(once, name), getattr(twice, name)), name


def test_quantize_clamps_and_keeps_dtype():
    scene = make_scene(2)
    scene = replace(
        scene, color=scene.color.double() + 2, opacity=scene.opacity * 0 + 1.7, background=scene.color[0] - 2
    )
    quantized = quantize(scene, 2)
    assert quantized.color.dtype == torch.float64
    assert (quantized.color == 1).all()
    assert (quantized.opacity == 1).all()
    assert (quantized.background == 0).all()


@pytest.mark.parametrize("name", ["segments", "color", "opacity", "background"])
@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_a_scene_that_is_not_finite_is_refused(name, value):
    scene = make_scene(5)
    broken = getattr(scene, name).clone()
    broken.view(-1)[-1] = value
    with pytest.raises(ValueError, match=f"{name} of a scene"):
        quantize(replace(scene, **{name: broken}), 2)


def test_coordinates_beyond_exact_counting_are_refused():
    scene = make_scene(5)
    with pytest.raises(ValueError, match="2\\*\\*53"):
        quantize(with_points(scene, scene.points * 1e20), 2)
