"""The short form of a file saves bytes, draws the same, and is read back exactly."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
import torch

from warpvec.geometry.gradients import Gradients
from warpvec.geometry.paints.registry import FLAT, LINEAR
from warpvec.geometry.scene import Scene
from warpvec.geometry.structure import Structure
from warpvec.svg.measure import draw
from warpvec.svg.minify import write_minified
from warpvec.svg.quantize import quantize
from warpvec.svg.read import read_svg
from warpvec.svg.write import write_svg

WIDTH, HEIGHT, UNITS = 48, 32, 4
SIDES = (str(WIDTH), str(HEIGHT))


def _scene(count: int = 12, *, has_lines: bool = True, seed: int = 3) -> Scene:
    """Return random paths of two cubics, and a line if there are lines, in quarters of a pixel."""
    generator = torch.Generator().manual_seed(seed)
    rows = 3 if has_lines else 2
    segments = torch.randint(0, 128, (count * rows, 3, 2), generator=generator).float()
    loops = torch.arange(count + 1, dtype=torch.int32)
    is_line = (torch.arange(count * rows) % rows == 2) if has_lines else None
    structure = Structure(loops * rows, loops, is_line)
    color = torch.randint(0, 256, (count, 3), generator=generator) / 255.0
    opacity = torch.full((count,), 0.7)
    background = torch.tensor([0.2, 0.4, 0.6])
    return Scene(segments, structure, color, opacity, background, torch.arange(count) // 4)


def _text(scene: Scene, **options: bool) -> str:
    return write_minified(scene, UNITS * WIDTH, UNITS * HEIGHT, SIDES, **options)


@pytest.mark.parametrize("has_lines", [True, False])
def test_is_read_back_exactly(has_lines: bool) -> None:
    text = _text(_scene(has_lines=has_lines))
    loaded = read_svg(text)
    assert loaded.minified and (loaded.width, loaded.height) == (UNITS * WIDTH, UNITS * HEIGHT)
    assert _text(loaded.scene) == text


def test_draws_what_the_long_form_draws_at_its_true_size() -> None:
    scene = _scene()
    long = write_svg(scene, UNITS * WIDTH, UNITS * HEIGHT, precision=0, sides=SIDES)
    short = _text(scene)
    assert np.array_equal(draw(short, WIDTH, HEIGHT), draw(long, WIDTH, HEIGHT))
    assert len(short) < 0.8 * len(long)


def test_a_closing_line_costs_nothing() -> None:
    scene = _scene(1)
    data = re.findall(r' d="([^"]*)"', _text(scene))[0]
    assert re.fullmatch(r"M[^a-z]*c[^a-z]*z", data)
    assert len(re.findall(r"-?\d+", data)) == 2 + 2 * 6


def test_an_opacity_of_its_own_is_stated() -> None:
    scene = _scene()
    opacity = scene.opacity.clone()
    opacity[3] = 0.25
    text = _text(replace(scene, opacity=opacity))
    assert re.findall(r'fill-opacity="([^"]*)"', text) == [".7", ".25"]
    assert torch.equal(read_svg(text).scene.opacity, quantize(replace(scene, opacity=opacity), 0).opacity)
    opacity[5] = 1.0  # some programs keep the opacity of the group, whatever a path says
    text = _text(replace(scene, opacity=opacity))
    assert "<g" not in text and re.findall(r'fill-opacity="([^"]*)"', text) == 3 * [".7"] + [".25", ".7"] + 6 * [".7"]
    assert torch.equal(read_svg(text).scene.opacity, quantize(replace(scene, opacity=opacity), 0).opacity)


@pytest.mark.parametrize(("usual", "of_stops"), [(0.7, []), (1.0, [".25", ".25"])])
def test_stops_state_the_opacity_of_a_path_that_is_in_no_group(usual: float, of_stops: list[str]) -> None:
    scene = _scene()
    is_special = torch.arange(12) == 4
    ends = torch.tensor([[0.0, 0.0, 50.0, 30.0]]).repeat(12, 1)
    gradients = Gradients(torch.where(is_special, LINEAR, FLAT).int(), ends, 1.0 - scene.color)
    scene = replace(scene, gradients=gradients, opacity=torch.where(is_special, 0.25, usual))
    text = _text(scene)
    assert ("<g " in text) == (usual < 1.0)
    assert re.findall(r'stop-opacity="([^"]*)"', text) == of_stops
    loaded = read_svg(text).scene
    assert torch.equal(loaded.opacity, quantize(scene, 0).opacity) and _text(loaded) == text
    layered = write_svg(scene, UNITS * WIDTH, UNITS * HEIGHT, precision=0)
    assert re.findall(r'stop-opacity="([^"]*)"', layered) == [".25", ".25"]
    assert not re.search(r'"url[^>]*fill-opacity', layered)
    np.testing.assert_allclose(draw(text, WIDTH, HEIGHT).astype(int), draw(layered, WIDTH, HEIGHT), atol=1)


def test_opaque_paths_need_no_group() -> None:
    text = _text(replace(_scene(), opacity=torch.ones(12)))
    assert "<g" not in text and "opacity" not in text
    assert _text(read_svg(text).scene) == text


@pytest.mark.parametrize(("segments", "has_group"), [(4, True), (400, False)])
def test_a_group_states_an_opacity_only_where_it_saves_bytes(segments: int, has_group: bool) -> None:
    waves = torch.rand(2, 3 * segments, 2, generator=torch.Generator().manual_seed(1))
    scene = Scene.uniform(
        40.0 * waves, torch.zeros(2, 3), torch.full((2,), 0.7), torch.zeros(3), torch.zeros(2, dtype=torch.int64)
    )
    text = _text(scene)
    assert ("<g" in text) == has_group
    assert _text(read_svg(text).scene) == text


def test_layers_are_kept_on_request() -> None:
    text = _text(_scene(), keeps_layers=True)
    loaded = read_svg(text)
    assert loaded.scene.generation.tolist() == _scene().generation.tolist()
    assert _text(loaded.scene, keeps_layers=True) == text


def test_handles_that_mirror_are_implied() -> None:
    scene = _scene(3, has_lines=False)
    segments = scene.segments.clone()
    segments[3, 1] = 2 * segments[3, 0] - segments[2, 2]
    text = _text(replace(scene, segments=segments))
    assert len(re.findall(r"\ds", text)) == 1
    assert torch.equal(read_svg(text).scene.segments, quantize(replace(scene, segments=segments), 0).segments)
