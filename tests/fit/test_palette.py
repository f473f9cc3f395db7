"""Fills from a palette: files have no others, switches lower the loss, and a fit beats snapping afterwards."""

from __future__ import annotations

import re
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from commands import invoke, write_photo
from logo import logo
from numpy.typing import NDArray
from oracles import painted
from PIL import Image
from scenes import blob_scene
from stubs import stub_fit

import warpvec
from warpvec.config.fit_config import FitConfig
from warpvec.fit.palette import SWITCH_SHARE, Palette
from warpvec.geometry.scene import Scene
from warpvec.image.metrics import psnr
from warpvec.modes import photo as photo_mode
from warpvec.rendering.exact import ExactRenderer
from warpvec.svg.measure import draw
from warpvec.svg.write import write_svg

HEIGHT, WIDTH = 40, 56
GIVEN = "#102030,#c0a080,#fff,#456"
LONGER: dict[str, Any] = {"iterations": 300, "device": "cpu", "threads": 2}
QUICK: dict[str, Any] = {"initial_curves": 8, "iterations": 60, "inflation_gap": 4, "device": "cpu", "threads": 2}


def _photo(width: int) -> NDArray[np.uint8]:
    data = pytest.importorskip("skimage.data")
    image = Image.fromarray(data.chelsea()[20:260, 60:420])
    return np.asarray(image.resize((width, 2 * width // 3), Image.Resampling.LANCZOS))


def _fills(svg: str) -> set[str]:
    """Every fill of the file, including the canvas's, as "#rrggbb"."""
    found = re.findall(r'fill="(.*?)"', svg)
    return {name if len(name) == 7 else "#" + "".join(2 * digit for digit in name[1:]) for name in found}


@pytest.mark.parametrize("palette", [{"colors": 5}, {"colors": 1}, {"palette": GIVEN}])
@pytest.mark.parametrize(
    "settings",
    [
        {},
        {"color_parameter": "logit"},
        {"backdrop": "white"},
        {"renderer": "splat", "samples": 8, "lines": 4},
        {"preset": "paper", "samples": 8, "lines": 4, "iterations": 30},
        {"opacity": "opaque"},
        {"policy": "replacement", "z_order": "area"},
    ],
)
def test_the_file_has_no_other_fill(palette: dict[str, Any], settings: dict[str, Any]) -> None:
    result = warpvec.vectorize(_photo(48), 24, **{**QUICK, **palette, **settings})
    fills = _fills(result.svg())
    if "colors" in palette:
        assert len(fills) <= palette["colors"]
    else:
        assert fills <= {"#102030", "#c0a080", "#ffffff", "#445566"}
    if settings.get("policy") != "replacement":  # it leaves too few paths in so short a run
        assert len(fills) > 2 or palette.get("colors") == 1
    assert "<rect" in result.svg()
    levels = 255.0 * result.drawing.fitted.color
    torch.testing.assert_close(levels, levels.round(), atol=1e-4, rtol=0)  # the fit drew what the file says


@pytest.mark.parametrize("palette", [{"colors": 4}, {"palette": GIVEN}])
def test_transparent_images_have_a_palette_for_their_paths(palette: dict[str, Any]) -> None:
    result = warpvec.vectorize(logo(), 24, **QUICK, **palette)
    assert "<rect" not in result.svg()
    assert 2 < len(_fills(result.svg())) <= 4


def test_the_canvas_of_a_transparent_image_does_not_count() -> None:
    """A large black canvas and its adjoint must not influence the palette of a transparent scene."""
    config = FitConfig(colors=2)
    color = torch.tensor([[0.9, 0.1, 0.1], [0.1, 0.1, 0.9], [0.0, 0.0, 0.0]])
    area, adjoint = torch.tensor([100.0, 100.0, 1e4]), torch.tensor([[0.0] * 3, [0.0] * 3, [-9.0] * 3])
    for transparent in (True, False):
        palette = Palette(config, 1000)
        palette.start(color, area, transparent)
        before = palette.color.clone()
        for _ in range(20):
            palette.step(adjoint, None, 1.0)
        unmoved = torch.equal(palette.color, before)
        assert unmoved is transparent
        if transparent:
            torch.testing.assert_close(before[:2], color[:2], atol=0.003, rtol=0)


# fitted with the palette, not snapped to it


def _snapped(scene: Scene, colors: torch.Tensor) -> Scene:
    def nearest(color: torch.Tensor) -> torch.Tensor:
        return colors[(color[:, None] - colors).square().sum(-1).argmin(1)]

    return replace(scene, color=nearest(scene.color), background=nearest(scene.background[None])[0])


@pytest.fixture(scope="module")
def free() -> warpvec.Result:
    """A fit with free fills and opacities: 28.2 dB."""
    return warpvec.vectorize(_photo(120), 96, **LONGER)


@pytest.mark.parametrize("palette", [{"colors": 6}, {"palette": "#2b2320,#8c6f5a,#c7a98f,#5d4a3e,#eee"}])
def test_a_fit_under_a_palette_is_better_than_a_free_one_snapped_to_it(
    palette: dict[str, Any], free: warpvec.Result
) -> None:
    photo = _photo(120)
    constrained = warpvec.vectorize(photo, 96, opacity="free", **LONGER, **palette)
    colors = torch.tensor([list(bytes.fromhex(fill[1:])) for fill in sorted(_fills(constrained.svg()))]) / 255.0
    height, width = photo.shape[:2]
    snapped = draw(write_svg(_snapped(free.scene, colors), width, height), width, height)
    gain = constrained.metrics["psnr"] - psnr(snapped, photo)
    # 0.8 dB with the fitted palette, 1.15 with the given one; other seeds give 0.8 to 1.1 and 0.9 to 1.5.
    assert gain > 0.5


# the rule by which paths switch entries


def _switching_case(seed: int) -> tuple[Palette, ExactRenderer, tuple[torch.Tensor, ...], torch.Tensor, torch.Tensor]:
    """A palette and paths in random entries of it, their renderer in float64, a target, and random colours."""
    blobs = blob_scene(seed, 14, HEIGHT, WIDTH)
    generator = torch.Generator().manual_seed(seed)
    names = ",".join("#" + bytes(torch.randint(256, (3,), generator=generator).tolist()).hex() for _ in range(5))
    palette = Palette(FitConfig(palette=names), HEIGHT * WIDTH)
    color = torch.rand((15, 3), generator=generator, dtype=torch.float64)
    palette.start(color, torch.ones(15), False)
    target = torch.rand((HEIGHT, WIDTH, 3), generator=generator, dtype=torch.float64)
    renderer = ExactRenderer(HEIGHT, WIDTH, dtype=torch.float64)
    return palette, renderer, (blobs.points, blobs.opacity), target, color


def _loss(renderer: ExactRenderer, paths: tuple[torch.Tensor, ...], color: torch.Tensor, target: torch.Tensor) -> float:
    return float((renderer.render(painted(paths, color)) - target).square().mean())


@pytest.mark.parametrize("seed", range(3))
def test_the_loss_of_a_switch_stays_below_its_bound(seed: int) -> None:
    palette, renderer, paths, target, _ = _switching_case(seed)
    color = palette.color
    adjoints = renderer.fit_step(painted(paths, color), renderer.prepare_target(target))
    adj_color = torch.cat([adjoints.color, adjoints.background[None]])
    ones = renderer.adjoint(painted(paths, color), torch.ones_like(target))
    area = torch.cat([ones.color[:, 0], ones.background[:1]])
    entries = torch.unique(color, dim=0)
    before = _loss(renderer, paths, color, target)
    # Brute force: every path in every entry.
    for row in range(15):
        for entry in entries:
            change = entry - color[row]
            bound = float(adj_color[row] @ change + area[row] * change.square().sum() / target.numel())
            other = color.clone()
            other[row] = entry
            assert _loss(renderer, paths, other, target) - before <= bound + 1e-12


@pytest.mark.parametrize("seed", range(3))
def test_switches_lower_the_loss_until_none_is_left(seed: int) -> None:
    palette, renderer, paths, target, _ = _switching_case(seed)
    losses, changes = [_loss(renderer, paths, palette.color, target)], []
    for _ in range(30):
        color = palette.color
        adjoints = renderer.fit_step(painted(paths, color), renderer.prepare_target(target))
        ones = renderer.adjoint(painted(paths, color), torch.ones_like(target))
        area = torch.cat([ones.color[:, 0], ones.background[:1]])
        palette.step(torch.cat([adjoints.color, adjoints.background[None]]), area, 1.0)
        changes.append(int((palette.color != color).any(-1).sum()))
        losses.append(_loss(renderer, paths, palette.color, target))
    # With so few paths one switches at a time, so that its bound is that of the step.
    assert max(changes) == int(SWITCH_SHARE * 15) == 1
    assert all(after <= before + 1e-12 for before, after in pairwise(losses))
    assert losses[-1] < losses[0]
    assert changes[-1] == 0


def test_added_paths_take_the_nearest_entries_and_removed_ones_change_no_others() -> None:
    palette = Palette(FitConfig(palette="#000,#f00,#00f"), 100)
    palette.start(torch.tensor([[0.1, 0.0, 0.0], [0.8, 0.1, 0.0], [0.0, 0.3, 0.9]]), torch.ones(3), False)
    palette.append(torch.tensor([[0.9, 0.0, 0.2]]))
    assert palette.color.tolist() == [[0, 0, 0], [1, 0, 0], [1, 0, 0], [0, 0, 1]]
    palette.keep(torch.tensor([2, 0]))
    assert palette.color.tolist() == [[1, 0, 0], [0, 0, 0], [0, 0, 1]]


@pytest.mark.parametrize("count", [1, 2, 256])
def test_a_fitted_palette_has_no_more_colours_than_the_paths(count: int) -> None:
    palette = Palette(FitConfig(colors=count), 100)
    color = torch.tensor([[1.0, 0.0, 0.0]] * 3 + [[0.0, 1.0, 0.0]] * 2)
    palette.start(color, torch.tensor([0.0, 0.0, 1e9, 5.0, 0.0]), False)
    assert len(torch.unique(palette.color, dim=0)) <= min(count, 2)
    if count > 1:
        torch.testing.assert_close(palette.color, color, atol=0.01, rtol=0)


# opacity


def test_opaque_paths_are_better_than_free_ones_made_opaque(free: warpvec.Result) -> None:
    photo = _photo(120)
    opaque = warpvec.vectorize(photo, 96, opacity="opaque", **LONGER)
    assert "opacity" not in re.sub(r"<metadata>.*?</metadata>", "", opaque.svg(), flags=re.DOTALL)
    height, width = photo.shape[:2]
    scene = replace(free.scene, opacity=torch.ones_like(free.scene.opacity))
    made_opaque = draw(write_svg(scene, width, height), width, height)
    # 0.9 dB, although the free fit favours opaque paths too; other seeds give 0.7 and 0.3.
    assert opaque.metrics["psnr"] - psnr(made_opaque, photo) > 0.4


# areas


def test_no_path_of_the_file_is_smaller_than_min_area() -> None:
    photo = _photo(96)
    settings = {**QUICK, "iterations": 120, "fit_size": 48}  # areas are in pixels of the photo, not of the fit
    areas = _areas(warpvec.vectorize(photo, 64, min_area=20.0, **settings))
    assert len(areas) > 30
    assert min(areas) >= 20.0 - 0.5  # the error of the samples
    assert min(_areas(warpvec.vectorize(photo, 64, **settings))) < 15.0


def test_paths_that_end_too_small_are_not_in_the_file(monkeypatch: pytest.MonkeyPatch) -> None:
    """The paths are discs of 50 square pixels; some lie partly off the canvas."""
    monkeypatch.setattr(photo_mode, "fit", stub_fit)
    result = warpvec.vectorize(_photo(48), 40, iterations=1, min_area=45.0)
    areas = _areas(result)
    assert 5 < len(areas) < len(result.drawing.fitted) == 40
    assert min(areas) > 44.5


def _areas(result: warpvec.Result) -> list[float]:
    """Areas of the paths in the file: resvg draws each alone, white on black, at four times the size."""
    height, width = result.picture.pixels.shape[:2]
    areas = []
    for data in re.findall(r' d="(.*?)"', result.svg()):
        svg = (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{4 * width}"'
            f' height="{4 * height}"><rect width="100%" height="100%"/><path fill="#fff" d="{data}"/></svg>'
        )
        areas.append(draw(svg, 4 * width, 4 * height)[..., 0].sum() / 255.0 / 16.0)
    return areas


def test_a_palette_may_be_read_from_a_file(tmp_path: Path) -> None:
    colors = tmp_path / "brand.css"
    colors.write_text("a { color: #102030 } b { color: #FFF; background: #c0a080 }")
    out = tmp_path / "out.svg"
    result = invoke("run", write_photo(tmp_path), out, "--palette", colors, "--curves", "8", "--iterations", "30")
    assert result.exit_code == 0, result.output
    assert _fills(out.read_text()) <= {"#102030", "#c0a080", "#ffffff"}
