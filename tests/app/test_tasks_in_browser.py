"""What users come for, once with the mouse and once with keys alone: a cut-out logo, a photo of few bytes."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from browser import NEEDS_BROWSER, browser_fixture  # noqa: F401  (fixture)
from desk_browser import DeskPage, desk_fixture, desk_server_fixture  # noqa: F401  (fixtures)
from desk_hands import HANDS, press
from logo import logo
from PIL import Image
from quick_desk import write_logo

from warpvec.image.metrics import psnr
from warpvec.image.read import read_image
from warpvec.svg.measure import draw_like

pytestmark = NEEDS_BROWSER


def choose(desk: DeskPage, source: Path, way: str) -> None:
    """Choose a picture file with the button."""
    with desk.page.expect_file_chooser() as chooser:
        if way == "mouse":
            desk.page.locator("#choose").click()
        else:
            press(desk, "choose", "Enter")
    chooser.value.set_files(source)


def save(desk: DeskPage, way: str) -> Path:
    """Save the SVG."""
    if way == "mouse":
        return desk.save()
    with desk.page.expect_download() as download:
        desk.page.keyboard.press("Control+s")
    path = desk.folder / download.value.suggested_filename
    download.value.save_as(path)
    return path


def write_scene(path: Path, person: bool) -> Path:
    """Write a photo of a wall with or without a figure in front of it."""
    y, x = np.mgrid[0:120, 0:160] / 160.0
    rng = np.random.default_rng(1)
    image = np.stack([0.5 + 0.3 * x, 0.6 - 0.2 * y, 0.4 + 0.2 * x * y], -1)
    if person:
        image[(x - 0.5) ** 2 / 0.008 + (y - 0.4) ** 2 / 0.04 < 1] = (0.1, 0.05, 0.3)
    noisy = image + rng.normal(0, 0.02, image.shape)
    Image.fromarray((255 * noisy.clip(0, 1)).astype(np.uint8)).save(path)
    return path


@pytest.mark.parametrize("way", ["mouse", "keys"])
def test_a_logo_becomes_a_file_for_a_cutter(desk: DeskPage, tmp_path: Path, way: str) -> None:
    source = tmp_path / "logo.png"
    Image.fromarray(logo(has_shadow=False)).save(source)
    choose(desk, source, way)
    desk.wait_for_status("done")
    with desk.fitting():
        if way == "mouse":
            desk.page.locator("#set-cutout").check()
        else:
            press(desk, "set-cutout", "Space")
    saved = save(desk, way)
    assert '"cutout":true' in saved.read_text().replace(" ", "")
    target = read_image(source)
    assert psnr(draw_like(saved.read_bytes(), target), target) > 28


def save_for(desk: DeskPage, use: str) -> Path:
    """Save the file for a use, as a person who reads the list does."""
    desk.page.locator("#purpose").select_option(label=use)
    with desk.page.expect_download() as download:
        desk.page.locator("#save-for").click()
    path = desk.folder / download.value.suggested_filename
    download.value.save_as(path)
    return path


def test_a_logo_becomes_a_file_in_millimetres_for_a_cutter_and_one_for_android(desk: DeskPage, tmp_path: Path) -> None:
    ezdxf = pytest.importorskip("ezdxf")
    source = tmp_path / "Our Logo-2.png"
    Image.fromarray(logo(has_shadow=False)).save(source)
    choose(desk, source, "mouse")
    desk.wait_for_status("done")
    desk.page.locator("#size-unit").select_option("mm")
    desk.page.locator("#size-width").fill("90")
    desk.page.locator("#size-width").press("Enter")
    desk.page.locator("#purpose").select_option(label="My cutter or laser")
    assert re.search(r"It is 90 . [\d.]+ mm now", desk.page.inner_text("#purpose-text"))
    cut = ezdxf.readfile(save_for(desk, "My cutter or laser"))
    assert cut.units == 4 and cut.header["$EXTMAX"][0] == pytest.approx(90.0)
    assert len(cut.modelspace()) > 0
    android = save_for(desk, "An Android app")
    assert android.name == "our_logo_2.xml"  # Android refuses other letters in names of resources
    assert "<vector" in android.read_text()


# With keys alone. The mouse sets the same slider in the next test.
def test_a_photo_becomes_a_file_of_few_bytes(desk: DeskPage, tmp_path: Path) -> None:
    source = write_scene(tmp_path / "photo.png", person=True)
    press(desk, "set-mode", "ArrowRight")
    press(desk, "set-max_bytes", *["ArrowRight"] * 2)
    assert desk.page.inner_text("#set-max_bytes-text") == "3 KB"
    choose(desk, source, "keys")
    desk.wait_for_status("done")
    saved = save(desk, "keys")
    assert 0.7 * 3000 < saved.stat().st_size <= 3000
    target = read_image(source)
    stated = float(desk.page.locator("#fit-figures tr", has_text="Closeness").inner_text().split()[1])
    assert abs(psnr(draw_like(saved.read_bytes(), target), target) - stated) < 0.01
    # Less: it goes on from there, and the page compares in the right units.
    with desk.fitting():
        press(desk, "set-max_bytes", "ArrowLeft")
    assert save(desk, "keys").stat().st_size <= 2000
    desk.page.wait_for_function("() => /^[\\d.]+ dB$/.test(document.getElementById('shown-psnr').textContent)")
    shown = float(desk.page.inner_text("#shown-psnr").split()[0])
    stated = float(desk.page.locator("#fit-figures tr", has_text="Closeness").inner_text().split()[1])
    assert abs(shown - stated) < 1.0


def write_landscape(path: Path) -> Path:
    """Write a picture like a photo, of 216 x 144 pixels: sky, hills, light and texture at all scales."""
    rng = np.random.default_rng(2)
    height, width = 144, 216
    y, x = np.mgrid[0:height, 0:width] / height
    texture = np.zeros((height, width))
    for octave in range(2, 7):
        coarse = Image.fromarray(rng.normal(size=(2**octave, 2**octave)).astype(np.float32))
        texture += np.asarray(coarse.resize((width, height), Image.Resampling.BICUBIC)) / 2**octave
    hill = y > 0.45 + 0.12 * np.sin(5 * x) + 0.3 * texture
    sky = np.stack([0.45 + 0.3 * y, 0.6 + 0.2 * y, 0.9 - 0.1 * y], -1) + 0.25 * texture[..., None].clip(0)
    ground = np.stack([0.3 + 0.2 * x, 0.4 - 0.1 * y, 0.2 + 0.0 * x], -1) * (1 + 1.2 * texture[..., None])
    image = np.where(hill[..., None], ground, sky) + rng.normal(0, 0.01, (height, width, 3))
    Image.fromarray((255 * image.clip(0, 1)).astype(np.uint8)).save(path)
    return path


# With the mouse alone.
def test_a_picture_found_to_be_a_photo_becomes_a_file_of_7_kilobytes(desk: DeskPage, tmp_path: Path) -> None:
    source = write_landscape(tmp_path / "landscape.png")
    desk.drag_slider("set-max_bytes", 4)
    assert desk.page.inner_text("#set-max_bytes-text") == "7 KB"
    choose(desk, source, "mouse")
    desk.wait_for_status("done")
    assert desk.page.inner_text("#found") == "found: photo"
    saved = desk.save()
    assert 0.9 * 7000 < saved.stat().st_size <= 7000
    target = read_image(source)
    found = psnr(draw_like(saved.read_bytes(), target), target)
    stated = float(desk.page.locator("#fit-figures tr", has_text="Closeness").inner_text().split()[1])
    assert abs(found - stated) < 0.01
    assert found > 30


def move_cross(desk: DeskPage, x: float, y: float) -> None:
    """Move the cross for keys to the point x, y of the drawing."""
    for (less, more), gap in zip((("Left", "Right"), ("Up", "Down")), desk.caret_gap(x, y), strict=True):
        far, near = divmod(round(abs(gap)), 10)
        arrow = f"Arrow{more if gap > 0 else less}"
        for key in [arrow] * far + [f"Control+{arrow}"] * near:
            desk.page.keyboard.press(key)


def lasso(desk: DeskPage, way: str, *points: tuple[float, float]) -> None:
    """Erase what lies within a line through ``points`` of the drawing, all of which are in view."""
    page = desk.page
    if way == "mouse":
        page.locator("#tools label:has([value=lasso])").click()
        desk.drag(*points)
    else:
        for key in ("c", "o"):
            page.keyboard.press(key)
        for number, point in enumerate(points):
            move_cross(desk, *point)
            if number in (0, len(points) - 1):
                page.keyboard.press("Space")
    page.wait_for_function("() => document.getElementById('message').textContent.startsWith('Erased')")


class Mouse:
    """The steps of the removal of a person, without a key."""

    def __init__(self, desk: DeskPage) -> None:
        self.desk, self.page = desk, desk.page

    def set_up(self) -> None:
        self.page.locator("#set-mode label").nth(1).click()
        self.desk.drag_slider("set-detail", 4)

    def begin_editing(self) -> None:
        self.page.locator("#sides label").nth(1).click()

    def delete_at(self, x: float, y: float) -> None:
        self.desk.click(x, y)
        self.page.locator("#delete").click()

    def fit_again(self) -> None:
        self.page.locator("#fit-again").click()
        self.page.locator("#sides label").nth(0).click()


class Keys:
    """The same without a mouse."""

    def __init__(self, desk: DeskPage) -> None:
        self.desk, self.page = desk, desk.page

    def set_up(self) -> None:
        press(self.desk, "set-mode", "ArrowRight")
        press(self.desk, "set-detail", "Home", *["ArrowRight"] * 4)

    def begin_editing(self) -> None:
        press(self.desk, "side", "ArrowRight")
        self.page.keyboard.press("c")

    def delete_at(self, x: float, y: float) -> None:
        """Move the cross to the point, and click with it."""
        move_cross(self.desk, x, y)
        self.page.keyboard.press("Enter")
        self.page.keyboard.press("Delete")

    def fit_again(self) -> None:
        press(self.desk, "fit-again", "Enter")
        press(self.desk, "side", "ArrowLeft")


@pytest.mark.parametrize("way", ["mouse", "keys"])
def test_a_person_is_removed_and_the_wall_goes_on(desk: DeskPage, tmp_path: Path, way: str) -> None:
    source = write_scene(tmp_path / "photo.png", person=True)
    wall = read_image(write_scene(tmp_path / "wall.png", person=False))
    hand: Mouse | Keys = Mouse(desk) if way == "mouse" else Keys(desk)
    hand.set_up()
    choose(desk, source, way)
    desk.wait_for_status("done")
    before = draw_like(save(desk, way).read_bytes(), wall)
    count = desk.paths()
    hand.begin_editing()
    # The paths that are dark in the middle are the person.
    for _ in range(count):
        if desk.color(80, 64)[0] > 90:
            break
        hand.delete_at(80, 64)
    deleted = count - desk.paths()
    assert deleted > 0
    with desk.fitting():
        hand.fit_again()
    assert desk.paths() >= count - deleted
    after = draw_like(save(desk, way).read_bytes(), wall)
    assert psnr(after, wall) > psnr(before, wall) + 5
    assert psnr(after, wall) > 24


@pytest.mark.parametrize("way", HANDS)
def test_a_person_is_cut_out_with_the_lasso_and_the_file_keeps_to_its_size(
    desk: DeskPage, tmp_path: Path, way: str
) -> None:
    source = write_scene(tmp_path / "photo.png", person=True)
    wall, hand = read_image(write_scene(tmp_path / "wall.png", person=False)), HANDS[way](desk)
    if way == "mouse":
        desk.page.locator("#set-mode label").nth(1).click()
        desk.drag_slider("set-max_bytes", 4)
    else:
        press(desk, "set-mode", "ArrowRight")
        press(desk, "set-max_bytes", *["ArrowRight"] * 4)
    hand.choose(source)
    desk.wait_for_status("done")
    hand.turn_to("edit")
    shown = desk.page.evaluate("() => warpvecView.drawingText()")
    units = int(shown.split('viewBox="0 0 ')[1].split()[0]) / 160  # a short file has several in a pixel
    lasso(desk, way, *((units * x, units * y) for x, y in ((62, 30), (98, 30), (98, 98), (62, 98), (62, 30))))
    with desk.fitting():
        hand.click("fit-again")
    hand.turn_to("make")
    saved = hand.save("svg")
    assert saved.stat().st_size <= 7000
    assert psnr(draw_like(saved.read_bytes(), wall), wall) > 24


@pytest.mark.parametrize("way", HANDS)
def test_a_scan_loses_its_paper_and_becomes_a_pdf(desk: DeskPage, tmp_path: Path, way: str) -> None:
    pytest.importorskip("cairosvg")
    rng, hand = np.random.default_rng(3), HANDS[way](desk)
    scan = np.full((100, 140, 3), (236.0, 232.0, 220.0))
    scan[20:80, 20:70], scan[40:60, 90:120] = (180, 40, 40), (30, 80, 160)
    source = tmp_path / "scan.png"
    Image.fromarray((scan + rng.normal(0, 1.5, scan.shape)).clip(0, 255).astype(np.uint8)).save(source)
    hand.choose(source)
    desk.wait_for_status("done")
    assert desk.color(130, 10) != (255, 255, 255)
    with desk.fitting():
        hand.click("set-paper")
    assert desk.color(130, 10) == (255, 255, 255)
    saved = hand.save("svg").read_text()
    assert 'id="background"' not in saved
    assert hand.save("pdf").read_bytes().startswith(b"%PDF")


@pytest.mark.parametrize(("label", "button", "start"), [
    ("My cutter or laser", "Save DXF", b"  0\nSECTION"),
    ("An Android app", "Save XML", b"<vector xmlns:android"),
    ("Cricut", "Save SVG", b"<?xml"),
])  # fmt: skip
def test_a_file_is_saved_for_what_it_is_for(
    desk: DeskPage, tmp_path: Path, label: str, button: str, start: bytes
) -> None:
    pytest.importorskip("ezdxf")
    expect = pytest.importorskip("playwright.sync_api").expect
    desk.drop(write_logo(tmp_path / "logo.png"))
    desk.wait_for_status("done")
    desk.page.set_viewport_size({"width": 1280, "height": 720})
    uses = desk.page.get_by_label("For", exact=True)
    expect(uses).to_be_in_viewport(ratio=1.0)  # nobody has to look for it, nor to scroll
    uses.select_option(label=label)
    chosen = desk.page.get_by_role("button", name=button, exact=True).last
    expect(chosen).to_be_in_viewport(ratio=1.0)
    with desk.page.expect_download() as download:
        chosen.click()
    assert Path(download.value.path()).read_bytes().replace(b"\r", b"").startswith(start)
    assert desk.page.inner_text("#message").startswith("Saved logo.")
