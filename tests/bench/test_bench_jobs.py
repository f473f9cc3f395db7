"""Test benchmarks with several jobs at a time, and bench_batch. No test asserts a time."""

from __future__ import annotations

import pickle
import threading
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import bench_batch
import click
import fits
import kodak
import paper_fits
import pytest
from click.testing import CliRunner
from commands import invoke, write_photo

SETTINGS = {"curves": 6, "iterations": 5, "initial_curves": 6}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with two noisy photos of 40 x 24 pixels."""
    path = tmp_path / "photos"
    path.mkdir()
    for seed, name in enumerate(("a.png", "b.png")):
        write_photo(path, name, 24, 40, seed)
    return path


def test_kodak_gives_the_same_results_with_two_jobs(folder: Path, tmp_path: Path) -> None:
    rows = []
    for jobs in (1, 2):
        out = tmp_path / f"kodak-{jobs}.csv"
        arguments = [folder, "--out", out, "--curves", 6, "--threads", 1, "--jobs", jobs]
        options = [option for name, value in SETTINGS.items() for option in ("--set", f"{name}={value}")]
        result = CliRunner().invoke(kodak.main, [*map(str, arguments), *options], catch_exceptions=False)
        assert result.exit_code == 0, result.output
        rows.append(fits.ResultFile(out, kodak.FIELDS).read())
    assert {key: row["psnr"] for key, row in rows[0].items()} == {key: row["psnr"] for key, row in rows[1].items()}
    assert sorted(row["image"] for row in rows[1].values()) == ["a.png", "b.png"]


def test_jobs_share_the_cores_unless_threads_are_given(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fits, "core_count", lambda: 8)
    assert fits.engine_for(1, {"seed": 1})[1] == {"seed": 1}
    assert fits.engine_for(3, {"seed": 1})[1] == {"seed": 1, "threads": 2}
    assert fits.engine_for(3, {"threads": 5})[1] == {"threads": 5}


def test_a_fit_that_fails_ends_a_benchmark() -> None:
    failed = SimpleNamespace(run=lambda *_: (SimpleNamespace(job=job, value=None, error="no luck") for job in "ab"))
    with pytest.raises(click.ClickException, match="a: no luck"):
        list(fits.results_of(failed, ["a", "b"], print))


def test_fits_of_the_paper_can_be_made_by_another_process(folder: Path, tmp_path: Path) -> None:
    table = paper_fits.Fits(tmp_path / "paper.csv")
    cases = [paper_fits.Case(photo, "default", SETTINGS) for photo in paper_fits.choose_photos(folder, None, 1.0)]
    row = pickle.loads(pickle.dumps(table._measure))(cases[0], None, None)
    assert row["image"] == "a"
    table.fill(cases)
    assert [table.row(case)["image"] for case in cases] == ["a", "b"]
    assert float(table.row(cases[0])["file_psnr"]) == row["file_psnr"]


# bench_batch


@pytest.fixture
def bench(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    """A bench whose commands and batch jobs run in this process."""
    lock = threading.Lock()

    def run_child(arguments: list[object]) -> Any:
        with lock:
            result = invoke(*arguments[2:])
        assert result.exit_code == 0, result.output
        return SimpleNamespace(wall=1.0)

    monkeypatch.setattr(bench_batch, "run_child", run_child)
    monkeypatch.setattr("warpvec.cli.commands.batch._engine", lambda *_: fits.InProcess())
    work = tmp_path / "work"
    work.mkdir()
    options = bench_batch.cli_options(SETTINGS)
    return bench_batch.Bench(sorted(folder.iterdir()), options, 2, work)


def _kill(bench: Any, monkeypatch: pytest.MonkeyPatch, *, forgotten: bool) -> None:
    """Make the batch look killed after its first photo; if ``forgotten``, the key of its record is wrong."""

    def killed_batch(self: Any, name: str) -> tuple[float, int]:
        self.batch(name)
        path = self.folder / name / bench_batch.JSON_NAME
        first = path.read_text().splitlines(keepends=True)[0]
        path.write_text(first.replace('"key": "', '"key": "0') if forgotten else first)
        return 1.0, 1

    monkeypatch.setattr(bench_batch.Bench, "killed_batch", killed_batch)


def test_a_batch_beside_single_runs(bench: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    names = [row[0] for row in bench_batch.compare(bench)]
    assert "batch, 2 jobs" in names
    _kill(bench, monkeypatch, forgotten=False)
    assert [row[0] for row in bench_batch.kill_and_resume(bench)] == [
        "killed after 1 of 2 photos",
        "run again: none of the 1 fitted twice, none missing",
    ]


def test_a_photo_that_is_fitted_twice_is_an_error(bench: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    bench.batch("batch")
    _kill(bench, monkeypatch, forgotten=True)
    with pytest.raises(click.ClickException, match="fitted twice: \\['a.png'\\], missing: \\[\\]"):
        bench_batch.kill_and_resume(bench)
