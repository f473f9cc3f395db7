"""Each benchmark runs once on something tiny. What it prints is read by people; here only its rows are counted."""

from __future__ import annotations

import threading
from importlib import import_module
from pathlib import Path
from typing import Any

import gate_measures
import numpy as np
import pytest
from click.testing import CliRunner
from commands import invoke
from PIL import Image

from warpvec.svg.measure import draw

pytestmark = pytest.mark.slow

LOGO = """<svg xmlns="http://www.w3.org/2000/svg" width="64" height="48"><path d="M8,8H40V40H8Z" fill="#c00"/>
<circle cx="44" cy="24" r="12" fill="#00c"/></svg>"""

HOOK = """<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 24 24" width="24" height="24" fill="none"
stroke="#000" stroke-width="2" stroke-linecap="round"><path d="M4 20V8a6 6 0 0 1 12 0v4"/></svg>"""

FEW = ["--set", "iterations=5", "--set", "initial_curves=6"]
SPLAT = ["--set", "renderer=splat", "--set", "path_model=sides", "--set", "samples=6", "--set", "lines=2"]
STEP = ["bench_step", "--image", "PHOTO", "--curves", "20", "--fit-iterations", "6", "--repeat", "1", "--cache", "OUT"]
PAPER = ["--iterations", "3", "--set", "samples=6", "--set", "lines=2", "--set", "threads=1"]

RUNS = {
    "a step": ([*STEP, "--threads", "1,2"], "| coverage_adjoint |"),
    "a step of splats": ([*STEP, "--threads", "1", *SPLAT], "| splatting_adjoint |"),
    "a fit": (["bench_fit", "PHOTO", "--curves", "9", "--preset", "draft", "--no-vtracer", *FEW], "| 9 |"),
    "a set of photos": (["kodak", "PHOTOS", "--out", "OUT/k.csv", "--curves", "6,8", "--details", *FEW], "| 8 | 2 |"),
    "two jobs": (["kodak", "PHOTOS", "--out", "OUT/k.csv", "--curves", "6", "--jobs", "2", *FEW], "| 6 | 2 |"),
    "sizes": (
        ["bench_size", "--photo", "PHOTO", "--sizes", "80x48", "--fit-size", "40", "--curves", "6",
         "--iterations", "6", "--cache", "OUT", "--set", "initial_curves=3"],
        "| 80x48 |",
    ),
    "flat art": (["flat", "LOGOS", "--sizes", "32", "--methods", "auto,bicubic", "--svgo", "none"], "| bicubic |"),
    "the icon gate": (["gate", "FAMILIES", "--size", "32", "--json", "OUT/gate.json"], "| auto | logos | 1 |"),
    "lines": (["lines", "--icons", "STROKES", "--count", "1", "--methods", "warpvec"], "| warpvec | 1 |"),
    "what is hidden": (["hidden", "LOGOS", "--size", "64"], "| logo |"),
    "cliffs": (["cliffs", "--sides", "24:25", "--damage", "png"], "of 5 pairs jump"),
    "the price of drawings": (["price", "LOGOS", "--size", "64"], "of 1"),
    "cutting": (["cutout", "LOGOS", "--size", "64"], "| logo |"),
    "placeholders": (["placeholder", "PHOTOS", "--limit", "1"], "warpvec"),
    "quality over bytes": (
        ["rate", "PHOTOS", "--sizes", "700,1500", "--methods", "JPEG,WEBP", "--out", "OUT/r.json",
         "--curves", "OUT/curves.svg"],
        "| WEBP |",
    ),
    "refining": (["refine", "LOGOS", "--kinds", "original,noise", "--iterations", "5"], "| noise | logo |"),
    "reading and writing": (["round_trip", "LOGOS", "--sizes", "32"], "1 of 1 files have at least 45 dB"),
    "nodes": (["nodes", "PHOTO", "--curves", "12", "--count", "4", "--steps", "2"], "gain of a new node"),
    "a table of the paper": (["paper", "table1", "PHOTOS", "--out", "OUT/t.csv", "--curves", "4", *PAPER], "| paper |"),
    "figures of the paper": (
        ["paper", "trajectory", "PHOTOS", "--out", "OUT/t.csv", "--curves", "4", "--every", "2", *PAPER], "kodim01",
    ),
}  # fmt: skip
"""Name -> a benchmark with its arguments, and words that its output has."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with two smooth photos, and one with a logo as a drawing and as a picture."""
    folder = tmp_path_factory.mktemp("inputs")
    x, y = np.meshgrid(np.linspace(0, 1, 48), np.linspace(0, 1, 32))
    (folder / "photos").mkdir()
    for name, channels in {"kodim01": (x, y, x * y), "kodim07": (x, 1 - x, (x - 0.5) ** 2 + y**2)}.items():
        Image.fromarray((255 * np.stack(channels, -1)).astype(np.uint8)).save(folder / "photos" / f"{name}.png")
    (folder / "strokes").mkdir()
    (folder / "strokes" / "hook.svg").write_text(HOOK)
    (folder / "logos").mkdir()
    (folder / "logos" / "logo.svg").write_text(LOGO)
    Image.fromarray(draw(LOGO, 64, 48)).save(folder / "logos" / "logo.png")
    return folder


def run(folder: Path, out: Path, words: list[str]) -> str:
    """Run a benchmark, and return what it wrote to stdout."""
    places = {"PHOTOS": folder / "photos", "PHOTO": folder / "photos" / "kodim07.png", "LOGOS": folder / "logos",
              "STROKES": folder / "strokes", "FAMILIES": folder}  # fmt: skip
    name, *given = [str(places.get(word, word.replace("OUT", str(out), 1))) for word in words]
    result = CliRunner().invoke(import_module(name).main, given, catch_exceptions=False)
    assert result.exit_code == 0, result.output
    return result.stdout


@pytest.mark.parametrize("name", RUNS)
def test_a_benchmark_prints_its_rows(name: str, folder: Path, tmp_path: Path) -> None:
    words, expected = RUNS[name]
    assert expected in run(folder, tmp_path, words)


def test_a_second_run_takes_its_results_from_the_file(folder: Path, tmp_path: Path) -> None:
    words, _ = RUNS["a set of photos"]
    first = run(folder, tmp_path, words)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("kodak.vectorize", lambda *_, **__: pytest.fail("measured again"))
        again = run(folder, tmp_path, words)
    assert again.split("preset")[0] == first.split("preset")[0]


def test_two_runs_of_the_gate_are_compared(folder: Path, tmp_path: Path) -> None:
    rows = tmp_path / "gate.json"
    run(folder, tmp_path, ["gate", "FAMILIES", "--size", "32", "--json", str(rows)])
    assert "| logos/logo | auto |" in run(folder, tmp_path, ["gate", str(rows), "--compare", str(rows)])


def test_the_words_of_a_file_are_counted_as_the_gate_says() -> None:
    path = "M1,1 2,2h3V4zm1 1q1 1 2 2t3 3C1 1 2 2 3 3s1-1.5.5-.25a1 1 0 012 2 1 1 0 1 0 1 1"
    shapes = f'<path d="{path}"/><circle r="1"/><rect width="9" height="9"/><polygon points="0,0 1,0 .5-1"/>'
    words = gate_measures.count_words(f'<svg xmlns="http://www.w3.org/2000/svg">{shapes}</svg>')
    assert words == (6 + 8 + 12 + 14 + 3 + 6 + 6, 4)


def test_goals_are_measured(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import bench_fit

    def run_here(arguments: list[object]) -> Any:
        return bench_fit.Run(1.0, 1.0, 1, invoke(*arguments[2:]).stdout)

    monkeypatch.setattr("bench_goals.run_child", run_here)
    words = ["--max-bytes", "9k", "--target-psnr", "7", "--colors", "3", "--curves", "12", "--lod-curves", "32"]
    short = ["--option=--iterations=12", "--option=--inflation-gap=2", "--option=--threads=1"]
    output = run(folder, tmp_path, ["bench_goals", "PHOTO", *words, *short])
    assert all(f"| {name} |" in output for name in ("--max-bytes 9k", "--target-psnr 7", "--colors 3 --opaque"))


def test_a_batch_is_timed_beside_single_runs(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import bench_batch
    import bench_fit
    from fits import InProcess

    lock = threading.Lock()

    def run_here(arguments: list[object]) -> Any:
        with lock:
            return bench_fit.Run(1.0, 1.0, 1, invoke(*arguments[2:]).stdout)

    monkeypatch.setattr(bench_batch, "run_child", run_here)
    monkeypatch.setattr("warpvec.cli.commands.batch._engine", lambda *_: InProcess())
    few = bench_batch.cli_options({"curves": 6, "iterations": 5, "initial_curves": 6})
    bench = bench_batch.Bench(sorted((folder / "photos").iterdir()), few, 2, tmp_path)
    assert "batch, 2 jobs" in [row[0] for row in bench_batch.compare(bench)]


def test_every_kernel_has_a_row() -> None:
    import bench_step

    shared = (
        "__init__ adan capacity bezier constants thread_pool edges gradients index_lanes lanes real_lanes reductions "
        "stops stroking stroking_adjoint vectors "  # those of strokes and stops do nothing in the scenes that it times
        "pixel_slopes "  # of steps of Gauss-Newton, which it does not time
        "softening softening_adjoint "  # of soft paths, which its scenes do not have
        "making similarity"  # of no step
    )
    fit_steps = set(import_module("cubins").FIT_STEPS)  # of exact fits, which it does not time
    stems = (
        {path.stem for path in (Path(__file__).parents[2] / "kernels").glob("*.py")} - set(shared.split()) - fit_steps
    )
    rows = {stage.name.removeprefix("- ") for stages in bench_step.STAGES.values() for stage in stages}
    assert stems - set(shared.split()) - fit_steps <= rows


def test_settings_get_the_types_of_their_fields() -> None:
    import harness

    texts = ("curves=7", "lr_scale=0.5", "one_generation=true", "time_budget=3", "z_order=area")
    expected = {"curves": 7, "lr_scale": 0.5, "one_generation": True, "time_budget": 3.0, "z_order": "area"}
    assert harness.parse_settings(texts) == expected
