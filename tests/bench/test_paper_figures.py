"""Test the pictures of the paper's figures: colours, captions, the plot."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import paper
import paper_figures
import pytest
import torch
from PIL import Image
from stubs import circles


def test_layers_are_coloured_by_generation() -> None:
    scene = circles(32, 48, 33)
    colored = paper_figures.by_generation(scene)
    ends = torch.tensor([paper_figures.ramp(0.0), paper_figures.ramp(1.0)]) / 255
    torch.testing.assert_close(colored.color[[0, 32]], ends)
    assert len(colored.color.unique(dim=0)) == 3
    assert torch.equal(colored.points, scene.points)
    light = [sum(paper_figures.ramp(share)) for share in np.linspace(0, 1, 20)]
    assert light == sorted(light)


def test_a_sheet_contains_its_pictures_and_reduces_wide_ones() -> None:
    small, wide = np.full((10, 20, 3), 7, np.uint8), np.full((100, 800, 3), 9, np.uint8)
    tiles = [paper_figures.Tile(small, "small"), paper_figures.Tile(wide, "wide\ntwo lines")]
    pixels = np.asarray(paper_figures.sheet([tiles, tiles[:1]]))
    assert np.array_equal(pixels[:10, :20], small)
    left = pixels.shape[1] - 384
    assert (pixels[:48, left:] == 9).all()
    assert (pixels[48:, left:].min(2) < 128).any()
    second = np.flatnonzero((pixels[20:, 0] == 7).all(1)) + 20
    assert (second[0], len(second)) == (pixels.shape[0] - 10 - 24, 10)


def test_a_run_that_ended_earlier_shows_its_last_frame(tmp_path: Path) -> None:
    pixels = np.zeros((4, 4, 3), np.uint8)
    Image.fromarray(pixels).save(tmp_path / "photo.png")
    photo = paper.Photo(tmp_path / "photo.png")
    frames = {10: pixels + 255, 20: pixels}
    captions = [paper._frame(photo, "paper", frames, at).caption for at in (5, 19.9, 20, 99)]
    first, last = "paper\niteration 10, 0.00 dB", "paper\niteration 20, inf dB"
    assert captions == [first, first, last, last]


def test_the_plot(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib", reason="matplotlib is not installed")
    history = [{"iteration": k, "seconds": 0.1 * k, "psnr": 20.0 + k} for k in range(3)]
    paper_figures.plot_histories(tmp_path / "plot.png", {"a": history, "b": history}, "title")
    with Image.open(tmp_path / "plot.png") as image:
        assert image.width == 1200
        assert len(image.getcolors(image.width * image.height)) > 10
