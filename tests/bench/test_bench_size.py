"""Test the reports of bench_size and bench_startup. No test asserts a time."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import bench_fit
import bench_size as size
import bench_startup as startup
import click
import numpy as np
import pytest
import torch
import watched_run as watched
from click.testing import CliRunner
from PIL import Image
from scenes import random_scene

from warpvec.config.presets import make_config
from warpvec.geometry.scene import Scene

BENCH = str(Path(__file__).parents[2] / "bench")


@dataclass
class FakeProgress:
    seconds: float
    curve_count: int


def sized(width: int, height: int, fitted: tuple[int, int], curves: int, peak: float) -> Any:
    seen = {"fitted": list(fitted), "peak_bytes": peak, "fit_seconds": 2.0, "step": 0.01, "change": 0.1}
    seen |= {"pairs": 1000, "partial_pairs": 500}
    return size.SizedRun((width, height), {"curves": curves, "psnr": 25.0}, seen, 4.0, 50.0)


def test_a_watch_separates_steps_from_changes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Four steps of 1 s, a change of the population before a slow step, then steps of 3 s with all paths."""
    seconds = [1.0, 2.0, 3.0, 4.0, 11.0, 14.0, 17.0, 20.0, 23.0, 26.0]
    curves = [4, 4, 4, 4, 8, 8, 8, 8, 8, 8]
    seen = []

    def fit(target: torch.Tensor, config: Any, on_progress: Any, *, start: str) -> Any:
        assert start == "given"
        for lap in zip(seconds, curves, strict=True):
            on_progress(FakeProgress(*lap))
        return FakeProgress(26.0, 8)

    watch = watched.Watch(fit)
    result = watch(torch.zeros(24, 32, 3), make_config(), seen.append, start="given")
    assert result.curve_count == 8
    assert len(seen) == 10
    found = watch.describe()
    assert (found["step"], found["change"], found["fitted"]) == (3.0, 4.0, [32, 24])
    assert found["first_iteration"] > 1e9


def test_pairs_of_the_fitted_scene_are_counted() -> None:
    """The scene is a rectangle over 2 x 3 tiles."""
    tensors = random_scene(0, 1, 64, 64)
    corner = torch.tensor([[1.0, 1.0], [31.0, 1.0], [31.0, 47.0], [1.0, 47.0]])
    points = torch.stack([corner + (corner.roll(-1, 0) - corner) * k / 3 for k in range(3)], 1).reshape(1, 12, 2)
    scene = Scene.uniform(
        points, tensors.color.float(), torch.ones(1), torch.zeros(3), torch.zeros(1, dtype=torch.long)
    )
    watch = watched.Watch(lambda *_: None)
    watch.fitted, watch.height, watch.width, watch.threads = type("Fitted", (), {"scene": scene}), 64, 64, 1
    assert watched.count_pairs(watch) == {"pairs": 6, "partial_pairs": 6}


def test_the_peak_is_that_of_the_process_itself_in_bytes() -> None:
    """The peak of a child must not include that of this process, which is larger."""
    code = "from watched_run import peak_bytes; before = peak_bytes(); b'x' * 300_000_000; print(before, peak_bytes())"
    child = bench_fit.run_child(["-c", f"import sys; sys.path.append({BENCH!r}); {code}"])
    before, after = map(int, child.stdout.split())
    assert before < 60e6
    assert before + 250e6 < after < before + 350e6


def test_the_memory_formula_is_found() -> None:
    def peak(photo: float, fitted: float, curves: float) -> float:
        return 1e6 * (400 + 30 * photo + 60 * fitted + 5 * curves)

    shapes = [(1000, 1000, 500, 500, 1000), (2000, 1000, 500, 500, 4000), (2000, 2000, 1000, 1000, 1000)]
    shapes += [(3000, 2000, 1000, 500, 2000), (1000, 500, 1000, 500, 8000)]
    runs = [
        sized(w, h, (fw, fh), curves, peak(w * h / 1e6, fw * fh / 1e6, curves / 1e3)) for w, h, fw, fh, curves in shapes
    ]
    text = size.memory_formula(runs)
    assert "400 MB + 30 MB a megapixel of the photo + 60 MB a megapixel fitted + 5 MB a thousand curves" in text
    assert "within 0%" in text
    assert "60" not in size.memory_formula(runs[2:4])
    assert size.memory_formula(runs[:1]) == ""


def test_a_row_is_a_ratio_to_the_first() -> None:
    first, other = sized(768, 512, (768, 512), 512, 5e8), sized(4000, 3000, (1024, 768), 512, 1e9)
    cells = dict(zip(size.HEADER, other.cells(first), strict=True))
    assert (cells["photo"], cells["fitted"], cells["/ first"]) == ("4000x3000", "1024x768", "1.00")
    assert (cells["step ms"], cells["ns a pair"], cells["ns a partial"]) == ("10.0", "10000", "20000")
    assert cells["peak MB"] == "1000"


def test_a_whole_run_is_estimated_from_all_steps_and_changes() -> None:
    """The default preset with 512 paths has 2000 iterations, 5 inflations and 56 recyclings."""
    seen = {"fit_seconds": 2.0, "step": 0.01, "change": 0.1}
    config = make_config(curves=512)
    changes = 5 + int(config.recycle_until * config.iterations / config.recycle_gap)
    assert size._whole_run(4.0, seen, {"curves": 512, "iterations": 60}, "default") == pytest.approx(
        4.0 - 2.0 + 0.01 * config.iterations + 0.1 * changes
    )


@pytest.mark.parametrize("text", ["768", "768x", "768x0", "768x512 ", "axb"])
def test_wrong_sizes_are_refused(text: str) -> None:
    with pytest.raises(click.BadParameter):
        size._sizes(None, None, text)
    assert size._sizes(None, None, "768x512,10x20") == [(768, 512), (10, 20)]
    assert size._fit_sizes(None, None, "photo,1024") == [None, 1024]


def test_a_run_reports_sizes_pairs_and_peak(tmp_path: Path) -> None:
    """A real run on a resampled photo that is fitted at half its size."""
    noise = np.random.default_rng(0).integers(0, 256, (24, 40, 3), dtype=np.uint8)
    Image.fromarray(noise).save(tmp_path / "photo.png")
    arguments = ["--photo", tmp_path / "photo.png", "--sizes", "80x48", "--fit-size", "40", "--curves", "6"]
    arguments += ["--iterations", "6", "--cache", tmp_path, "--set", "initial_curves=3"]
    result = CliRunner().invoke(size.main, list(map(str, arguments)), catch_exceptions=False)
    assert result.exit_code == 0, result.output
    (row,) = json.loads(result.stdout.splitlines()[-1])["runs"]
    assert (row["size"], row["seen"]["fitted"]) == ([80, 48], [40, 24])
    assert (row["metrics"]["curves"], row["metrics"]["iterations"]) == (6, 6)
    assert row["seen"]["pairs"] >= 6
    assert 50e6 < row["seen"]["peak_bytes"] < 50e9


def test_startup_subtracts_a_cached_run_from_a_cold_one(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    held = []

    def run_child(arguments: list[Any], environment: dict[str, str] | None = None) -> Any:
        if environment is not None:
            held.append(list(Path(environment["WARP_CACHE_PATH"]).iterdir()))
        line = json.dumps({"first_iteration": startup.time.time() + 0.5, "first_cpu": 0.25})
        return bench_fit.Run(9.0 if environment else 2.0, 1.5, 1, f"metrics\n{line}\n")

    monkeypatch.setattr(startup, "run_child", run_child)
    (tmp_path / "a.png").touch()
    result = CliRunner().invoke(startup.main, [str(tmp_path / "a.png"), "--repeat", "2"], catch_exceptions=False)
    assert held == [[]]
    assert "a first run takes 7.0 s longer" in result.stdout
    found = json.loads(result.stdout.splitlines()[-1])["ms"]
    assert found[startup._FIRST]["median"] == pytest.approx(500, abs=100)
    assert found[startup._FIRST]["cpu_median"] == 250


def test_a_fit_is_compared_with_vtracer_on_the_same_image() -> None:
    def case(name: str, how: str, *walls: float) -> Any:
        runs = [bench_fit.Run(wall, wall, 1, "") for wall in walls]
        return bench_fit.Case(Path(name), how, runs, {"curves": 512})

    cases = [case("a", "draft", 3, 4, 8), case("a", "best", 20), case("a", "vtracer, speckle 2", 2)]
    cases += [case("b", "draft", 5), case("b", "vtracer, speckle 9", 10)]
    ratios = [line.split(": ")[1].split()[0] for line in bench_fit.vtracer_ratios(cases)]
    assert ratios == ["2.00", "10.00", "0.50"]
    assert bench_fit.vtracer_ratios(cases[:2]) == []
