"""Test LPIPS in the benchmarks: measured with the given weights, or not at all."""

from __future__ import annotations

import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import click
import lpips_metric
import numpy as np
import paper_fits
import pytest
import torch
from PIL import Image


class FakeLpips(torch.nn.Module):
    """A backbone of one layer, named as in the package, and a distance that reveals its weights and its input."""

    def __init__(self, *, net: str, pnet_rand: bool, verbose: bool) -> None:
        super().__init__()
        assert (pnet_rand, verbose) == (True, False)
        self.net = torch.nn.ModuleDict({"slice5": torch.nn.Sequential()})
        self.net["slice5"].add_module("28" if net == "vgg" else "10", torch.nn.Conv2d(1, 1, 1))

    def forward(self, a: torch.Tensor, b: torch.Tensor) -> torch.Tensor:
        assert a.shape[:2] == b.shape[:2] == (1, 3)
        assert a.dtype == torch.float32
        assert a.min() >= -1 and a.max() <= 1
        weight = next(self.net.parameters())
        return (weight * (a - b).abs().mean()).sum()


@pytest.fixture
def lpips_package(monkeypatch: pytest.MonkeyPatch) -> None:
    module = ModuleType("lpips")
    module.LPIPS = FakeLpips  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "lpips", module)


def weights_file(path: Path, layer: int = 28, weight: float = 3.0) -> Path:
    weights = {"weight": torch.full((1, 1, 1, 1), weight), "bias": torch.zeros(1)}
    torch.save({f"features.{layer}.{name}": value for name, value in weights.items()}, path)
    return path


@pytest.mark.usefixtures("lpips_package")
@pytest.mark.parametrize(("layer", "net"), [(28, "vgg"), (10, "alex")])
def test_the_backbone_gets_the_weights_of_the_file(layer: int, net: str, tmp_path: Path) -> None:
    metric = lpips_metric.Lpips(weights_file(tmp_path / "w.pth", layer))
    black, white = np.zeros((8, 8, 3), np.uint8), np.full((8, 8, 3), 255, np.uint8)
    assert metric(black, white) == pytest.approx(3.0 * 2.0)
    assert metric(white, white) == 0
    assert metric.name.startswith(f"{net} ")


@pytest.mark.usefixtures("lpips_package")
def test_lpips_is_added_to_existing_fits(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    gradient = np.linspace(0, 255, 32 * 48 * 3).astype(np.uint8).reshape(32, 48, 3)
    Image.fromarray(gradient).save(tmp_path / "photo.png")
    case = paper_fits.Case(paper_fits.Photo(tmp_path / "photo.png"), "default", {"curves": 4, "iterations": 3})
    out = tmp_path / "x.csv"
    first = paper_fits.Fits(out).row(case)
    monkeypatch.setattr(paper_fits, "fit_photo", lambda *_, **__: pytest.fail("fitted again"))
    lpips = lpips_metric.Lpips(weights_file(tmp_path / "w.pth"))
    row = paper_fits.Fits(out, lpips).row(case)
    changed = {name for name in row if row[name] != first[name]}
    assert changed == {"soft_lpips", "file_lpips", "lpips_weights"}
    fits = paper_fits.Fits(out, lpips)
    for name, image in (("soft_lpips", fits.soft(case)), ("file_lpips", fits.file(case))):
        assert float(row[name]) == pytest.approx(6 * np.abs(image / 255 - gradient / 255).mean(), rel=1e-5)
    assert fits.row(case) == paper_fits.Fits(out).row(case) == row
    assert len(out.read_text().splitlines()) == 3
    other = lpips_metric.Lpips(weights_file(tmp_path / "other.pth", weight=6.0))
    doubled = paper_fits.Fits(out, other).row(case)
    assert float(doubled["soft_lpips"]) == pytest.approx(2 * float(row["soft_lpips"]))


@pytest.mark.usefixtures("lpips_package")
@pytest.mark.parametrize(
    ("content", "message"),
    [
        ({"features.28.weight": torch.ones(1)}, "must hold every layer of its backbone"),
        ({"features.28.weight": torch.ones(2), "features.28.bias": torch.ones(1)}, "must hold every layer"),
        ({"classifier.weight": torch.ones(1)}, "must be torchvision's VGG16 or AlexNet"),
        ([1, 2], "must be a state dict"),
    ],
)
def test_wrong_weights_are_a_usage_error(content: Any, message: str, tmp_path: Path) -> None:
    torch.save(content, tmp_path / "w.pth")
    with pytest.raises(click.UsageError, match=f"--lpips-weights {message}"):
        lpips_metric.Lpips(tmp_path / "w.pth")


def test_a_wrong_file_and_a_missing_package_are_usage_errors(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "w.txt").write_text("no weights")
    with pytest.raises(click.UsageError, match="must be a state dict that torch saved"):
        lpips_metric.Lpips(tmp_path / "w.txt")
    monkeypatch.setitem(sys.modules, "lpips", None)
    with pytest.raises(click.UsageError, match="needs the package lpips"):
        lpips_metric.Lpips(weights_file(tmp_path / "w.pth"))
