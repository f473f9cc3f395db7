"""``warpvec app`` in a real Chromium, from the drop of a picture to a saved file that resvg draws again."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from browser import NEEDS_BROWSER, browser_fixture  # noqa: F401  (fixture)
from desk_browser import DeskPage, desk_fixture, desk_server_fixture  # noqa: F401  (fixtures)
from logo import logo
from pictures import picture
from PIL import Image
from scipy.ndimage import gaussian_filter

from warpvec.image.metrics import psnr
from warpvec.image.read import read_image
from warpvec.svg.measure import draw_like, file_facts

pytestmark = NEEDS_BROWSER


@pytest.fixture
def photo(tmp_path: Path) -> Path:
    """Write a small textured photo."""
    return write_photo(tmp_path / "photo.png")


def write_photo(path: Path, scale: int = 4) -> Path:
    """Write a picture with texture: spots wider than a pixel, as noise of single pixels is no part of a drawing."""
    rng = np.random.default_rng(0)
    base = np.kron(picture().numpy(), np.ones((scale, scale, 1)))
    spots = gaussian_filter(rng.normal(0, 0.3, base.shape), (1.5, 1.5, 0))
    Image.fromarray((255 * np.clip(base + spots, 0, 1)).astype(np.uint8)).save(path)
    return path


def write_logo(path: Path, transparent: bool) -> Path:
    image = Image.fromarray(logo(has_shadow=transparent))
    if not transparent:
        paper = Image.new("RGBA", image.size, "white")
        image = Image.alpha_composite(paper, image).convert("RGB")
    image.save(path)
    return path


def file_psnr(svg: Path, source: Path) -> float:
    target = read_image(source)
    return psnr(draw_like(svg.read_bytes(), target), target)


def test_a_photo_is_drawn_while_one_watches_and_saved(desk: DeskPage, photo: Path) -> None:
    desk.slide("set-detail", 8)
    desk.drop(photo)
    desk.wait_for_frame()
    assert desk.page.locator("#stop").is_enabled()
    desk.wait_for_status("done")
    assert desk.page.inner_text("#found") == "found: photo"
    assert desk.states() == ["photo done"]
    saved = desk.save()
    stated = float(desk.page.locator("#fit-figures tr", has_text="Closeness").inner_text().split()[1])
    assert abs(file_psnr(saved, photo) - stated) < 0.1  # the page writes a third decimal less
    assert stated > 22
    with Image.open(desk.save("png")) as image:
        assert image.size == (224, 160)
    packed = desk.save("svgz")
    assert packed.stat().st_size < saved.stat().st_size
    assert file_facts(packed.read_bytes())["paths"] == file_facts(saved.read_bytes())["paths"] == desk.paths()
    assert desk.save("pdf").read_bytes().startswith(b"%PDF")


@pytest.mark.parametrize("transparent", [False, True])
def test_a_logo_becomes_clean_shapes(desk: DeskPage, tmp_path: Path, transparent: bool) -> None:
    source = write_logo(tmp_path / "logo.png", transparent)
    desk.drop(source)
    desk.wait_for_status("done")
    assert desk.page.inner_text("#found") == "found: flat"
    saved = desk.save()
    assert file_psnr(saved, source) > 30
    assert ("background" in saved.read_text()) == (not transparent)
    with Image.open(desk.save("png")) as image:
        assert (image.mode == "RGBA" and image.getextrema()[3][0] == 0) == transparent
    # Without overlaps: as the command's --cutout.
    with desk.fitting():
        desk.page.locator("#set-cutout").check()
    assert file_psnr(desk.save(), source) > 29  # a shadow is cut along its outline


def test_broken_files_are_named_and_harm_nothing(desk: DeskPage, tmp_path: Path, photo: Path) -> None:
    broken = tmp_path / "broken.png"
    broken.write_bytes(photo.read_bytes()[:2000])
    desk.slide("set-detail", 0)
    desk.drop(broken, photo)
    desk.page.wait_for_function("() => document.querySelectorAll('#pictures .state')[1]?.textContent === 'done'")
    assert desk.states() == ["broken failed", "photo done"]
    desk.page.locator("#pictures .open").first.click()
    assert "must be a complete image, such as PNG, JPEG" in desk.status()
    desk.complaints.remove(next(text for text in desk.complaints if "422" in text))  # the browser's note


def test_stop_keeps_the_best_drawing_and_a_slider_goes_on_from_it(desk: DeskPage, tmp_path: Path) -> None:
    source = write_photo(tmp_path / "large.png", 6)
    desk.slide("set-detail", 24)
    desk.drop(source)
    desk.wait_for_frame(15.0)
    desk.page.locator("#stop").click()
    desk.wait_for_status("Stopped")
    first = desk.save()
    before = file_psnr(first, source)
    assert before > 14
    desk.slide("set-detail", 8)  # 64 shapes
    desk.wait_for_frame(before - 6)  # not from nothing
    assert desk.paths() <= 64
    with desk.fitting():
        desk.slide("set-detail", 4)  # while it draws: 32 shapes
    assert file_facts(desk.save().read_bytes())["paths"] <= 32


def test_a_large_photo_is_drawn(desk: DeskPage, tmp_path: Path) -> None:
    source = tmp_path / "large.jpg"
    with Image.open(write_photo(tmp_path / "small.png")) as image:
        image.resize((4000, 3000)).save(source, quality=85)
    desk.slide("set-detail", 4)
    desk.drop(source)
    desk.wait_for_frame()
    desk.page.locator("#stop").click()
    desk.wait_for_status("Stopped")
    assert file_facts(desk.save().read_bytes())["paths"] > 0
    assert desk.page.inner_text("#figures").split("Canvas")[1].split()[::2][:2] == ["4000", "3000"]


def test_two_tabs_take_turns(browser, desk: DeskPage, tmp_path: Path, photo: Path) -> None:
    other = DeskPage(browser, desk.server, tmp_path)
    desk.drop(write_photo(tmp_path / "first.png", 10))
    desk.wait_for_frame()
    other.drop(photo)
    other.wait_for_status("Waiting for 1 other drawing")
    assert other.states() == ["photo waiting, 1 before"]
    desk.page.locator("#stop").click()
    other.wait_for_frame()
    assert desk.states() == ["first stopped"]
    other.page.locator("#stop").click()
    other.wait_for_status("Stopped")
    other.close()


def test_an_edited_drawing_is_fitted_again(desk: DeskPage, tmp_path: Path) -> None:
    source = write_logo(tmp_path / "logo.png", transparent=False)
    desk.drop(source)
    desk.wait_for_status("done")
    before, count = desk.save(), desk.paths()
    # The yellow disc goes, the black bar becomes green and stays so.
    page = desk.page
    page.locator("#sides label").nth(1).click()
    desk.click(64, 62)
    page.keyboard.press("Delete")
    assert desk.paths() == count - 1
    desk.click(132, 108)
    page.locator("#fill").fill("#00aa00")
    page.locator("#fill").dispatch_event("change")
    with desk.fitting():
        page.locator("#fit-again").click()
        page.locator("#sides label").nth(0).click()
    assert desk.paths() == count - 1
    after = desk.save()
    target = read_image(source)
    first, second = (draw_like(file.read_bytes(), target).astype(int) for file in (before, after))
    assert tuple(second[108, 132]) == (0, 0xAA, 0)
    assert np.abs(second[62, 64] - (20, 110, 220)).max() < 24  # the blue ring's colour is all around the disc
    assert np.abs(first[62, 64] - (255, 200, 40)).max() < 8
    outside = np.ones(target.shape[:2], bool)
    outside[102:116, 110:155] = False  # the bar
    outside[40:85, 40:88] = False  # the disc
    assert np.abs(first - second)[outside].mean() < 1.0
    # A slider does not bring it back.
    with desk.fitting():
        desk.slide("set-detail", 16)
    third = draw_like(desk.save().read_bytes(), target).astype(int)
    assert np.abs(third[62, 64] - (20, 110, 220)).max() < 24


BLOCKED = "Object.defineProperty(window, 'sessionStorage', { get() { throw new DOMException('', 'SecurityError'); } })"


@pytest.mark.parametrize("script", ["sessionStorage.setItem('page', '../events?page=\\u202e')", BLOCKED])
def test_the_page_works_whatever_is_in_its_storage(desk: DeskPage, tmp_path: Path, script: str) -> None:
    desk.page.add_init_script(script)
    desk.page.reload()
    desk.page.wait_for_selector("body[data-desk]")
    desk.drop(write_logo(tmp_path / "logo.png", transparent=False))
    desk.wait_for_status("done")
    assert desk.paths() > 0
