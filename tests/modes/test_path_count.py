"""Goals in bytes: one fit, whose paths are those of a minified file."""

from __future__ import annotations

import re
import signal
import zlib
from typing import Any

import numpy as np
import pytest
import torch
from numpy.typing import NDArray
from PIL import Image

import warpvec
from warpvec.config.presets import make_config
from warpvec.errors import InputError
from warpvec.fit.state import Saving
from warpvec.goals import search
from warpvec.goals.goal import make_goal
from warpvec.modes.choice import draw_picture
from warpvec.modes.photo import Photo
from warpvec.modes.request import Request
from warpvec.svg.document import parse_svg
from warpvec.svg.measure import draw
from warpvec.svg.read import read_svg

QUICK: dict[str, Any] = {"iterations": 80, "initial_curves": 8, "inflation_gap": 4, "device": "cpu", "threads": 1}
SIZE = 6_000


def _photo(width: int = 72, height: int = 48) -> NDArray[np.uint8]:
    """Return waves of colour with a soft texture."""
    y, x = np.mgrid[0:height, 0:width] / width
    waves = [np.sin(9 * x + 5 * y), np.cos(13 * x * y + 2), np.sin(21 * x * x - 8 * y)]
    noise = np.random.default_rng(2).normal(0, 6, (height, width, 3))
    return np.clip(128 + 90 * np.stack(waves, 2) + noise, 0, 255).astype(np.uint8)


@pytest.fixture(scope="module")
def result() -> warpvec.Result:
    return warpvec.vectorize(_photo(), max_bytes=SIZE, **QUICK)


def test_one_fit_uses_nearly_all_bytes(result: warpvec.Result) -> None:
    assert result.drawing.goal_facts is not None
    assert len(result.drawing.goal_facts["trials"]) == 1
    assert result.metrics["iterations"] <= 1.5 * QUICK["iterations"]
    assert 0.97 * SIZE <= len(result.svg().encode()) <= SIZE


@pytest.mark.parametrize(("most", "limit"), [(9, 9), (None, None)])
def test_the_facts_say_if_the_number_of_paths_was_the_limit(most: int | None, limit: int | None) -> None:
    more = {} if most is None else {"curves": most}
    found = warpvec.vectorize(_photo(36, 24), max_bytes=1500, **{**QUICK, "iterations": 20}, **more)
    assert found.goal_facts is not None and found.goal_facts["curves_max"] == limit


def test_the_last_iterations_draw_what_is_written(result: warpvec.Result) -> None:
    step = result.encoding.grid_step
    assert step is not None
    ticks = result.drawing.fitted.segments / torch.tensor(step)
    is_line = result.drawing.fitted.structure.is_line
    assert is_line is not None
    assert (ticks - ticks.round())[~is_line].abs().max() < 1e-3
    levels = 255 * result.drawing.fitted.color
    assert torch.allclose(levels, levels.round(), atol=1e-4)


def test_paths_share_an_opacity_and_close_by_lines(result: warpvec.Result) -> None:
    text = result.svg()
    assert len(re.findall("fill-opacity", text)) == 1
    assert " l" not in text and "h" not in "".join(re.findall(r' d="([^"]*)"', text))
    is_line = read_svg(text).scene.structure.is_line
    assert is_line is not None and int(is_line.sum()) > 0.8 * len(result.scene)


def test_the_file_has_the_true_size_and_plain_content(result: warpvec.Result) -> None:
    document = parse_svg(result.svg())
    assert (document.root["width"], document.root["height"]) == ("72", "48")
    assert document.plain and "\n" not in result.svg()
    assert draw(result.svg()).shape == (48, 72, 3)


def test_a_size_with_a_unit_is_that_of_the_photo() -> None:
    small = warpvec.vectorize(_photo(36, 24), max_bytes=2_000, size="50%", **QUICK)
    assert 'width="18" height="12"' in small.svg()


def test_a_photo_that_is_reduced_for_the_fit_gets_no_finer_units() -> None:
    large = warpvec.vectorize(_photo(720, 480), max_bytes=2_000, fit_size=36, **QUICK)
    root = parse_svg(large.svg()).root
    rows, columns = (int(side) for side in root["viewBox"].split()[:1:-1])
    assert (root["width"], root["height"]) == ("720", "480")
    assert 72 < columns < 720 and 2 * columns == 3 * rows
    assert large.file_psnr > large.history[-1]["psnr"] - 4.0
    assert warpvec.refine(_photo(720, 480), large.svg().encode(), iterations=0).svg() == large.svg()


def test_a_second_fit_has_the_same_bytes(result: warpvec.Result) -> None:
    assert warpvec.vectorize(_photo(), max_bytes=SIZE, **{**QUICK, "threads": 2}).svg() == result.svg()


def test_refining_by_no_iterations_changes_nothing(result: warpvec.Result) -> None:
    text = result.svg()
    assert warpvec.refine(_photo(), text.encode(), iterations=0).svg() == text


def test_levels_of_detail_stay_in_their_groups() -> None:
    text = warpvec.vectorize(_photo(36, 24), 20, minify=True, lod=True, **QUICK).svg()
    assert text.count("<g") > 2
    assert warpvec.refine(_photo(36, 24), text.encode(), iterations=0).svg() == text


def test_refining_keeps_the_form_and_the_opacity(result: warpvec.Result) -> None:
    refined = warpvec.refine(_photo(), result.svg().encode(), iterations=3, device="cpu", threads=1)
    text = refined.svg()
    assert refined.file_psnr >= result.file_psnr
    assert len(re.findall("fill-opacity", text)) == 1 and "metadata" not in text
    assert len(text) < 1.03 * SIZE


def test_the_long_form_needs_one_fit_too() -> None:
    long = warpvec.vectorize(_photo(), max_bytes=SIZE, minify=False, **QUICK)
    assert long.drawing.goal_facts is not None and len(long.drawing.goal_facts["trials"]) == 1
    assert 0.9 * SIZE <= len(long.svg().encode()) <= SIZE
    assert "<metadata>" in long.svg() and 'viewBox="0 0 72 48"' in long.svg()


def test_gzipped_bytes_are_used() -> None:
    packed = warpvec.vectorize(_photo(), max_bytes=3_000, gzip=True, **QUICK)
    assert 0.95 * 3_000 <= packed.metrics["gzip_bytes"] <= 3_000
    other = zlib.compressobj(9, zlib.DEFLATED, 31, 9)  # as the command gzip does it
    assert len(other.compress(packed.svg().encode()) + other.flush()) <= 3_000


def test_given_cubics_per_path_are_kept() -> None:
    few = {**QUICK, "iterations": 20, "fixed_segments": True}
    rich, kept = (warpvec.vectorize(_photo(), max_bytes=SIZE, **few, **given) for given in ({}, {"segments": 3}))
    counts = [each.config.segments for each in (rich, kept)]
    assert counts == [2, 3]
    assert len(kept.scene) < len(rich.scene)


def test_ctrl_c_while_paths_are_cut_loses_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    cut = search._cut

    def interrupted_cut(*values: Any) -> Any:
        signal.raise_signal(signal.SIGINT)
        return cut(*values)

    monkeypatch.setattr(search, "_cut", interrupted_cut)
    found = warpvec.vectorize(_photo(36, 24), max_bytes=2_000, **{**QUICK, "iterations": 10})
    assert found.interrupted and len(found.svg().encode()) <= 2_000


@pytest.mark.parametrize("name", ["checkpoint", "resume"])
def test_the_state_of_a_fit_to_a_size_is_refused(name: str) -> None:
    resume: Any = object()  # never looked at
    photo = Photo(saving=Saving(1, lambda _: None)) if name == "checkpoint" else Photo(resume=resume)
    request = Request.of(np.zeros((8, 8, 3), np.float32), make_config(**QUICK), make_goal(max_bytes=2_000))
    with pytest.raises(InputError, match=f"^{name} cannot be combined with max_bytes"):
        draw_picture(request, photo)


def test_the_given_number_of_paths_is_not_exceeded() -> None:
    few = warpvec.vectorize(_photo(), 12, max_bytes=SIZE, **QUICK)
    assert len(few.scene) <= 12


def test_soft_edges_of_a_transparent_picture_keep_their_own_opacity() -> None:
    alpha = np.clip(np.linspace(-80, 340, 72), 0, 255).astype(np.uint8)[None].repeat(48, 0)
    image = Image.fromarray(np.dstack([_photo(), alpha]))
    clear = warpvec.vectorize(image, max_bytes=SIZE, mode="photo", **QUICK)
    assert len(set(clear.scene.opacity.tolist())) > 3
    assert len(clear.svg().encode()) <= SIZE


def test_a_minified_drawing_of_flat_art_keeps_its_quality() -> None:
    image = np.full((96, 96, 3), 255, np.uint8)
    y, x = np.mgrid[0:96, 0:96]
    image[(x - 48) ** 2 + (y - 48) ** 2 < 900] = (200, 30, 40)
    plain, short = (warpvec.vectorize(image, mode="flat", minify=minify, threads=1) for minify in (False, True))
    assert len(short.svg()) < 0.7 * len(plain.svg())
    assert short.file_psnr > plain.file_psnr - 1.0
    assert warpvec.refine(image, short.svg().encode(), iterations=0).svg() == short.svg()
