"""Forms in files: written as elements, drawn as their rows are, read back exactly, refused where they are broken."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
import torch

from warpvec.geometry.forms.registry import CIRCLE, ELLIPSE, OUTLINE, RECT, ROUND_RECT, form_of
from warpvec.geometry.path_forms import Forms, is_used
from warpvec.geometry.scene import Scene
from warpvec.geometry.softness import Softness
from warpvec.geometry.structure import Structure
from warpvec.image.metrics import psnr
from warpvec.svg.document import parse_svg
from warpvec.svg.measure import draw, file_facts
from warpvec.svg.minify import write_minified
from warpvec.svg.quantize import quantize
from warpvec.svg.read import read_svg
from warpvec.svg.write import write_svg

NUMBERS = torch.tensor(
    [
        [20.123, 30.456, 12.347, 0.0, 0.0, 0.0],
        [60.0, 30.5, 18.0, 7.123, 0.4321, 0.0],
        [95.5, 30.0, 11.0, 21.25, 0.0, 0.0],
        [20.0, 75.0, 20.01, 14.3, -0.61, 0.0],
        [60.0, 75.0, 24.01, 14.03, 0.0, 7.02],
        [95.0, 75.0, 22.0, 30.0, 0.2, 5.0],
    ]
)
KINDS = (CIRCLE, ELLIPSE, RECT, RECT, ROUND_RECT, ROUND_RECT)


def scene_of_forms(transparent: bool = False, kinds: tuple[int, ...] = KINDS) -> Scene:
    """A scene with some of all forms, and an outline of three lines on top."""
    kind = torch.tensor([*kinds, OUTLINE], dtype=torch.int32)
    parameters = torch.cat([NUMBERS[: len(kinds)], torch.zeros(1, 6)])
    forms = Forms(kind, torch.where(is_used(parameters, kind), parameters, 0.0))
    masks = [form_of(number).is_line for number in kinds]
    is_line = torch.tensor([*(line for mask in masks for line in mask), True, True, True])
    counts = [[len(mask)] for mask in masks]
    structure = Structure.of_loops([*counts, [3]], is_line)
    segments = torch.zeros(structure.segment_count, 3, 2)
    corners = torch.tensor([[5.0, 5.0], [15.0, 5.0], [5.0, 15.0]])
    following = corners.roll(-1, 0)
    segments[-3:] = torch.stack([corners, (2 * corners + following) / 3, (corners + 2 * following) / 3], 1)
    count = len(kind)
    color, opacity = torch.rand(count, 3), torch.linspace(0.4, 1.0, count)
    background = torch.zeros(3) if transparent else torch.ones(3)
    scene = Scene(segments, structure, color, opacity, background, torch.zeros(count, dtype=torch.int64), transparent)
    return scene.with_forms(forms)


@pytest.mark.parametrize("transparent", [False, True])
@pytest.mark.parametrize("precision", [0, 2, 4])
def test_a_file_with_forms_is_read_exactly(precision: int, transparent: bool) -> None:
    scene = scene_of_forms(transparent)
    text = write_svg(scene, 120, 100, precision=precision)
    for word in ("<circle", "<ellipse", "<rect", 'rx="', "rotate("):
        assert word in text
    radii = re.findall(r'<rect[^>]* rx="([^"]*)" ry="([^"]*)"', text)
    assert radii and all(across == down for across, down in radii)
    loaded = read_svg(text)
    assert loaded.precision is not None and loaded.scene.forms is not None
    found, want = loaded.scene, quantize(scene, precision)
    assert want.forms is not None and found.forms.kind.tolist() == want.forms.kind.tolist()
    assert torch.equal(found.forms.parameters, want.forms.parameters)
    assert torch.equal(found.segments, want.segments)
    assert write_svg(found, 120, 100, precision=precision) == text
    old = re.sub(r'(<rect[^>]*) ry="[^"]*"', r"\1", text)  # files of before state the radius of corners once
    assert old != text and write_svg(read_svg(old).scene, 120, 100, precision=precision) == text


@pytest.mark.parametrize("minified", [False, True])
def test_no_soft_form_has_a_transform(minified: bool) -> None:
    scene = scene_of_forms()
    soft = replace(scene, softness=Softness(torch.full((len(scene),), 1.5)))

    def written(each: Scene) -> str:
        return write_minified(each, 120, 100, ("240", "200")) if minified else write_svg(each, 120, 100)

    text = written(soft)
    assert text.count(" filter=") == len(scene) and "<circle" in text
    assert not re.search("<[^>]* filter=[^>]* transform=", text) and "transform=" in written(scene)
    assert written(read_svg(text).scene) == text


@pytest.mark.parametrize("turn", ["rotate(25 65 60)", "rotate(25,65,60)"])  # as older versions wrote it, and others
def test_a_gradient_is_turned_once_with_its_form(turn: str) -> None:
    text = (
        '<svg xmlns="http://www.w3.org/2000/svg" width="128" height="128" viewBox="0 0 128 128"><defs>'
        '<linearGradient id="g1" gradientUnits="userSpaceOnUse" x1="20" y1="40" x2="120" y2="90">'
        '<stop offset="0" stop-color="#c22"/><stop offset="1" stop-color="#06c"/></linearGradient></defs>'
        f'<g><rect fill="url(#g1)" x="20" y="30" width="90" height="60" rx="10" transform="{turn}"/></g></svg>'
    )
    again = write_svg(read_svg(text).scene, 128, 128)
    assert psnr(draw(again, 128, 128), draw(text, 128, 128)) > 45.0  # 37 if it is turned twice or not at all


def test_a_minified_file_with_forms_is_read_exactly_and_has_short_words() -> None:
    scene = scene_of_forms().scaled(20.0)
    text = write_minified(scene, 2400, 2000, ("120", "100"))
    assert text.count("<rect") == 4  # the background, a tilted one, and two with corners; a level one is a path
    loaded = read_svg(text)
    assert loaded.minified and write_minified(loaded.scene, 2400, 2000, ("120", "100")) == text
    np.testing.assert_array_equal(draw(text, 120, 100), draw(write_svg(scene, 2400, 2000, precision=0), 120, 100))


def test_a_file_of_forms_alone_is_seen_as_minified() -> None:
    scene = scene_of_forms(transparent=True, kinds=(CIRCLE, ELLIPSE)).select(torch.tensor([0]))
    text = write_minified(scene, 120, 100, ("120", "100"))
    loaded = read_svg(text)
    assert loaded.minified and loaded.scene.is_uniform and loaded.scene.transparent


def test_resvg_draws_the_forms_as_their_rows() -> None:
    scene = scene_of_forms()
    with_forms, plain = (write_svg(each, 120, 100, precision=3) for each in (scene, scene.outlined()))
    assert "<circle" not in plain
    difference = draw(with_forms, 960, 800).astype(int) - draw(plain, 960, 800)
    assert np.abs(difference).max() < 60 and np.abs(difference).mean() < 0.02


def test_a_file_with_forms_is_drawn_in_this_process_and_its_segments_count() -> None:
    text = write_svg(scene_of_forms(), 120, 100)
    document = parse_svg(text)
    assert document.plain and 120 < document.reach() < 1000
    facts = file_facts(text)
    assert facts["segments"] == 4 * 4 + 8 * 2 + 3 and facts["paths"] == 7
    assert (facts["circles"], facts["ellipses"], facts["rects"]) == (1, 1, 4)
    assert facts["parameters"] == 3 + 4 + 4 * 6 + 4  # the line that closes the path is free


@pytest.mark.parametrize(
    "broken",
    [
        'cx="20.12" cy="30.46" r="-1"',
        'cx="999999999999999" cy="30" r="2"',
        'cx="20" cy="30" r="5%"',
        'cx="20" cy="30"',
        'cx="1" cy="2" r="3" stroke="#000"',
    ],
)
def test_a_form_that_we_never_write_is_read_as_anothers(broken: str) -> None:
    text = write_svg(scene_of_forms(), 120, 100)
    start = text.index("cx=")
    text = text[:start] + broken + text[text.index("/>", start) :]
    assert read_svg(text).precision is None


def test_a_corner_radius_has_room_and_lost_forms_become_outlines() -> None:
    scene = quantize(scene_of_forms().scaled(0.0001), 2)
    assert scene.forms is None
    rounded = quantize(scene_of_forms(), 2)
    radius, side = rounded.forms.parameters[4, 5], rounded.forms.parameters[4, 3]
    assert side == pytest.approx(14.03) and radius == pytest.approx(7.01)


FOREIGN = """<svg xmlns="http://www.w3.org/2000/svg" width="120" height="100" viewBox="0 0 60 50">
<g fill="#333"><circle cx="10" cy="10" r="10%"/><g transform="rotate(30 30 20) scale(1.5)">
<rect x="12" y="10" width="12" height="8" rx="2"/><ellipse cx="8" cy="18" rx="3" ry="5"/></g>
<g transform="matrix(1 0 0 2 0 0)"><circle cx="45" cy="6" r="4"/><rect x="30" y="2" width="5" height="4"/>
<rect x="52" y="2" width="6" height="4" rx="1"/></g><rect x="4" y="44" width="9" height="4" transform="skewX(-30)"/>
<circle cx="40" cy="40" r="4" transform="skewX(10)"/></g></svg>"""
"""Forms under transforms; two of them become none of ours: an uneven corner, and a skewed rectangle."""


def test_forms_of_other_programs_stay_forms_where_their_transform_allows_it() -> None:
    loaded = read_svg(FOREIGN)
    assert loaded.precision is None and loaded.scene.forms is not None
    kinds = [CIRCLE, ROUND_RECT, ELLIPSE, ELLIPSE, RECT, OUTLINE, OUTLINE, ELLIPSE]
    assert loaded.scene.forms.kind.tolist() == kinds
    text = write_svg(loaded.scene, 120, 100, precision=4)
    difference = draw(text, 480, 400, transparent=True).astype(int) - draw(FOREIGN, 480, 400, transparent=True)
    assert (
        np.abs(difference).max() <= 64 and np.abs(difference).mean() < 0.01
    )  # resvg draws in steps of a quarter pixel


def test_a_scene_keeps_its_forms_in_a_dictionary_and_when_paths_are_chosen_or_joined() -> None:
    scene = scene_of_forms()
    again = Scene.from_dict(scene.to_dict())
    assert again.forms is not None and torch.equal(again.forms.parameters, scene.forms.parameters)
    chosen = scene.select(torch.tensor([6, 3]))
    assert chosen.forms is not None and chosen.forms.kind.tolist() == [OUTLINE, RECT]
    assert scene.select(torch.tensor([6])).forms is None
    joined = scene.select(torch.tensor([6])).joined(scene.prefix(1))
    assert joined.forms is not None and joined.forms.kind.tolist() == [OUTLINE, CIRCLE]
    moved = scene.moved(3.0, 4.0)
    torch.testing.assert_close(moved.segments, scene.segments + torch.tensor([3.0, 4.0]))
    assert scene.scaled(2.0, 1.0).outlined().forms is None
