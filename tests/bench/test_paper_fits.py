"""Test the fits behind the paper's tables: their measures and their files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click
import numpy as np
import paper_fits
import pytest
from PIL import Image

from warpvec.image.metrics import psnr


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with two smooth photos of 48 x 32 pixels."""
    path = tmp_path / "photos"
    path.mkdir()
    x, y = np.meshgrid(np.linspace(0, 1, 48), np.linspace(0, 1, 32))
    for name, channels in {"kodim01": (x, y, x * y), "kodim07": (x, 1 - x, (x - 0.5) ** 2 + y**2)}.items():
        Image.fromarray((255 * np.stack(channels, -1).clip(0, 1)).astype(np.uint8)).save(path / f"{name}.png")
    return path


@pytest.fixture
def case(folder: Path) -> Any:
    """A fast fit."""
    photo = paper_fits.Photo(folder / "kodim07.png")
    return paper_fits.Case(photo, "paper", {"iterations": 3, "samples": 6, "lines": 2, "curves": 5})


def test_numbers_are_those_of_the_scene_and_of_the_file(folder: Path, tmp_path: Path) -> None:
    """The soft PSNR is that of the fit; the file's PSNR is that of the drawn SVG text."""
    settings = {"iterations": 3, "samples": 6, "lines": 2, "curves": 5}
    photo = paper_fits.Photo(folder / "kodim07.png")
    for preset in ("paper", "default"):
        given = settings if preset == "paper" else {"iterations": 3, "curves": 5}
        fits = paper_fits.Fits(tmp_path / "x.csv")
        row = fits.row(case := paper_fits.Case(photo, preset, given))
        result = paper_fits.fit_photo(photo.pixels / np.float32(255), case.config, title="kodim07")
        # For the exact renderer, the internal PSNR is that of the file's scene, whose numbers are rounded.
        assert float(row["soft_psnr"]) == pytest.approx(result.metrics["internal_psnr"], abs=1e-2)
        # One compares with the photo in 8 bits, the other with the same values divided by 255 in float32.
        assert float(row["file_psnr"]) == pytest.approx(result.metrics["psnr"], abs=1e-5)
        assert float(row["file_ssim"]) == pytest.approx(result.metrics["ssim"], abs=1e-5)
        assert (row["iterations"], row["curves"], int(row["bytes"])) == ("3", "5", result.metrics["bytes"])
        assert float(row["soft_psnr"]) == psnr(fits.soft(case), photo.pixels)


def test_a_fit_whose_scene_is_gone_is_made_again(case: Any, tmp_path: Path) -> None:
    first = paper_fits.Fits(tmp_path / "x.csv").row(case)
    (scene,) = tmp_path.glob("x.fits/*.npz")
    scene.unlink()
    second = paper_fits.Fits(tmp_path / "x.csv").row(case)
    assert {**first, "seconds": ""} == {**second, "seconds": ""}
    assert scene.exists()
    assert len((tmp_path / "x.csv").read_text().splitlines()) == 3


def test_an_interrupted_fit_is_not_kept(case: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fit_photo = paper_fits.fit_photo

    def interrupted(*args: Any, **settings: Any) -> Any:
        result = fit_photo(*args, **settings)
        object.__setattr__(result.fitted, "interrupted", True)
        return result

    monkeypatch.setattr(paper_fits, "fit_photo", interrupted)
    with pytest.raises(click.Abort):
        paper_fits.Fits(tmp_path / "x.csv").row(case)
    assert not list(tmp_path.glob("x.*"))


def test_photos_are_chosen_by_name_and_reduced_by_scale(folder: Path) -> None:
    photos = paper_fits.choose_photos(folder, ["kodim07", "kodim01"], 0.5)
    assert [(photo.name, photo.pixels.shape) for photo in photos] == [
        ("kodim07", (16, 24, 3)),
        ("kodim01", (16, 24, 3)),
    ]
    whole = np.asarray(Image.open(folder / "kodim01.png"))
    assert np.array_equal(paper_fits.Photo(folder / "kodim01.png").pixels, whole)
    means = whole.reshape(16, 2, 24, 2, 3).mean((1, 3))
    assert np.abs(photos[1].pixels - means).mean() < 1
    assert [photo.name for photo in paper_fits.choose_photos(folder, None, 1.0)] == ["kodim01", "kodim07"]


def test_keys_depend_on_photo_scale_settings_and_frames(folder: Path) -> None:
    small, other = paper_fits.choose_photos(folder, None, 0.5)
    photos = (small, other, paper_fits.Photo(small.path))
    cases = [paper_fits.Case(photo, "paper", {}) for photo in photos]
    cases += [paper_fits.Case(small, "default", {}), paper_fits.Case(small, "paper", {"threads": 2})]
    cases += [paper_fits.Case(small, "paper", {}, every) for every in (2, 3)]
    assert len({case.key for case in cases}) == 7
    # A setting that is equal to the preset's does not change the key.
    assert paper_fits.Case(small, "paper", {"inflation_gap": 100}).key == cases[0].key
