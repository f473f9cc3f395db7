"""Records of photos that fail: the error, and the figures of a file that an earlier batch made."""

from __future__ import annotations

import csv
import errno
import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from commands import assert_refused, invoke

from warpvec.batch import jobs as batch
from warpvec.batch.console import Tally, describe
from warpvec.batch.engines.base import Outcome, WorkerShare
from warpvec.batch.folders import LocalFolder
from warpvec.batch.jobs import PhotoJob, Vectorize, find_jobs, remaining, run_batch
from warpvec.batch.journal import CSV_NAME, JSON_NAME, Journal, Record
from warpvec.cli.options import OPTION_NAMES
from warpvec.config.fit_config import FitConfig
from warpvec.drawing.file_options import FileOptions
from warpvec.errors import InputError
from warpvec.goals.goal import make_goal


class Failing:
    """An engine on which every photo fails."""

    def __init__(self, error: str) -> None:
        self._error = error

    def run(self, jobs: list[PhotoJob], *_: object) -> Iterator[Outcome[PhotoJob, Record]]:
        for job in jobs:
            yield Outcome(job, None, self._error, 3)


@pytest.fixture
def work(tmp_path: Path) -> Vectorize:
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "a.png").write_bytes(b"a photo")
    return Vectorize(LocalFolder(tmp_path / "in"), LocalFolder(tmp_path), FitConfig(curves=8), None)


def _fail(work: Vectorize, error: str = "no\nluck") -> Record:
    (record,) = run_batch([PhotoJob("a.png", "a.svg")], work, Failing(error), Journal(work.target), lambda *_: None)
    return record


def _good(work: Vectorize) -> Record:
    return Record(
        input="a.png", output="a.svg", curves=8, bytes=9, psnr=27.5, ssim=0.75, seconds=1.5, key=work.key(b"a photo"),
        settings=work.settings,
    )  # fmt: skip


def test_a_failed_photo_without_a_file_has_none_of_its_figures(work: Vectorize, tmp_path: Path) -> None:
    Journal(work.target).add(_good(work))  # whose file is gone
    assert _fail(work) == Record(
        input="a.png", output="a.svg", error="no luck", attempts=3, settings=work.settings, key=None
    )


def test_the_file_that_still_lies_there_keeps_its_record(work: Vectorize, tmp_path: Path) -> None:
    good = _good(work)
    Journal(work.target).add(good)
    (tmp_path / "a.svg").write_text("<svg/>")
    other = replace(work, config=FitConfig(curves=9))
    record = _fail(other)
    assert record == replace(good, error="no luck", attempts=3)
    assert json.loads((tmp_path / JSON_NAME).read_text().splitlines()[-1])["psnr"] == 27.5
    with (tmp_path / CSV_NAME).open(newline="") as file:
        assert list(csv.DictReader(file))[-1]["error"] == "no luck"
    assert _fail(other, "again").bytes == 9
    # The record is still that of a failure: it is shown so, left out of the mean, and the photo is tried again.
    assert describe(record) == "a.png: failed, 3 attempts: no luck"
    assert Tally(skipped=0, total=1, records=[record]).facts()["psnr"] is None
    jobs = find_jobs(["a.png"])
    for some in (work, other):
        assert remaining(jobs, some, Journal(work.target), skip_existing=False) == jobs


def test_a_file_that_no_batch_made_gives_no_figures(work: Vectorize, tmp_path: Path) -> None:
    (tmp_path / "a.svg").write_text("<svg/>")
    assert _fail(work).bytes is None


def test_a_setting_in_an_error_has_the_name_of_its_option(work: Vectorize, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> None:
        raise InputError("max_bytes", "is too small for one path", "9")

    monkeypatch.setattr(Vectorize, "_vectorize", fail)
    with pytest.raises(InputError, match="^--max-bytes is too small for one path, got 9$"):
        replace(work, option_names=OPTION_NAMES)(PhotoJob("a.png", "a.svg"), WorkerShare("cpu", 1), print)


def test_photos_with_the_same_svg_fail_alone(work: Vectorize, tmp_path: Path) -> None:
    Journal(work.target).add(_good(work))
    (tmp_path / "a.svg").write_text("<svg/>")
    jobs = find_jobs(["a.jpg", "a.png", "b.png"])
    journal = Journal(work.target)
    assert remaining(jobs, work, journal, skip_existing=False) == jobs
    records = {record.input: record for record in run_batch(jobs, work, Failing("no"), journal, lambda *_: None)}
    clash = "a.jpg must have a file of its own, got a.svg for a.jpg and a.png; rename one, or give --keep-suffix"
    assert (records["a.jpg"].error, records["a.jpg"].bytes) == (clash, None)
    assert (records["a.png"].error, records["a.png"].bytes) == (clash.replace("a.jpg", "a.png", 1), 9)
    assert records["b.png"].error == "no"
    assert len((tmp_path / CSV_NAME).read_text().splitlines()) == 1 + 1 + 3
    # A file that is made later ends the records of other photos of its name.
    journal.add(_good(work))
    assert journal.get("a.jpg", "a.svg") is None


def test_file_options_count_as_settings_where_they_are_not_the_defaults(work: Vectorize) -> None:
    other = replace(work, file_options=FileOptions(trim=True))
    assert {**work.settings, "trim": True} == other.settings
    assert work.key(b"photo") != other.key(b"photo")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--policy", "replacement", "--max-bytes", "5k"], ["--policy must be scaffolding to meet a goal"]),
        (["--gzip"], ["--gzip must come with --max-bytes"]),
        (["--config", "same", "--write-config", "missing/a"], ["--write-config must be in an existing folder"]),
    ],
)
def test_what_fails_every_photo_is_said_once(
    work: Vectorize, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, options: list[str], words: list[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("same").write_text("")
    assert_refused(invoke("batch", "in", "out", *options), *words)
    assert not Path("out").exists()


def test_a_batch_writes_its_settings(work: Vectorize, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[tuple[Any, ...]] = []

    def record(*arguments: Any) -> Vectorize:
        asked.append(arguments[2:5])
        return replace(work, config=arguments[2])

    monkeypatch.setattr(batch, "Vectorize", record)
    monkeypatch.setattr("warpvec.cli.commands.batch._engine", lambda *_: Failing("no"))
    settings = tmp_path / "a.toml"
    folders = [tmp_path / "in", tmp_path]
    invoke("batch", *folders, "--svgz", "--curves", 9, "--background", "#fff", "--write-config", settings)
    invoke("batch", *folders, "--svgz", "--config", settings)
    assert asked == [(FitConfig(curves=9), "#fff", make_goal(gzip=True))] * 2


def test_a_batch_goes_on_without_its_settings(work: Vectorize, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("warpvec.cli.side_files.write_settings", fail)
    monkeypatch.setattr("warpvec.cli.commands.batch._engine", lambda *_: Failing("tried"))
    result = invoke("batch", tmp_path / "in", tmp_path / "out", "--write-config", tmp_path / "a.toml")
    assert "warning: --write-config could not be written (No space left on device); going on\n" in result.stderr
    assert '"error": "tried"' in (tmp_path / "out" / JSON_NAME).read_text()
