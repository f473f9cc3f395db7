"""Runs of flat art: the mode, the file, its layers, and what goals and settings do to it."""

from __future__ import annotations

import re
import signal
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import torch
from damage import as_jpeg, drawn
from numpy.typing import NDArray
from PIL import Image, ImageDraw

import warpvec
from warpvec.config.presets import make_config
from warpvec.errors import InputError
from warpvec.flat import drawing, explanation
from warpvec.flat.color_layers.layering import color_name
from warpvec.flat.constants.drawing import DRAWING
from warpvec.flat.constants.regions import REGIONS
from warpvec.flat.drawing import FlatDrawing
from warpvec.flat.regions import regions
from warpvec.modes import choice
from warpvec.modes.flat import on_paper
from warpvec.svg.measure import draw as draw_svg
from warpvec.svg.resvg import rasterize
from warpvec.svg.write import write_svg
from warpvec.watch.progress import Progress
from warpvec.watch.watch import Watch

SIDE = 64
NAVY, GOLD, RED = (0, 0, 128), (255, 215, 0), (220, 20, 60)


def badge(mode: str = "RGB") -> NDArray[np.uint8]:
    """Return a navy square with a hole that holds a gold disc, and two red bars, on white or on nothing."""
    big = Image.new(mode, (4 * SIDE, 4 * SIDE), "white" if mode == "RGB" else (0, 0, 0, 0))
    pen = ImageDraw.Draw(big)
    pen.rectangle((24, 24, 183, 183), fill=NAVY)
    pen.rectangle((56, 56, 151, 151), fill="white" if mode == "RGB" else (0, 0, 0, 0))
    pen.ellipse((72, 72, 135, 135), fill=GOLD)
    for left in (24, 136):
        pen.rectangle((left, 204, left + 95, 235), fill=RED)
    return np.asarray(big.resize((SIDE, SIDE), Image.Resampling.BOX))


QUICK: dict[str, Any] = {"threads": 1, "strokes": "off", "iterations": 4}


def draw(**settings: Any) -> warpvec.Result:
    return warpvec.vectorize(badge(), **{**QUICK, **settings})


@pytest.fixture(scope="module")
def plain() -> warpvec.Result:
    """Return the badge as it comes out without settings."""
    return warpvec.vectorize(badge(), threads=1)


def test_flat_art_becomes_few_exact_paths_in_layers_of_one_colour(plain: warpvec.Result) -> None:
    assert plain.metrics["mode"] == plain.config.mode == "flat"
    assert "4 colours" in plain.metrics["mode_reason"]
    assert plain.metrics["psnr"] > 42
    assert plain.metrics["curves"] <= 5
    assert plain.metrics["segments"] <= 24
    text = plain.svg()
    fills = re.findall(r'<\w+ (?:fill|fill="none" stroke)="(#\w+)"', text)
    assert sorted(set(fills)) == ["#000080", "#dc143c", "#ffd700"]
    assert '<rect id="background" width="64" height="64" fill="#fff"/>' in text
    labels = re.findall(r'<g id="([\w-]+)" inkscape:groupmode="layer" inkscape:label="([^"]+)">', text)
    names = [(identifier, label.partition(" ")[2]) for identifier, label in labels]
    assert sorted(names) == [
        ("crimson-dc143c", "crimson #dc143c"), ("gold-ffd700", "gold #ffd700"), ("navy-000080", "navy #000080"),
    ]  # fmt: skip
    assert [label.partition(" ")[0] for _, label in labels] == ["1", "2", "3"]
    assert '"mode": "flat"' in text
    assert "lr_points" not in text


def test_its_file_is_read_back_to_the_same_bytes(plain: warpvec.Result) -> None:
    assert warpvec.refine(badge(), plain.svg(), iterations=0).svg() == plain.svg()


def test_holes_of_transparent_art_stay_transparent() -> None:
    result = warpvec.vectorize(badge("RGBA"), **QUICK)
    assert result.scene.transparent
    alpha = result.render()[..., 3]
    assert alpha[15:17, 20:36].max() < 0.01
    assert alpha[30, 24] > 0.99
    assert result.metrics["psnr"] > 38


def test_equal_pictures_give_equal_bytes_for_any_number_of_threads(plain: warpvec.Result) -> None:
    assert warpvec.vectorize(badge(), threads=2).svg() == plain.svg()


def test_the_mode_can_be_given(plain: warpvec.Result) -> None:
    photo = draw(mode="photo", strokes="auto", curves=6)
    assert photo.metrics["mode"] == "photo"
    assert photo.metrics["mode_reason"] is None
    assert "detail" not in photo.svg()
    assert draw(lr_scale=2.0, strokes="auto", curves=6).metrics["mode"] == "photo"
    noise = np.random.default_rng(0).integers(0, 256, (48, 48, 3), dtype=np.uint8)
    found = warpvec.vectorize(noise, 6, iterations=10).metrics
    assert found["mode"] == "photo"
    assert "textured" in found["mode_reason"]


def test_mono_is_one_black_path_without_a_canvas() -> None:
    result = draw(mode="mono", threshold=140, strokes="off")
    assert result.metrics["curves"] == 1
    assert len(re.findall('<path fill="#000"', result.svg())) == 1
    assert "<rect" not in result.svg()
    ink = result.render()[..., 3] if result.render().shape[2] == 4 else 1 - result.render()[..., 0]
    dark = badge().mean(2) < 140
    assert np.abs(ink - dark).mean() < 0.05


def test_clean_art_in_black_and_white_has_strokes() -> None:
    original = (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{SIDE}" height="{SIDE}"><path fill="none" stroke="#000" '
        'stroke-width="5" stroke-linecap="round" d="M12 14h30l8 30"/><circle cx="18" cy="42" r="8"/></svg>'
    )
    result = warpvec.vectorize(draw_svg(original, SIDE, SIDE), threads=1)
    assert result.metrics["mode"] == "mono"
    assert result.metrics["psnr"] > 45
    assert re.search('<path fill="none" stroke="#000" stroke-width="5(.0[0-9])?" stroke-linecap="round"', result.svg())
    assert '<circle fill="#000"' in result.svg()


def test_cutouts_do_not_overlap_and_leave_the_white_page_out() -> None:
    cut = draw(cutout=True)
    assert cut.scene.transparent and cut.metrics["psnr"] > 36

    def coverage(scene: warpvec.Scene) -> float:
        return float(draw_svg(write_svg(scene, SIDE, SIDE), SIDE, SIDE, transparent=True)[..., 3].sum()) / 255

    whole = coverage(cut.scene)
    assert whole < 0.9 * SIDE**2
    # Along their common edges two paths cover less together than each by itself.
    assert sum(coverage(cut.scene.select(torch.tensor([k]))) for k in range(len(cut.scene))) == pytest.approx(
        whole, rel=0.03
    )


def test_curves_colors_and_palettes_are_bounds(plain: warpvec.Result) -> None:
    fewer = draw(curves=2)
    assert fewer.metrics["curves"] == 2
    assert fewer.metrics["psnr"] < plain.metrics["psnr"]
    two = draw(colors=2)
    assert len(set(re.findall(r'fill="(#\w+)"', two.svg()))) == 2
    given = draw(palette="black,white,#f00")
    assert set(re.findall(r'fill="(#\w+)"', given.svg())) <= {"#000", "#fff", "#f00"}


def test_a_picture_that_flat_art_cannot_show_is_a_photo(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(choice, "FLAT_PSNR_MIN", 90.0)
    assert draw(curves=4).config.mode == "flat"  # few paths were asked for
    assert draw(strokes="auto").config.mode == "flat"  # its words are fewer than a photo's
    monkeypatch.setattr(explanation, "PHOTO_OVER_CODER", 0.0)
    result = draw(strokes="auto")
    assert result.config.mode == "photo"
    assert "as flat art it has only" in result.metrics["mode_reason"]


def test_a_poor_jpeg_is_flat_art_although_it_is_far_from_its_drawing() -> None:
    result = warpvec.vectorize(as_jpeg(drawn(96, "#fff"), 12))
    assert result.metrics["mode"] == "flat"
    assert result.metrics["psnr"] < choice.FLAT_PSNR_MIN


def test_a_picture_of_too_many_areas_becomes_a_photo_before_it_is_drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(regions, "REGIONS", replace(REGIONS, seeds_max=1))
    result = draw(strokes="auto")
    assert result.config.mode == "photo"
    assert "separate areas of one colour" in result.metrics["mode_reason"]
    assert draw(mode="flat").config.mode == "flat"


def test_goals_choose_the_detail() -> None:
    size = len(draw(minify=True).svg().encode())
    small = draw(max_bytes=size - 100)
    assert small.metrics["bytes"] <= size - 100
    assert small.metrics["goal"]["met"]
    assert len(small.metrics["goal"]["trials"]) > 1


def test_a_long_drawing_is_not_fitted_with_little_time_left(monkeypatch: pytest.MonkeyPatch) -> None:
    image = torch.from_numpy(badge().copy()).float() / 255.0
    late = Watch(time_budget=100.0)
    late.resume(90.0)
    monkeypatch.setattr(drawing, "polish", lambda *_, **__: pytest.fail("it is fitted"))
    monkeypatch.setattr(drawing, "remove_paths", lambda *_, **__: pytest.fail("paths are looked at"))
    monkeypatch.setattr(drawing, "DRAWING", replace(DRAWING, many_values=1))
    scene, left_out = FlatDrawing(image, make_config(mode="flat"), late).draw(0.5)
    assert len(scene) and not left_out


def test_a_spent_time_budget_and_an_interrupt_leave_a_drawing() -> None:
    late = draw(time_budget=0.01)
    assert late.metrics["psnr"] > 25

    def interrupt(progress: Progress) -> None:
        signal.raise_signal(signal.SIGINT)

    stopped = draw(on_progress=interrupt)
    assert stopped.interrupted
    assert stopped.metrics["psnr"] > 25


def test_progress_runs_forward_through_all_fits(plain: warpvec.Result) -> None:
    seen: list[Progress] = []
    draw(on_progress=seen.append)
    numbers = [progress.iteration for progress in seen]
    assert numbers == list(range(1, len(numbers) + 1))
    assert all(progress.iteration <= progress.iteration_count for progress in seen)
    assert [entry["iteration"] for entry in plain.history] == sorted({entry["iteration"] for entry in plain.history})


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"mode": "flat", "lod": True}, "lod must not be given in the mode flat, which does not use it, got True"),
        ({"mode": "mono", "recycle_gap": 3}, "recycle_gap must not be given in the mode mono"),
        ({"mode": "flat", "preset": "paper"}, "path_model must not be given in the mode flat"),
        ({"mode": "photo", "cutout": True}, "cutout must not be given in the mode photo"),
        ({"mode": "flat", "threshold": 3}, "threshold must not be given in the mode flat"),
        ({"mode": "mono", "palette": "red"}, "palette must not be given in the mode mono"),
        ({"cutout": True, "max_bytes": 130}, "max_bytes must be enough for all paths without overlaps, got 130"),
        ({"mode": "drawing"}, "mode must be one of auto, photo, flat, mono, lines, pixel, mixed, got 'drawing'"),
        ({"detail": 0}, "detail must be above 0 and at most 10 pixels"),
        ({"threshold": "grey"}, "threshold must be auto or a level from 0 to 255"),
    ],
)
def test_settings_of_two_modes_are_refused(settings: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=re.escape(message)):
        draw(**settings)


@pytest.mark.parametrize(
    ("settings", "mode"),
    [
        ({}, "auto"), ({"preset": "draft"}, "auto"), ({"curves": 9, "colors": 3, "detail": 0.3}, "auto"),
        ({"preset": "paper"}, "photo"), ({"inflation_gap": 9}, "photo"), ({"inflation_gap": 30}, "auto"),
        ({"cutout": True}, "flat"), ({"threshold": 99}, "mono"), ({"mode": "flat", "preset": "best"}, "flat"),
    ],
)  # fmt: skip
def test_settings_of_one_mode_decide_it(settings: dict[str, Any], mode: str) -> None:
    assert make_config(**settings).mode == mode


def test_colours_are_named_as_in_css() -> None:
    colors = {"red #e4002b": (228, 0, 43), "white #ffffff": (255, 255, 255), "teal #0a7f80": (10, 127, 128)}
    for name, levels in colors.items():
        assert color_name(np.array(levels) / 255.0).split("#")[1] == name.split("#")[1]
    assert color_name(np.array((250, 5, 5)) / 255.0).startswith("red ")
    assert color_name(np.array((0xEA, 0x76, 0x00)) / 255.0).startswith("darkorange ")
    assert color_name(np.array((0x22, 0x22, 0x22)) / 255.0).startswith("black ")
    assert color_name(np.array((254, 254, 254)) / 255.0).startswith("white ")
    assert color_name(np.array((0x3B, 0x1F, 0x0F)) / 255.0).startswith("saddlebrown ")


def test_a_ramp_has_its_mean_colour_when_gradients_are_forbidden() -> None:
    picture = np.full((SIDE, SIDE, 3), 255, np.uint8)
    picture[8:44, 8:44] = np.linspace((0, 0, 160), (0, 0, 96), 36)[:, None]
    plain, asked = (warpvec.vectorize(picture, **QUICK, **given) for given in ({}, {"gradients": 0}))
    assert plain.metrics["mode"] == asked.metrics["mode"] == "flat"
    assert (plain.metrics["gradients"], asked.metrics["gradients"]) == (1, 0)
    assert [asked.metrics["curves"], re.findall(r'<\w+ fill="(#\w+)"', asked.svg())] == [1, ["#000080"]]
    assert make_config(gradients=0).mode == "auto" and make_config(gradients=0.5).mode == "photo"
    assert make_config(mode="photo").gradients == 0.0


@pytest.mark.parametrize(("shapes", "forms"), [
    ('<circle cx="30" cy="31" r="20"/><rect x="55" y="50" width="30" height="35" rx="6"/>', (1, 1)),
    ('<circle cx="30" cy="31" r="20"/><path d="M55 50l30 5-9 30zM10 60h9v30h-9zM60 10h20l-4 9h-10l3 15z"/>', (0, 0)),
])  # fmt: skip
def test_black_and_white_art_of_forms_has_forms_and_else_one_path(shapes: str, forms: tuple[int, int]) -> None:
    text = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 96 96" width="576" height="576">{shapes}</svg>'
    picture = draw_svg(text, 576, 576).reshape(144, 4, 144, 4, 3).mean((1, 3)).round().astype(np.uint8)
    metrics = warpvec.vectorize(picture, mode="mono", threads=1, iterations=4).metrics
    assert (metrics["circles"], metrics["rects"]) == forms
    assert metrics["curves"] == max(sum(forms), 1) and metrics["psnr"] > 35


def test_paper_is_white_or_left_out() -> None:
    grey = np.minimum(badge(), 232)
    kept, removed = (warpvec.vectorize(grey, **QUICK, paper=paper) for paper in ("keep", "remove"))
    assert [each.metrics["mode"] for each in (kept, removed)] == ["flat", "flat"]
    assert '<rect id="background" width="64" height="64" fill="#fff"/>' in kept.svg()
    assert "background" not in removed.svg() and "#e8e8e8" not in removed.svg()
    on_navy = replace(kept.scene, background=torch.tensor([0.0, 0.0, 0.5]))
    assert on_paper(on_navy, "keep") is on_navy
    assert not on_paper(replace(on_navy, transparent=True), "keep").transparent


def small_logo(ground: str) -> NDArray[np.uint8]:
    """Return a face of 110 px with a magenta mouth on white, saved as JPEG, enlarged, and saved as JPEG again."""
    face = f"""<svg xmlns="http://www.w3.org/2000/svg" width="256" height="256">
        <rect width="256" height="256" fill="#fff"/><circle cx="128" cy="132" r="105.3" fill="{ground}"/>
        <path d="M40,60L70,18L110,45Z" fill="#b6885a"/>
        <circle cx="90" cy="110" r="16" fill="#010101"/><rect x="150.4" y="95.3" width="37" height="22" fill="#4fb5e1"/>
        <path d="M75,170Q128,215 185,165" stroke="#c2185b" stroke-width="7" fill="none"/></svg>"""
    small = Image.fromarray(rasterize(face, sandboxed=False)).resize((110, 110), Image.Resampling.BOX)
    large = as_jpeg(small, 75).resize((256, 256), Image.Resampling.BICUBIC)
    return np.asarray(as_jpeg(large, 80))


def test_a_thin_line_that_jpeg_darkens_keeps_its_color() -> None:
    drawn = warpvec.vectorize(small_logo("#ffcd88"))
    assert drawn.metrics["mode"] == "flat"
    magenta = torch.tensor([194.0, 24.0, 91.0]) / 255.0
    assert float((drawn.scene.color - magenta).abs().amax(1).min()) < 40.0 / 255.0


def test_ringing_of_a_jpeg_does_not_tint_the_paper() -> None:
    assert (
        '<rect id="background" width="256" height="256" fill="#fff"/>' in warpvec.vectorize(small_logo("#1a7cf9")).svg()
    )


def icon(unit: int) -> NDArray[np.uint8]:
    """Return an icon on a grid of 24: a rounded square with an arrow of three strokes, drawn by resvg."""
    text = (
        '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 24 24"><rect width="24" height="24" fill="#fff"/>'
        '<g fill="none" stroke="#124" stroke-width="2" stroke-linecap="round" stroke-linejoin="round">'
        '<rect x="3" y="3" width="18" height="18" rx="2"/><path d="M16 12H8"/><path d="m12 8-4 4 4 4"/></g></svg>'
    )
    return rasterize(text, 24 * unit, 24 * unit)[..., :3]


def test_an_icon_is_drawn_in_the_numbers_of_its_grid() -> None:
    result = warpvec.vectorize(icon(8), threads=1)
    text = result.svg()

    assert 'width="192" height="192" viewBox="0 0 24 24"' in text and 'stroke-width="2"' in text
    assert 'x="3" y="3" width="18" height="18" rx="2"' in text
    numbers = {float(each) for data in re.findall(r' d="([^"]+)"', text) for each in re.findall(r"-?\d*\.?\d+", data)}
    assert numbers <= {float(k) for k in range(-16, 17)}
    assert result.metrics["grid"] == 24 and result.metrics["grid_share"] == 1.0
    assert result.metrics["psnr"] > 45.0


def test_a_short_file_is_in_the_units_of_a_given_grid() -> None:
    text = warpvec.vectorize(icon(8), threads=1, grid=24, minify=True).svg()
    assert 'viewBox="0 0 24 24"' in text and 'x="3" y="3" width="18" height="18" rx="2"' in text
    assert "<title" not in text


def test_parts_that_are_cut_out_are_in_the_units_of_a_given_grid() -> None:
    result = warpvec.vectorize(icon(8), threads=1, grid=24, cutout=True)
    assert 'viewBox="0 0 24 24"' in result.svg() and 'd="M2 5a3 3 0 0 1 3-3h14a3 3 0 0 1 3 3' in result.svg()
    assert result.metrics["psnr"] > 44.0


def test_without_a_grid_the_file_is_in_pixels() -> None:
    result = warpvec.vectorize(icon(6), threads=1, grid="off")
    assert 'viewBox="0 0 144 144"' in result.svg() and "grid" not in result.metrics


@pytest.mark.parametrize("minify", [False, True])
def test_a_plain_file_of_an_icon_is_in_pixels(minify: bool) -> None:
    pytest.importorskip("pathops")
    text = warpvec.vectorize(icon(6), threads=1, purpose="plain", minify=minify).svg()
    assert 'width="144" height="144" viewBox="0 0 144 144"' in text


def test_a_grid_that_does_not_fit_the_canvas_is_refused() -> None:
    with pytest.raises(InputError, match="grid"):
        warpvec.vectorize(icon(6)[:100], threads=1, mode="flat", grid=24)


@pytest.mark.parametrize("grid", ["0", "on", 5000])
def test_a_grid_that_is_none_is_refused(grid: object) -> None:
    with pytest.raises(InputError, match="grid"):
        make_config(grid=grid)
