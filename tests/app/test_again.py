"""An edited drawing is fitted again: locked paths stay, and deleted ones are filled in from around them."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from io import BytesIO

import numpy as np
import pytest
from PIL import Image

from warpvec.app import fitting
from warpvec.app.fitting import run_job
from warpvec.app.messages import FitJob
from warpvec.app.settings import FitSettings
from warpvec.drawing.drawing import Drawing
from warpvec.errors import InputError
from warpvec.modes.flat import KnownOutlines
from warpvec.modes.request import Request
from warpvec.polish.erasing import erase, hole_of
from warpvec.svg.description import description_of
from warpvec.svg.measure import draw
from warpvec.watch.watch import Watch

pytestmark = pytest.mark.slow

SIDE = 48


def svg(*paths: str) -> str:
    inner = "\n".join(paths)
    box = f'width="{SIDE}" height="{SIDE}" viewBox="0 0 {SIDE} {SIDE}"'
    return f'<svg xmlns="http://www.w3.org/2000/svg" {box}>\n{inner}\n</svg>\n'


def square(x: float, side: float, fill: str) -> str:
    return f'<path fill="{fill}" d="M{x} {x}h{side}v{side}h-{side}z"/>'


BACKGROUND = f'<rect id="background" width="{SIDE}" height="{SIDE}" fill="#3060a0"/>'


def picture(*paths: str) -> bytes:
    stream = BytesIO()
    Image.fromarray(draw(svg(*paths))).save(stream, "PNG")
    return stream.getvalue()


PAPER = f'<path fill="#3060a0" d="M0 0h{SIDE}v{SIDE}h-{SIDE}z"/>'
TRUE = square(10, 20, "#e04020")


def again(mode: str = "flat", **more: object) -> tuple[str, list[str]]:
    """Fit a drawing again; return the text and the data of its paths."""
    job = FitJob(1, picture(PAPER, TRUE), "x", FitSettings({"mode": mode}), keeps_paths=True, **more)  # type: ignore[arg-type]
    found = run_job(job, lambda kind, facts: None, Watch(), 1)
    text = found["svg"]
    return text, re.findall(r'<path[^>]* d="([^"]*)"', text)


def color_at(text: str, x: int, y: int) -> tuple[int, ...]:
    return tuple(int(level) for level in draw(text)[y, x])


def test_free_paths_move_to_the_picture_and_locked_ones_stay() -> None:
    edited = svg(PAPER, square(9, 21, "#20c040"))
    free, _ = again(start=edited)
    assert np.abs(np.subtract(color_at(free, 20, 20), (0xE0, 0x40, 0x20))).max() <= 2
    kept, paths = again(start=edited, locked=(1,))
    assert color_at(kept, 20, 20) == (0x20, 0xC0, 0x40)
    assert paths[1] == "M9 9h21v21h-21z"


def test_a_drawing_that_is_fitted_again_or_cut_out_states_the_settings_of_the_one_before() -> None:
    for stated in (
        {"mode": "flat", "cutout": True},
        {"mode": "flat", "cutout": True, "edited": True},
        {"edited": True},
    ):
        words = json.dumps({"generator": "warpvec 0", **stated})
        text = svg(f"<metadata>{words}</metadata>" if "mode" in stated else "", PAPER, TRUE)
        fitted, _ = again(start=text)
        job = FitJob(1, picture(PAPER, TRUE), "x", FitSettings({"mode": "flat"}), start=text, cuts=True)
        cut = run_job(job, lambda kind, facts: None, Watch(), 1)["svg"]
        assert description_of(fitted.encode())[1].items() >= stated.items()
        assert description_of(cut.encode())[1].items() >= {**stated, "cutout": True}.items()


def test_what_the_user_has_recoloured_is_not_fitted_back() -> None:
    before = svg(PAPER, square(9, 21, "#e04020"))
    edited = svg(PAPER, square(9, 21, "#20c040"))
    for known in (before, edited):  # the second one was recoloured before it was saved and opened
        text, _ = again(start=edited, before=known)
        assert np.abs(np.subtract(color_at(text, 20, 20), (0x20, 0xC0, 0x40))).max() <= 2
        assert np.abs(np.subtract(color_at(text, 5, 5), (0x30, 0x60, 0xA0))).max() <= 2


def test_paths_beside_a_locked_one_adapt_to_the_picture() -> None:
    edited = svg('<path fill="#000" d="M0 0h48v48h-48z"/>', square(10, 20, "#20c040"))
    kept, paths = again(start=edited, locked=(1,))
    assert len(paths) == 2
    assert np.abs(np.subtract(color_at(kept, 40, 40), (0x30, 0x60, 0xA0))).max() <= 2
    assert color_at(kept, 20, 20) == (0x20, 0xC0, 0x40)


def test_a_deleted_path_does_not_come_back() -> None:
    text, paths = again(start=svg(PAPER), erased=svg(square(10, 20, "#000")))
    assert len(paths) == 1
    assert np.abs(draw(text).astype(int) - (0x30, 0x60, 0xA0)).max() <= 2
    gone = svg(square(10, 20, "#000"))
    text, paths = again("photo", start=svg(PAPER), erased=gone, filled=gone)
    assert len(paths) == 2  # a photo gets as many as it has lost
    assert np.abs(draw(text).astype(int) - (0x30, 0x60, 0xA0)).max() <= 3


def test_a_locked_shape_of_another_program_stays_with_its_fill_and_its_stroke() -> None:
    shape = '<g transform="translate(39 39)"><circle r="4" fill="#fff" stroke="#123456" stroke-width="3"/></g>'
    text, _ = again(start=svg(PAPER, shape, square(9, 21, "#20c040")), locked=(1,))
    assert np.abs(np.subtract(color_at(text, 20, 20), (0xE0, 0x40, 0x20))).max() <= 2
    assert re.findall(r'(?:fill|stroke)="#(?:fff|123456)"', text) == ['fill="#fff"', 'stroke="#123456"']
    assert text.count('cx="39" cy="39" r="4"') == 2
    _, paths = again(start=svg(BACKGROUND, square(9, 21, "#20c040")), locked=(0,))  # the canvas is no path
    assert paths == ["M9 9h21v21h-21z"]


def test_a_locked_place_must_be_that_of_a_shape() -> None:
    empty = '<path fill="none" d="M2 2h9v9z"/>'  # a shape that draws nothing counts
    for text, count in ((svg(PAPER, TRUE), 2), (svg(PAPER, "<g transform='scale(1)'/>", TRUE, empty), 3)):
        with pytest.raises(InputError, match=f"locked must be places below {count}"):
            again(start=text, locked=(0, count))
        assert again(start=text, locked=(0, count - 1))[1]


def test_a_hole_is_filled_smoothly_from_its_border() -> None:
    ramp = np.linspace(0, 1, SIDE, dtype=np.float32)[None, :, None].repeat(SIDE, 0).repeat(3, 2)
    damaged = ramp.copy()
    damaged[14:34, 14:34] = (1.0, 0.0, 1.0)
    hole = hole_of(damaged, svg(square(14, 20, "#000")))
    assert hole.sum() == 24 * 24
    filled = erase(damaged, hole)
    assert np.abs(filled - ramp).max() < 0.15
    assert (filled[~hole] == ramp[~hole]).all()
    assert erase(damaged, np.zeros_like(hole)) is damaged


def test_another_detail_goes_on_from_the_outlines(monkeypatch: pytest.MonkeyPatch) -> None:
    from warpvec.flat import drawing

    searches: list[object] = []
    found = drawing.find_regions
    monkeypatch.setattr(drawing, "find_regions", lambda *given, **named: searches.append(0) or found(*given, **named))
    outlines = KnownOutlines()

    def drawn(kept: KnownOutlines, detail: float, data: bytes = picture(PAPER, TRUE)) -> str:
        job = FitJob(1, data, "x", FitSettings({"mode": "flat", "detail": detail}))
        return str(run_job(job, lambda kind, facts: None, Watch(), 1, kept)["svg"])

    drawn(outlines, 0.1)
    second = drawn(outlines, 0.4)
    assert len(searches) == 1
    assert second == drawn(KnownOutlines(), 0.4)
    drawn(outlines, 0.4, picture(PAPER, square(8, 20, "#20c040")))  # another picture
    assert len(searches) == 3


@pytest.mark.parametrize(("colors", "mode"), [(0, "mono"), (3, "flat")])
def test_black_and_white_art_that_is_to_have_colours_is_flat_art(colors: int, mode: str) -> None:
    stream = BytesIO()
    Image.fromarray(np.where(np.hypot(*np.mgrid[-32:32, -32:32]) < 20.5, 0, 255).astype(np.uint8)).save(stream, "PNG")
    job, seen = FitJob(1, stream.getvalue(), "x", FitSettings({"colors": colors})), []
    found = run_job(job, lambda kind, facts: seen.append(facts["mode"]), Watch(), 1)
    assert (seen, found["mode"]) == ([mode], mode)


def test_a_picture_whose_drawing_proves_it_a_photo_is_said_to_be_one(monkeypatch: pytest.MonkeyPatch) -> None:
    chosen, draw_as = fitting.chosen_mode, fitting.draw_picture
    job = FitJob(1, picture(PAPER, TRUE), "x", FitSettings({"mode": "auto"}))

    def drawn(request: Request, **known: object) -> Drawing:
        settings = replace(request.settings, mode="photo", iterations=20, curves=8)
        return replace(draw_as(replace(request, settings=settings)), mode_reason="as it proved to be")

    monkeypatch.setattr(fitting, "chosen_mode", lambda *given: ("flat", "it has few colours", chosen(*given)[2]))
    monkeypatch.setattr(fitting, "draw_picture", drawn)
    seen = list[tuple[str, str]]()
    found = run_job(job, lambda kind, facts: seen.append((facts["mode"], facts["reason"])), Watch(), 1)
    assert seen == [("flat", "it has few colours"), ("photo", "as it proved to be")]
    assert found["mode"] == "photo"


def test_a_drawing_with_a_goal_in_bytes_keeps_its_units(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("warpvec.polish.edited.ITERATIONS", 3)
    fine = svg(f'<path fill="#3060a0" d="M0 0h{10 * SIDE}v{10 * SIDE}h-{10 * SIDE}z"/>', square(100.25, 200, "#e04020"))
    fine = fine.replace(f'viewBox="0 0 {SIDE} {SIDE}"', f'viewBox="0 0 {10 * SIDE} {10 * SIDE}"')
    settings = FitSettings({"mode": "photo", "max_bytes": 30_000})
    job = FitJob(1, picture(PAPER, TRUE), "x", settings, start=fine, before=fine, keeps_paths=True)
    text = run_job(job, lambda kind, facts: None, Watch(), 1)["svg"]
    assert f'viewBox="0 0 {10 * SIDE} {10 * SIDE}"' in text
    assert "\n" not in text.strip()


def test_a_photo_that_is_fitted_again_keeps_to_the_goal_in_bytes_and_to_its_locks(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("warpvec.polish.edited.ITERATIONS", 3)
    squares = [square(k, SIDE - 2 * k, f"#{4 * k:02x}{255 - 9 * k:02x}80") for k in range(1, 20)]
    edited, locked = svg(PAPER, *squares, square(2, 1, "#123456")), len(squares) + 1
    job = FitJob(1, picture(PAPER, *squares), "x", FitSettings({"mode": "photo"}), start=edited, keeps_paths=True)
    size = len(run_job(job, lambda kind, facts: None, Watch(), 1)["svg"])
    limited = replace(job, settings=FitSettings({"mode": "photo", "max_bytes": 4 * size // 5}), locked=(locked,))
    text = run_job(limited, lambda kind, facts: None, Watch(), 1)["svg"]
    assert size // 2 < len(text) <= 4 * size // 5
    assert 'd="M2 2h1v1h-1z"' in text  # hardly seen, but locked
