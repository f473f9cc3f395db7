"""Test the scenes of the benchmarks, the rivals and the roof. No test asserts a time."""

from __future__ import annotations

import json
import sys
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import bench_scenes as scenes
import bench_step
import click
import cost_model
import harness
import numpy as np
import pytest
import rivals
import roofline
import torch
from click.testing import CliRunner
from PIL import Image

import warpvec
from warpvec.config.presets import make_config
from warpvec.geometry.circles import circle_points
from warpvec.geometry.scene import Scene


@pytest.fixture
def photos(tmp_path: Path) -> Path:
    """A folder with a noisy kodim07.png of 60 x 40 pixels."""
    folder = tmp_path / "photos"
    folder.mkdir()
    noise = np.random.default_rng(0).integers(0, 256, (40, 60, 3), dtype=np.uint8)
    Image.fromarray(noise).save(folder / "kodim07.png")
    return folder


def two_circles() -> Scene:
    points = circle_points(torch.tensor([[12.0, 10.0], [20.0, 14.0]]), torch.tensor([8.0, 6.0]), 4)
    color = torch.tensor([[0.9, 0.2, 0.1], [0.1, 0.3, 0.8]])
    opacity, background = torch.tensor([1.0, 0.6]), torch.tensor([0.2, 0.5, 0.4])
    return Scene.uniform(points, color, opacity, background, torch.zeros(2, dtype=torch.long))


# Scenes


def test_a_named_scene_is_a_fit_of_the_resampled_photo(
    photos: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    small = scenes.NamedScene("kodim07.png", 32, 24, 7, 5)
    monkeypatch.setitem(scenes.SCENES, "small", small)
    subject = scenes.named_subject("small", photos, tmp_path / "cache", {"initial_curves": 7})
    assert subject.target.shape == (24, 32, 3)
    assert (subject.config.curves, subject.config.iterations, subject.config.fit_size) == (7, 5, 32)
    assert len(scenes.load_scene(subject.path)) == 7
    monkeypatch.setattr(scenes, "fit", lambda *_: pytest.fail("fitted again"))
    assert scenes.named_subject("small", photos, tmp_path / "cache", {"initial_curves": 7}).path == subject.path


def test_a_photo_is_cropped_to_the_proportions_and_not_stretched(tmp_path: Path) -> None:
    """A ramp along x is doubled in size and cropped by a quarter on both sides, or left as it is."""
    ramp = np.broadcast_to(np.arange(64, dtype=np.uint8)[None, :, None] * 4, (32, 64, 3))
    photo = tmp_path / "ramp.png"
    Image.fromarray(np.ascontiguousarray(ramp)).save(photo)
    with Image.open(scenes.resampled_photo(photo, 64, 64, tmp_path)) as image:
        got = np.asarray(image)[32, :, 0]
    np.testing.assert_allclose(got, 4 * (16 + (np.arange(64) - 0.5) / 2), atol=1.5)
    assert scenes.resampled_photo(photo, 64, 32, tmp_path) == photo


def test_a_missing_scene_is_a_usage_error(photos: Path, tmp_path: Path) -> None:
    with pytest.raises(click.UsageError, match="kodim07-1024"):
        scenes.scene_file("kodim07-1")
    with pytest.raises(click.UsageError, match="--photos must be a folder with kodim07.png"):
        scenes.named_subject("kodim07-256", tmp_path, tmp_path, {})
    assert scenes.scene_file(None) is None
    assert scenes.scene_file(str(photos / "kodim07.png")) == photos / "kodim07.png"


def test_step_of_a_named_scene(photos: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(scenes.SCENES, "small", scenes.NamedScene("kodim07.png", 48, 32, 9, 4))
    monkeypatch.setattr(roofline, "_STREAM_FLOATS", 1000)
    monkeypatch.setattr(roofline, "_MATRIX_SIDE", 16)
    arguments = ["--scene", "small", "--photos", photos, "--cache", tmp_path, "--threads", "1", "--repeat", "1"]
    arguments += ["--diffvg", "no_such_module", "--set", "initial_curves=9"]
    result = CliRunner().invoke(bench_step.main, list(map(str, arguments)), catch_exceptions=False)
    assert result.exit_code == 0, result.output
    line = json.loads(result.stdout.splitlines()[-1])
    assert (line["counts"]["paths"], line["size"]) == (9, "48 x 32")
    resvg, diffvg = line["rivals"]
    assert resvg["ms"]["median"] > 0
    assert diffvg["ms"] is None
    assert "no_such_module" in diffvg["skipped"]
    assert "| compositing_adjoint |" in result.stdout.split("step, 1 thr. | MB")[1]


# DiffVG: a stand-in with its interface, which draws with warpvec, checks the scene that it gets.


@dataclass
class FakePath:
    num_control_points: torch.Tensor
    points: torch.Tensor
    is_closed: bool


@dataclass
class FakeGroup:
    shape_ids: torch.Tensor
    fill_color: torch.Tensor
    use_even_odd_rule: bool


class FakeDiffvg(ModuleType):
    """The part of pydiffvg that a step uses; it keeps the scenes that it draws."""

    Path, ShapeGroup = FakePath, FakeGroup

    def __init__(self) -> None:
        super().__init__("pydiffvg")
        self.RenderFunction = self
        self.drawn: list[list[Any]] = []

    def set_use_gpu(self, wanted: bool) -> None:
        self.on_gpu = wanted

    def serialize_scene(self, width: int, height: int, shapes: list[FakePath], groups: list[FakeGroup]) -> list[Any]:
        assert [group.shape_ids.tolist() for group in groups] == [[row] for row in range(len(shapes))]
        return [width, height, shapes, groups]

    def apply(self, width: int, height: int, x: int, y: int, seed: int, background: None, *scene: Any) -> torch.Tensor:
        assert (x, y, seed, background) == (2, 2, 0, None)
        assert scene[:2] == (width, height)
        self.drawn.append(list(scene[2:]))
        shapes, groups = scene[2:]
        assert all(shape.num_control_points.tolist() == [2, 2, 2, 2] and shape.is_closed for shape in shapes)
        assert not any(group.use_even_odd_rule for group in groups)
        points = torch.stack([shape.points for shape in shapes])
        paint = torch.stack([group.fill_color for group in groups])
        paths = (points, paint[:, :3], paint[:, 3])
        black, white = (
            warpvec.render(
                Scene.uniform(*paths, torch.full((3,), matte), torch.zeros(len(points)).long()), height, width
            )
            for matte in (0.0, 1.0)
        )
        alpha = 1.0 - (white - black).mean(-1, keepdim=True)
        return torch.cat([black / alpha.clamp_min(1e-6), alpha], -1)


def test_diffvg_gets_the_scene_and_returns_the_loss_and_its_gradient() -> None:
    library, scene, target = FakeDiffvg(), two_circles(), torch.rand(24, 32, 3)
    loss = rivals.diffvg_step(library, scene, target)()
    points = scene.points.clone().requires_grad_()
    ours = warpvec.render(
        Scene.uniform(points, *(getattr(scene, n) for n in ("color", "opacity", "background", "generation"))), 24, 32
    )
    want = (ours - target).square().mean()
    want.backward()
    assert not library.on_gpu
    assert loss.item() == pytest.approx(want.item(), rel=1e-4)
    shapes, groups = library.drawn[0]
    assert torch.equal(groups[1].fill_color.detach(), torch.tensor([0.1, 0.3, 0.8, 0.6]))
    assert points.grad is not None
    for shape, expected in zip(shapes, points.grad, strict=True):
        torch.testing.assert_close(shape.points.grad, expected, rtol=1e-3, atol=1e-7)


def test_diffvg_is_timed_if_installed_and_skipped_if_it_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    library, scene, target = FakeDiffvg(), two_circles(), torch.rand(24, 32, 3)
    monkeypatch.setitem(sys.modules, "pydiffvg", library)
    timed = rivals.time_diffvg("pydiffvg", scene, target)
    assert timed.time.count == len(library.drawn) - 1
    rows = {"1 thr.": timed.time}
    assert "| DiffVG | forward and backward, 2x2 samples |" in rivals.report_rivals([timed], rows, rows)
    monkeypatch.setattr(library, "apply", lambda *_: pytest.fail("broken build", pytrace=False))
    monkeypatch.setattr(library, "serialize_scene", lambda *_: 1 / 0)
    failed = rivals.time_diffvg("pydiffvg", scene, target)
    assert failed.time is None
    assert "pydiffvg failed (ZeroDivisionError" in failed.skipped
    assert "| - | - |" in rivals.report_rivals([failed], rows, rows)


# The roof


def test_a_load_takes_the_longer_of_its_two_times() -> None:
    roof = roofline.Roof(bytes_per_second=1e9, flops_per_second=1e10)
    assert roofline.Load(bytes=2e6, flops=1e6).seconds(roof) == pytest.approx(2e-3)
    assert roofline.Load(bytes=2e6, flops=5e7).seconds(roof) == pytest.approx(5e-3)


def test_the_table_of_the_roof(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(roofline, "_STREAM_FLOATS", 1000)
    monkeypatch.setattr(roofline, "_MATRIX_SIDE", 16)
    threads = torch.get_num_threads()
    roof = roofline.measure_roof(threads=2)
    assert torch.get_num_threads() == threads
    assert min(roof) > 0
    work = cost_model.Work(1, 12, 40, 100, 6, 4, 5)
    row = harness.Statistics(2e-3, 1e-3, 0.0, 2e-3, 3)
    table = roofline.report_roofline(work, 1000, {"flattening": row, "coverage": row}, roofline.Roof(1e9, 1e9), "x")
    assert f"| flattening | 0.00 | 0.0 | 0.0 | 0.0 | arithmetic | {40 * 26e-6:.3f} | 1.000 |" in table
    assert "| sum of these |" in table


def test_settings_reach_a_named_scene(photos: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(scenes, "fitted_scene", lambda photo, target, config, cache: photo)
    subject = scenes.named_subject("kodim07-256", photos, tmp_path, {"xing_weight": 0.5})
    assert subject.config == make_config(curves=256, iterations=300, fit_size=768, xing_weight=0.5)
    assert subject.target.shape == (512, 768, 3)
