"""Fits of a logo with soft edges and a hidden colour: the file looks right over any background."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
import torch
from commands import QUICK, assert_refused, invoke
from logo import GREEN, MAGENTA, logo, over_matte
from PIL import Image

import warpvec
from warpvec.config.presets import make_config
from warpvec.fit.loop import fit
from warpvec.image.metrics import psnr
from warpvec.svg.measure import draw


def checker(height, width):
    y, x = np.mgrid[:height, :width] // 8
    return np.where((x + y)[..., None] % 2, 0.8, 0.4) * np.ones(3)


@pytest.fixture(scope="module")
def result():
    """A quick fit of the logo at 320 x 240."""
    return warpvec.vectorize(logo(2), 32, preset="draft", iterations=120, device="cpu", mode="photo")


def test_the_logo_is_fitted_over_any_background(result):
    assert "<rect" not in result.svg()
    assert result.scene.transparent
    photo, inside = result.picture.pixels.astype(np.float64), result.render().astype(np.float64)
    file = draw(result.svg(), transparent=True) / 255
    assert inside.shape == file.shape == photo.shape == (240, 320, 4)
    for matte in (0.0, 1.0, checker(240, 320)):
        want = over_matte(photo, matte)
        quality = psnr(over_matte(file, matte), want)
        # 29.7 over black, 27.8 over white, 29.9 over the checker.
        assert quality > 26.5
        assert abs(quality - psnr(over_matte(inside, matte), want)) < 0.2
    assert result.metrics["transparent"]
    assert result.metrics["psnr"] == pytest.approx(psnr(file, photo), abs=1e-4)
    assert result.metrics["internal_psnr"] == pytest.approx(result.history[-1]["psnr"], abs=0.1)


def test_soft_alpha_is_kept(result):
    photo, file = result.picture.pixels, draw(result.svg(), transparent=True) / 255
    shadow = np.zeros((240, 320), bool)
    shadow[208:220, 120:160] = True
    assert 0.4 < photo[shadow][:, 3].mean() < 0.45
    assert file[shadow][:, 3].mean() == pytest.approx(photo[shadow][:, 3].mean(), abs=0.08)
    assert file[:30][..., 3].max() < 0.01


def test_no_fringe_of_the_hidden_colour_shows(result):
    matte = checker(240, 320)
    found, want = (
        over_matte(image, matte) for image in (draw(result.svg(), transparent=True) / 255, result.picture.pixels)
    )
    edge = (result.picture.pixels[..., 3] > 0) & (result.picture.pixels[..., 3] < 1)
    excess = [np.minimum(image[edge][:, 0], image[edge][:, 2]) - image[edge][:, 1] for image in (found, want)]
    # This would find magenta at full strength in a hundredth of the edge.
    assert (excess[0] - excess[1]).mean() < 0.01
    assert np.quantile(excess[0] - excess[1], 0.99) < 0.1


def test_the_hidden_colour_has_no_influence():
    def text(hidden: tuple[int, int, int]) -> str:
        settings = {"preset": "draft", "iterations": 12, "inflation_gap": 3, "fit_size": 100}
        return warpvec.vectorize(logo(hidden=hidden), 40, device="cpu", mode="photo", **settings).svg()

    assert text(MAGENTA) == text(GREEN)


@pytest.mark.parametrize("settings", [{"renderer": "splat"}, {"preset": "bezier-splatting"}, {"backdrop": "white"}])
def test_every_renderer_and_policy_takes_alpha(settings):
    fitted = warpvec.vectorize(logo(), 12, iterations=25, fit_size=60, device="cpu", mode="photo", **settings)
    assert fitted.scene.transparent
    assert fitted.soft_image().shape == (45, 60, 4)
    assert fitted.history[-1]["psnr"] == pytest.approx(fitted.metrics["internal_psnr"], abs=3)
    assert draw(fitted.svg(), transparent=True)[0, 0, 3] < 128


@pytest.mark.parametrize("alpha", [0.0, 0.4])
def test_an_image_of_one_alpha(alpha):
    target = torch.tensor([0.7, 0.2, 0.1, alpha]).repeat(20, 30, 1)
    fitted = fit(target, make_config("draft", curves=16, iterations=30, device="cpu"))
    assert fitted.history[-1]["psnr"] > 12
    assert fitted.scene.transparent
    assert torch.equal(fitted.scene.background, torch.zeros(3))


# The command line.


def test_run_and_eval_keep_alpha_and_say_so(tmp_path: Path):
    source, out = tmp_path / "logo.png", tmp_path / "logo.svg"
    Image.fromarray(logo()).save(source)
    folder = tmp_path / "frames"
    done = invoke("run", source, out, "--save-frames", folder, "--mode", "photo", *QUICK)
    assert done.exit_code == 0, done.output
    assert "(file drawn by resvg, over black and over white)" in done.stdout
    assert "<rect" not in out.read_text()
    with Image.open(folder / "frame-000003.png") as frame:
        assert frame.mode == "RGBA"
    again = invoke("eval", source, out)
    assert re.search(r"\(file drawn by resvg, over black and over white\)$", again.stdout.strip())


def test_a_background_flattens(tmp_path: Path):
    source, out = tmp_path / "logo.png", tmp_path / "logo.svg"
    Image.fromarray(logo()).save(source)
    done = invoke("run", source, out, "--background", "navy", "--mode", "photo", *QUICK)
    assert done.exit_code == 0, done.output
    assert "over black" not in done.stdout
    assert '<rect id="background"' in out.read_text()
    assert "over black" not in invoke("eval", source, out, "--background", "navy").stdout
    assert_refused(invoke("run", source, out, "--background", "sea", *QUICK), "background", "'sea'")
