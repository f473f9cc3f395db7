"""Test the shared parts of the benchmarks, bench_step, bench_fit and kodak. No test asserts a time."""

from __future__ import annotations

import itertools
import json
from pathlib import Path
from typing import Any

import bench_fit
import bench_scenes as scenes
import bench_step
import click
import fits
import harness
import kodak
import nodes
import numpy as np
import pytest
import torch
from click.testing import CliRunner, Result
from commands import write_photo

import warpvec
from warpvec.config.presets import make_config
from warpvec.fit.progress import FitResult
from warpvec.geometry.scene import Scene
from warpvec.geometry.structure import Structure

ROOT = Path(__file__).parents[2]

# Kernel files that are no stage of their own.
SHARED_KERNELS = {
    "__init__",
    "adan",
    "capacity",
    "bezier",
    "constants",
    "thread_pool",
    "edges",
    "gradients",
    "index_lanes",
    "lanes",
    "reductions",
}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with two noisy photos of 40 x 24 pixels and a text file."""
    path = tmp_path / "photos"
    path.mkdir()
    for seed, name in enumerate(("a.png", "b.png")):
        write_photo(path, name, 24, 40, seed)
    (path / "notes.txt").write_text("no photo")
    return path


def _invoke(command: click.Command, *arguments: object) -> Result:
    return CliRunner().invoke(command, [str(argument) for argument in arguments], catch_exceptions=False)


def _last_json(result: Result) -> dict[str, Any]:
    assert result.exit_code == 0, result.output
    line: dict[str, Any] = json.loads(result.stdout.splitlines()[-1])
    return line


def test_statistics_of_known_spans() -> None:
    spans = [harness.Span(wall, 2 * wall) for wall in (4.0, 1.0, 100.0, 3.0, 2.0)]
    assert harness.summarize(spans) == harness.Statistics(3.0, 1.0, 2.0, 6.0, 5)
    assert harness.summarize(spans[:1]) == harness.Statistics(4.0, 4.0, 0.0, 8.0, 1)


def test_laps_add_repeated_parts_and_compute_the_remainder(monkeypatch: pytest.MonkeyPatch) -> None:
    """The clock advances by 1 per reading, so an action takes 1, plus 2 for each action timed within it."""
    monkeypatch.setattr(harness.time, "perf_counter", map(float, itertools.count()).__next__)
    monkeypatch.setattr(harness.time, "process_time", map(float, itertools.count()).__next__)
    laps = harness.Laps()
    for parts in (1, 2):
        laps.start()
        laps.time("whole", lambda parts=parts: [laps.time("part", lambda: None) for _ in range(parts)])
    laps.remainder("rest", "whole", ["part", "absent"])
    medians = {name: row.median for name, row in laps.statistics().items()}
    assert medians == {"whole": 4.0, "part": 1.5, "rest": 2.5}


def test_settings_get_the_types_of_their_fields() -> None:
    texts = ("curves=7", "lr_scale=0.5", "flat=true", "compensate=False", "time_budget=3", "threads=2", "z_order=area")
    expected = {
        "curves": 7, "lr_scale": 0.5, "flat": True, "compensate": False,
        "time_budget": 3.0, "threads": 2, "z_order": "area",
    }  # fmt: skip
    assert harness.parse_settings(texts) == expected
    assert bench_fit.cli_options(expected)[2:6] == ["--lr-scale", "0.5", "--flat", "--no-compensate"]
    make_config(**expected)


@pytest.mark.parametrize("text", ["curve=7", "curves", "curves=many", "flat=perhaps"])
def test_wrong_settings_are_refused(text: str) -> None:
    with pytest.raises(click.BadParameter, match=text):
        harness.parse_settings([text])


def test_lists_of_counts_are_checked(folder: Path) -> None:
    result = _invoke(kodak.main, folder, "--curves", "256,0")
    assert result.exit_code == 2
    assert "'256,0'" in result.stderr


def test_machine_facts_include_versions_and_sources() -> None:
    facts = harness.machine_facts()
    assert facts["warpvec"] == warpvec.__version__
    # One of the two may have a local label, as in "2.13.0+cu130".
    assert facts["torch"].split("+")[0] == torch.__version__.split("+")[0]
    assert facts["source"] == harness.source_digest()
    json.dumps(facts)


def test_the_digest_covers_every_room_and_the_linked_kernels(tmp_path: Path) -> None:
    """kernels/ is a symbolic link, which globbing does not follow."""
    package, kernels = tmp_path / "warpvec", tmp_path / "kernels"
    files = [package / "errors.py", package / "fit" / "loop.py", package / "fit" / "policies" / "base.py"]
    files.append(kernels / "binning.py")
    for path in files:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("a = 1")
    (package / "kernels").symlink_to("../kernels")
    digests = {harness._digest_of(package)}
    for path in files:
        path.write_text("a = 2")
        digests.add(harness._digest_of(package))
    assert len(digests) == 1 + len(files)


# bench_step


def test_every_kernel_file_has_a_row() -> None:
    stems = {path.stem for path in (ROOT / "kernels").glob("*.py")} - SHARED_KERNELS
    assert stems <= {stage.name.removeprefix("- ") for stages in bench_step.STAGES.values() for stage in stages}


@pytest.mark.parametrize("renderer", bench_step.STAGES)
def test_step_by_stage(folder: Path, tmp_path: Path, renderer: str) -> None:
    """Every stage has a row, and the stages and the host add up to the step."""
    arguments = ["--curves", 20, "--fit-iterations", 6, "--repeat", 1, "--cache", tmp_path / "cache"]
    path_model = "sides" if renderer == "splat" else "segments"
    arguments += ["--set", f"renderer={renderer}", "--set", f"path_model={path_model}"]
    line = _last_json(_invoke(bench_step.main, "--image", folder / "a.png", "--threads", "1,2", *arguments))
    assert line["counts"]["paths"] == 20
    assert min(line["counts"].values()) > 0
    assert list(line["ms"]) == ["1 thr.", "2 thr."]
    for result in line["ms"].values():
        assert set(result["step"]) | set(result["render"]) >= {stage.name for stage in bench_step.STAGES[renderer]}
        for rows in result.values():
            parts = [name for name in rows if not name.startswith("- ") and name not in ("by stage", *result)]
            whole = rows["by stage"]["median"]
            assert sum(rows[name]["median"] for name in parts) == pytest.approx(whole, abs=1e-4 * len(rows))


def test_a_scene_is_fitted_once_and_laps_keep_it(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    photo, target = folder / "a.png", torch.rand(24, 40, 3)
    config = make_config(curves=9, iterations=4, initial_curves=9)
    path = scenes.fitted_scene(photo, target, config, tmp_path)
    scene = scenes.load_scene(path)
    monkeypatch.setattr(scenes, "fit", lambda *_: pytest.fail("fitted again"))
    assert scenes.fitted_scene(photo, target, config, tmp_path) == path
    with torch.no_grad():
        (bench,) = bench_step._benches(target, scene, config, "cpu", [1]).values()
        before = bench._fit._population.scene
        bench.lap()
    after = bench._fit._population.scene
    assert len(scene) == 9
    assert torch.equal(before.points, after.points)
    assert torch.equal(before.opacity, after.opacity)


def test_a_bad_setting_is_a_usage_error(folder: Path) -> None:
    result = _invoke(bench_step.main, "--image", folder / "a.png", "--device", "abacus")
    assert result.exit_code == 2
    assert "device must be" in result.stderr


# bench_fit


def test_whole_fit(folder: Path) -> None:
    arguments = ["--curves", "9", "--preset", "draft", "--no-vtracer", "--set", "iterations=5", "--set", "threads=1"]
    line = _last_json(_invoke(bench_fit.main, folder / "a.png", *arguments))
    (case,) = line["cases"]
    assert (case["image"], case["how"], case["metrics"]["curves"]) == ("a.png", "draft", 9)
    assert case["metrics"]["iterations"] == 5
    (run,) = case["runs"]
    # torch alone takes more than 50 MB; a wrong unit would be off by 1024.
    assert 50e6 < run["peak_bytes"] < 50e9
    assert run["wall"] > 0
    assert run["cpu"] > 0


def test_a_child_gets_its_environment_and_fails_with_its_last_line() -> None:
    code = "import os; print(os.environ['WARP_CACHE_PATH'])"
    assert bench_fit.run_child(["-c", code], {"WARP_CACHE_PATH": "here"}).stdout == "here\n"
    with pytest.raises(click.ClickException, match="ValueError: no luck$"):
        bench_fit.run_child(["-c", "raise ValueError('no luck')"])


def test_cold_runs_share_a_cache_that_starts_empty(monkeypatch: pytest.MonkeyPatch) -> None:
    held = []

    def run_child(arguments: list[object], environment: dict[str, str]) -> Any:
        cache = Path(environment["WARP_CACHE_PATH"])
        held.append(len(list(cache.iterdir())))
        (cache / "kernel").touch()
        return bench_fit.Run(1.0, 1.0, 1, "{}")

    monkeypatch.setattr(bench_fit, "run_child", run_child)
    labels = [case.how for case in bench_fit.cold_cases(Path("a.png"), "draft", {})]
    assert held == [0, 1]
    assert labels == ["draft, empty cache", "draft, filled cache"]


@pytest.mark.parametrize(("curves", "speckle"), [(512, 2), (100, 10), (10, 91), (8, 112), (1, 128)])
def test_vtracer_gets_the_smallest_speckle(curves: int, speckle: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """The stand-in for VTracer writes 1000 / speckle paths."""

    def run_child(arguments: list[Any]) -> Any:
        if arguments[0] == "-c":
            Path(arguments[3]).write_text("<path/>" * (1000 // arguments[4]))
        return bench_fit.Run(1.0, 1.0, 1, "{}")

    monkeypatch.setattr(bench_fit, "run_child", run_child)
    assert bench_fit.vtracer_case(Path("a.png"), curves, 1).how == f"vtracer, speckle {speckle}"


def test_vtracer_beside_a_fit(folder: Path) -> None:
    pytest.importorskip("vtracer", reason="vtracer is not installed")
    case = bench_fit.vtracer_case(folder / "a.png", 400, 1)
    assert 0 < case.metrics["curves"] <= 400
    assert len(case.cells()) == len(bench_fit.HEADER)


# kodak


def _kodak(folder: Path, out: Path, *arguments: object) -> Result:
    quick = ("--set", "iterations=5", "--set", "initial_curves=6", "--threads", 1)
    return _invoke(kodak.main, folder, "--out", out, "--curves", "6,8", *quick, *arguments)


def test_kodak_measures_every_image_once(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    out = tmp_path / "results" / "kodak.csv"
    first = _kodak(folder, out, "--details")
    assert first.exit_code == 0, first.output
    rows = list(fits.ResultFile(out, kodak.FIELDS).read().values())
    assert [(row["image"], row["curves"]) for row in rows] == [(f, c) for c in "68" for f in ("a.png", "b.png")]
    mean = (float(rows[0]["psnr"]) + float(rows[1]["psnr"])) / 2
    assert f"| 6 | 2 | {mean:.3f} |" in first.stdout
    assert "| b.png | 8 |" in first.stdout

    text = out.read_text()
    monkeypatch.setattr(kodak, "vectorize", lambda *_, **__: pytest.fail("measured again"))
    assert _kodak(folder, out, "--details").stdout.split("preset")[0] == first.stdout.split("preset")[0]
    assert out.read_text() == text


def test_kodak_resumes_a_killed_run(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Only the result whose line was cut off is measured again."""
    out = tmp_path / "kodak.csv"
    assert _kodak(folder, out).exit_code == 0
    before, lines = fits.ResultFile(out, kodak.FIELDS).read(), out.read_text().splitlines(keepends=True)
    out.write_text("".join(lines[:-1]) + lines[-1][:40])
    measured, measure = [], kodak.measure_image
    monkeypatch.setattr(kodak, "measure_image", lambda *args: measured.append(args[0].name) or measure(*args))
    assert _kodak(folder, out).exit_code == 0
    assert measured == ["b.png"]
    after = fits.ResultFile(out, kodak.FIELDS).read()
    assert [(key, row["psnr"]) for key, row in after.items()] == [(key, row["psnr"]) for key, row in before.items()]
    assert out.read_text().splitlines(keepends=True)[:-1] == lines[:-1]


def test_kodak_keys_depend_on_settings_photos_and_sources(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    config = make_config(curves=6)
    keys = [kodak.row_key(folder / name, config) for name in ("a.png", "b.png")]
    keys.append(kodak.row_key(folder / "a.png", make_config(curves=6, threads=2)))
    monkeypatch.setattr(fits, "source_digest", lambda: "changed")
    keys.append(kodak.row_key(folder / "a.png", config))
    assert len(set(keys)) == 4


def test_kodak_does_not_keep_an_interrupted_fit(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    vectorize = kodak.vectorize

    def interrupted(*args: Any, **settings: Any) -> Any:
        result = vectorize(*args, **settings)
        if isinstance(args[0], Path):
            object.__setattr__(result.fitted, "interrupted", True)
        return result

    monkeypatch.setattr(kodak, "vectorize", interrupted)
    assert _kodak(folder, tmp_path / "kodak.csv").exit_code == 1
    assert fits.ResultFile(tmp_path / "kodak.csv", kodak.FIELDS).read() == {}


def test_kodak_limit_and_empty_folder(folder: Path, tmp_path: Path) -> None:
    assert [path.name for path in kodak.find_images(folder, 1)] == ["a.png"]
    (tmp_path / "empty").mkdir()
    result = _kodak(tmp_path / "empty", tmp_path / "kodak.csv")
    assert result.exit_code == 2
    assert "holds none" in result.stderr


def test_kodak_refuses_a_file_with_other_columns(folder: Path, tmp_path: Path) -> None:
    out = tmp_path / "kodak.csv"
    out.write_text("key,image\n1,2\n")
    result = _kodak(folder, out)
    assert result.exit_code == 2
    assert "columns" in result.stderr
    assert out.read_text() == "key,image\n1,2\n"


def test_scenes_round_trip(tmp_path: Path) -> None:
    scene = Scene.uniform(torch.rand(3, 12, 2), torch.rand(3, 3), torch.rand(3), torch.rand(3), torch.arange(3))
    scenes.save_scene(scene, tmp_path / "folder" / "scene.npz")
    back = scenes.load_scene(tmp_path / "folder" / "scene.npz")
    for name in ("points", "color", "opacity", "background", "generation"):
        assert torch.equal(getattr(back, name), getattr(scene, name))


def test_scenes_of_loops_round_trip(tmp_path: Path) -> None:
    structure = Structure.of_loops([[3, 2], [4]], torch.tensor([True, False] * 4 + [True]))
    values = (torch.rand(2, 3), torch.rand(2), torch.rand(3), torch.arange(2))
    scene = Scene(torch.rand(9, 3, 2), structure, *values, transparent=True)
    scenes.save_scene(scene, tmp_path / "scene.npz")
    back = scenes.load_scene(tmp_path / "scene.npz").to_dict()
    for name, value in scene.to_dict().items():
        assert torch.equal(back[name], value) if torch.is_tensor(value) else back[name] == value, name


def test_a_scene_of_an_older_version_is_fitted_again_and_not_misread(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = Scene.uniform(torch.rand(3, 12, 2), torch.rand(3, 3), torch.rand(3), torch.rand(3), torch.arange(3))
    old = {name: np.asarray(getattr(scene, name)) for name in ("points", "color", "opacity", "background")}
    monkeypatch.setattr(scenes, "fit", lambda *_: FitResult(scene, [], 0, 0.0, interrupted=False, device="cpu"))
    arguments = folder / "a.png", torch.rand(24, 40, 3), make_config(curves=3), tmp_path
    path = scenes.fitted_scene(*arguments)
    np.savez(path, **old)
    with pytest.raises(click.UsageError, match="a scene of an older version of warpvec; delete it"):
        scenes.load_scene(path)
    assert torch.equal(scenes.load_scene(scenes.fitted_scene(*arguments)).points, scene.points)


def test_predicted_and_true_values_of_nodes(folder: Path, tmp_path: Path) -> None:
    out = tmp_path / "nodes.svg"
    options = ["--curves", 8, "--iterations", 60, "--side", 40, "--count", 4, "--steps", 2, "--out", out]
    result = _invoke(nodes.main, folder / "a.png", *options)
    assert "gain of a new node" in result.output
    assert out.read_text().count("<circle") == 12
