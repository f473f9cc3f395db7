"""``warpvec batch`` for a user: bad photos, workers that die, batches that are killed, and the files they leave."""

from __future__ import annotations

import csv
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from children import start, wait_for
from commands import assert_refused, invoke
from PIL import Image

from warpvec.batch.engines.base import WorkerShare
from warpvec.batch.folders import LocalFolder
from warpvec.batch.jobs import PhotoJob, Vectorize, find_jobs, longest_first
from warpvec.batch.journal import CSV_NAME, JSON_NAME
from warpvec.config.presets import make_config

# A fit of 64 x 64 pixels in a few tenths of a second.
SETTINGS = ["--curves", "8", "--initial-curves", "8", "--threads", "1", "--device", "cpu"]
QUICK = [*SETTINGS, "--iterations", "5"]
LONGER = [*SETTINGS, "--iterations", "150"]


def _write_photos(folder: Path, *names: str) -> None:
    """Write smooth noise of 64 x 64, different for each name."""
    for seed, name in enumerate(names):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        noise = np.random.default_rng(seed).integers(0, 256, (8, 8, 3), dtype=np.uint8)
        Image.fromarray(noise).resize((64, 64)).save(folder / name)


@pytest.fixture
def photos(tmp_path: Path) -> Path:
    """Return a folder of four photos and a file that is no photo."""
    folder = tmp_path / "photos"
    _write_photos(folder, *(f"p{k}.png" for k in range(4)))
    (folder / "notes.txt").write_text("no photo")
    return folder


@pytest.fixture
def out(tmp_path: Path) -> Path:
    """Return the path of a folder that does not exist yet."""
    return tmp_path / "new" / "svgs"


def _records(out: Path) -> dict[str, dict[str, Any]]:
    """Return the last record of each input. Incomplete lines are ignored."""
    text = (out / JSON_NAME).read_text() if (out / JSON_NAME).exists() else ""
    return {record["input"]: record for record in map(json.loads, text.split("\n")[:-1])}


def _times(out: Path) -> dict[str, int]:
    return {path.name: path.stat().st_mtime_ns for path in out.glob("*.svg")}


@contextmanager
def _batch(photos: Path, out: Path, *arguments: str) -> Iterator[subprocess.Popen[str]]:
    """Run the command in its own process group, as a shell does."""
    command = [sys.executable, "-m", "warpvec", "batch", str(photos), str(out), *arguments]
    with start(
        command, cwd=Path(__file__).parents[2], stderr=subprocess.PIPE, text=True, start_new_session=True
    ) as process:
        try:
            yield process
        finally:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)


def _workers(process: subprocess.Popen[str]) -> list[int]:
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
    commands = {int(pid): Path(f"/proc/{pid}/cmdline").read_text() for pid in children}
    return [pid for pid, command in commands.items() if "spawn_main" in command]


# whole batches


@pytest.mark.slow
def test_a_worker_that_is_killed_and_a_bad_photo_cost_no_other(photos: Path, out: Path) -> None:
    (photos / "bad.png").write_bytes(1000 * b"no photo either")  # the largest comes first
    with _batch(photos, out, "--jobs", "2", "--retry", "1", *LONGER) as process:
        # Wait for the record of the bad photo, so that its worker is not the victim.
        wait_for(lambda: len({record["error"] is None for record in _records(out).values()}) == 2, process)
        victim = _workers(process)[0]
        os.kill(victim, signal.SIGKILL)
        assert process.stderr is not None
        log = process.stderr.read()
    assert process.returncode == 1, log
    records = _records(out)
    assert sorted(records) == ["bad.png", *(f"p{k}.png" for k in range(4))]
    assert "bad.png must be a complete image" in records.pop("bad.png")["error"]
    assert "bad.png: failed: bad.png must be" in log
    assert sorted(record["attempts"] for record in records.values()) == [1, 1, 1, 2]
    assert "tried again: the worker process was killed by signal 9" in log
    for record in records.values():
        assert (record["error"], record["curves"]) == (None, 8)
        assert record["bytes"] == (out / record["output"]).stat().st_size
    assert sorted(os.listdir(out)) == [CSV_NAME, JSON_NAME, *(f"p{k}.svg" for k in range(4))]

    # `run` makes the same file, with any number of threads.
    alone = out / "alone" / "p1.svg"
    alone.parent.mkdir()
    assert invoke("run", photos / "p1.png", alone, "-q", *LONGER, "--threads", "2").exit_code == 0
    assert alone.read_bytes() == (out / "p1.svg").read_bytes()


@pytest.mark.slow
def test_a_killed_batch_goes_on_where_it_was(photos: Path, out: Path) -> None:
    with _batch(photos, out, "--jobs", "1", *LONGER) as process:
        wait_for(lambda: len(_records(out)) >= 2, process)
        process.kill()
    done, times = _records(out), _times(out)
    assert 2 <= len(done) < 4
    result = invoke("batch", photos, out, "--jobs", "1", "--json", *LONGER)
    assert result.exit_code == 0, result.output
    facts = json.loads(result.stdout)
    assert (facts["images"], facts["skipped"], facts["done"]) == (4, len(done), 4 - len(done))
    records = _records(out)
    assert {name: records[name] for name in done} == done
    assert {name: _times(out)[records[name]["output"]] for name in done} == {
        name: times[done[name]["output"]] for name in done
    }
    assert sorted(records) == [f"p{k}.png" for k in range(4)]
    assert sorted(_times(out)) == [f"p{k}.svg" for k in range(4)]


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGHUP])
def test_an_interrupted_batch_ends_in_order(photos: Path, out: Path, number: int) -> None:
    with _batch(photos, out, "--jobs", "2", *SETTINGS, "--iterations", "100000") as process:
        wait_for(lambda: len(_workers(process)) == 2, process)
        workers = _workers(process)
        for pid in workers:  # which leave the end to the batch
            os.kill(pid, number)
        time.sleep(0.5)
        assert _workers(process) == workers
        os.killpg(process.pid, number)
        assert process.stderr is not None
        log = process.stderr.read()
    assert process.returncode == 128 + number
    assert log == ""
    assert not any(Path(f"/proc/{pid}").exists() for pid in workers)
    assert os.listdir(out) == []


# photos that are done and not done again; `InProcess` does the work of the workers


class InProcess:
    """An engine in this process that notes the photos it is given."""

    def __init__(self) -> None:
        self.seen: list[str] = []

    def run(self, jobs: list[PhotoJob], work: Vectorize, watch: Callable[..., None]) -> Iterator[Any]:
        from warpvec.batch.engines.base import Failure, Outcome, try_work

        for job in jobs:
            self.seen.append(job.input)
            answer = try_work(work, job, WorkerShare("cpu", 1), lambda text: None)
            failed = isinstance(answer, Failure)
            yield Outcome(job, None if failed else answer, answer.reason if failed else None, 1)


@pytest.fixture
def engine(monkeypatch: pytest.MonkeyPatch) -> InProcess:
    """Replace the worker processes by this process."""
    here = InProcess()
    monkeypatch.setattr("warpvec.cli.commands.batch._engine", lambda *_: here)
    return here


def _done(engine: InProcess, *arguments: object) -> list[str]:
    """Run a batch that succeeds; return the photos that it did, by name."""
    engine.seen = []
    result = invoke("batch", *arguments)
    assert result.exit_code == 0, result.output
    return sorted(engine.seen)  # the largest came first


def test_what_is_done_is_not_done_again_until_it_changes(photos: Path, out: Path, engine: InProcess) -> None:
    assert _done(engine, photos, out, *QUICK) == [f"p{k}.png" for k in range(4)]
    assert _done(engine, photos, out, *QUICK, "--threads", "2") == []
    _write_photos(photos, "p3.png", "p2.png")  # p2 is another photo now; p3 as well
    (out / "p0.svg").unlink()
    assert _done(engine, photos, out, *QUICK) == ["p0.png", "p2.png", "p3.png"]
    assert _done(engine, photos, out, *QUICK, "--seed", "1") == [f"p{k}.png" for k in range(4)]
    assert _done(engine, photos, out, *QUICK) == [f"p{k}.png" for k in range(4)]
    assert _done(engine, photos, out, *QUICK, "--background", "red") == [f"p{k}.png" for k in range(4)]


def test_skip_existing_takes_any_file(photos: Path, out: Path, engine: InProcess) -> None:
    out.mkdir(parents=True)
    (out / "p1.svg").write_text("drawn by hand")
    assert _done(engine, photos, out, *QUICK, "--skip-existing") == ["p0.png", "p2.png", "p3.png"]
    assert _done(engine, photos, out, *QUICK, "--seed", "1", "--skip-existing") == []
    assert (out / "p1.svg").read_text() == "drawn by hand"
    assert sorted(_records(out)) == ["p0.png", "p2.png", "p3.png"]


def test_a_failed_photo_is_tried_by_the_next_batch(photos: Path, out: Path, engine: InProcess) -> None:
    good = (photos / "p1.png").read_bytes()
    (photos / "p1.png").write_bytes(b"")
    result = invoke("batch", photos, out, *QUICK)
    assert result.exit_code == 1
    assert f"{out}: 4 images: 3 done (3 as photos), 1 failed, PSNR " in result.stdout
    assert "is empty" in _records(out)["p1.png"]["error"]
    (photos / "p1.png").write_bytes(good)
    assert _done(engine, photos, out, *QUICK) == ["p1.png"]
    assert _records(out)["p1.png"]["error"] is None
    with (out / CSV_NAME).open(newline="") as file:
        assert [row["input"] for row in csv.DictReader(file)] == [f"p{k}.png" for k in range(4)]


def test_folders_in_folders_keep_their_names(photos: Path, out: Path, engine: InProcess) -> None:
    _write_photos(photos, "b/c/p0.jpg", "b/.trash/p1.png")
    assert len(_done(engine, photos, out, *QUICK)) == 4
    assert _done(engine, photos, out, *QUICK, "--recursive") == ["b/c/p0.jpg"]
    assert (out / "b" / "c" / "p0.svg").is_file()


def test_svgz_and_kept_suffixes(photos: Path, out: Path, engine: InProcess) -> None:
    _done(engine, photos, out, *QUICK, "--svgz", "--keep-suffix")
    assert sorted(path.name for path in out.glob("p*")) == [f"p{k}.png.svgz" for k in range(4)]
    data = (out / "p0.png.svgz").read_bytes()
    assert data[:2] == b"\x1f\x8b" and len(data) == _records(out)["p0.png"]["bytes"]


# refusals


def test_two_photos_of_one_name_fail_and_the_others_do_not(photos: Path, out: Path, engine: InProcess) -> None:
    _write_photos(photos, "p1.jpg")
    result = invoke("batch", photos, out, *QUICK)
    assert result.exit_code == 1
    assert sorted(engine.seen) == ["p0.png", "p2.png", "p3.png"]
    errors = {name: record["error"] for name, record in _records(out).items() if record["error"]}
    assert sorted(errors) == ["p1.jpg", "p1.png"]
    assert "--keep-suffix" in errors["p1.jpg"]


def test_file_options_reach_the_files(photos: Path, out: Path, engine: InProcess) -> None:
    _done(engine, photos, out, *QUICK)
    assert _done(engine, photos, out, *QUICK, "--no-metadata", "--trim") == [f"p{k}.png" for k in range(4)]
    assert "<metadata>" not in (out / "p0.svg").read_text()
    assert _done(engine, photos, out, *QUICK, "--no-metadata", "--trim") == []
    pytest.importorskip("pathops")
    _done(engine, photos, out, *QUICK, "--for", "word")
    assert (out / "p0.svg.png").read_bytes().startswith(b"\x89PNG")


def test_files_for_android_are_vector_drawables(photos: Path, out: Path, engine: InProcess) -> None:
    pytest.importorskip("pathops")
    for expected in ([f"p{k}.png" for k in range(4)], []):  # the second run skips all
        assert _done(engine, photos, out, *QUICK, "--for", "android") == expected
    assert sorted(path.name for path in out.glob("p*")) == [f"p{k}.xml" for k in range(4)]
    for record in _records(out).values():
        assert record["bytes"] == (out / record["output"]).stat().st_size
    assert (out / "p0.xml").read_text().startswith("<vector")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["{photos}/none", "{out}"], ["IN_DIR must be a folder", "check the path"]),
        (["{photos}/p0.png", "{out}"], ["IN_DIR must be a folder"]),
        (["{empty}", "{out}"], ["IN_DIR must contain photos", "--recursive"]),
        (["{photos}", "{photos}/p0.png"], ["OUT_DIR must be a folder"]),
        (["{photos}", ""], ["OUT_DIR must be a folder, got ''"]),
        (["{photos}", "{out}", "--curves", "0"], ["--curves must be"]),
        (["{photos}", "{out}", "--device", "abacus"], ["--device must be"]),
        (["{photos}", "{out}", "--background", "nocolor"], ["--background must be"]),
        (["{photos}", "{out}", "--ray-address", "auto"], ["--ray-address", "--engine ray"]),
        (["{photos}", "{out}", "--svgz", "--for", "android"], ["--svgz must be for SVGs", "--for android"]),
    ],
)
def test_mistakes_are_one_line(photos: Path, out: Path, arguments: list[str], words: list[str]) -> None:
    empty = photos.parent / "empty"
    empty.mkdir()
    given = [text.format(photos=photos, out=out, empty=empty) for text in arguments]
    assert_refused(invoke("batch", *given), *words)
    assert not out.exists()


def test_one_batch_at_a_time_writes_a_folder(photos: Path, out: Path) -> None:
    with LocalFolder(out).lock():
        assert_refused(invoke("batch", photos, out, *QUICK), "OUT_DIR", "is in use")


# names and keys


def test_names_of_svgs() -> None:
    names = ["a.PNG", "b/c.d.jpeg", "notes.txt", "svg", "e.svg"]
    assert [job.output for job in find_jobs(names)] == ["a.svg", "b/c.d.svg"]
    assert [job.output for job in find_jobs(names, ".svgz", keep_suffix=True)] == ["a.PNG.svgz", "b/c.d.jpeg.svgz"]


def test_the_largest_photos_come_first_and_a_missing_one_does_no_harm(tmp_path: Path) -> None:
    for name, size in (("a.png", 100), ("b.png", 900), ("c.png", 100)):
        (tmp_path / name).write_bytes(bytes(size))
    jobs = longest_first(find_jobs(["a.png", "b.png", "c.png", "gone.png"]), LocalFolder(tmp_path))
    assert [job.input for job in jobs] == ["b.png", "a.png", "c.png", "gone.png"]
    assert jobs[0].effort == 3.0 * jobs[1].effort


def test_a_key_tells_photos_and_settings_apart_and_no_threads(tmp_path: Path) -> None:
    folder = LocalFolder(tmp_path)

    def key(photo: bytes, background: str | None = None, **settings: Any) -> str:
        return Vectorize(folder, folder, make_config(**settings), background).key(photo)

    first = key(b"photo")
    assert first == key(b"photo", threads=3, device="cpu")
    others = [key(b"photo2"), key(b"photo", seed=1), key(b"photo", preset="draft"), key(b"photo", "#000")]
    assert len({first, *others}) == 5
