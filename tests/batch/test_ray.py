"""``warpvec batch --engine ray`` on a real Ray cluster of two workers, one of which is killed."""

from __future__ import annotations

import json
import os
import re
import signal
import sys
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from batch_work import Trial
from commands import assert_refused, invoke
from PIL import Image

from warpvec.batch.engines.ray import RayEngine
from warpvec.batch.folders import open_folder
from warpvec.batch.jobs import PhotoJob, Vectorize, find_jobs, run_batch
from warpvec.batch.journal import CSV_NAME, JSON_NAME, Journal
from warpvec.config.presets import make_config
from warpvec.errors import InputError

ray = pytest.importorskip("ray", reason="the extra cluster is not installed")

# Ray leaves sockets and files open for Python to close.
pytestmark = [
    pytest.mark.slow,
    pytest.mark.filterwarnings("ignore::ResourceWarning", "ignore::pytest.PytestUnraisableExceptionWarning"),
]

TESTS = Path(__file__).parents[1] / "support"

SETTINGS = {"curves": 8, "initial_curves": 8, "iterations": 60, "threads": 1, "device": "cpu"}
OPTIONS = [f"--{name.replace('_', '-')}={value}" for name, value in SETTINGS.items()]


@pytest.fixture(scope="module")
def cluster() -> Iterator[None]:
    """Start a cluster in this process with room for two workers."""
    os.environ["RAY_USAGE_STATS_ENABLED"] = "0"
    os.environ["RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO"] = "0"
    # Workers find the same modules as this process: warpvec in a bare checkout, and the tests.
    environment = {"env_vars": {"PYTHONPATH": os.pathsep.join([str(TESTS.parent), str(TESTS)])}}
    ray.init(
        num_cpus=2, num_gpus=0, include_dashboard=False, log_to_driver=False, logging_level="error",
        runtime_env=environment,
        _system_config={"memory_monitor_refresh_ms": 0},  # or Ray kills workers when other programs need the memory
    )  # fmt: skip
    yield
    ray.shutdown()


@pytest.fixture
def photos(tmp_path: Path) -> Path:
    """Return a folder of five photos of 64 x 64, one of them in a subfolder, and a bad file."""
    folder = tmp_path / "photos"
    (folder / "more").mkdir(parents=True)
    for seed, name in enumerate(("p0.png", "p1.png", "p2.png", "p3.png", "more/p4.png")):
        noise = np.random.default_rng(seed).integers(0, 256, (8, 8, 3), dtype=np.uint8)
        Image.fromarray(noise).resize((64, 64)).save(folder / name)
    (folder / "bad.png").write_bytes(b"no photo")
    return folder


def _ignore(job: object, text: str) -> None:
    """Ignore the news of a job."""


def test_the_handler_of_sigterm_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    def init(**_: object) -> None:
        signal.signal(signal.SIGTERM, signal.default_int_handler)  # as Ray does

    for name, stub in (("init", init), ("is_initialized", bool), ("shutdown", bool)):
        monkeypatch.setattr(ray, name, stub)
    before = signal.getsignal(signal.SIGTERM)
    try:
        with RayEngine("cpu", 1, 1, 0, None)._connected():
            assert signal.getsignal(signal.SIGTERM) is before
    finally:
        signal.signal(signal.SIGTERM, before)


class Killer:
    """Kills the first worker that begins ``victim``, while it is at it."""

    def __init__(self, victim: str) -> None:
        self.victim = victim
        self.places: dict[str, list[int]] = {}

    def __call__(self, job: PhotoJob, text: str) -> None:
        if found := re.search(r"process (\d+) of ", text):
            self.places.setdefault(job.input, []).append(int(found[1]))
            if self.places.get(self.victim) == [int(found[1])]:
                os.kill(int(found[1]), signal.SIGKILL)


def test_a_killed_worker_costs_its_photo_an_attempt(cluster: None, photos: Path, tmp_path: Path) -> None:
    out = tmp_path / "svgs"
    work = Vectorize(
        open_folder(f"file://{photos}", "IN_DIR"),
        open_folder(f"file://{out}", "OUT_DIR"),
        make_config(**SETTINGS),
        background=None,
    )
    jobs, killer = find_jobs(work.source.names(recursive=True)), Killer("p1.png")
    engine = RayEngine("cpu", 1, None, 1, None)
    with closing(Journal(work.target)) as journal:
        records = {record.input: record for record in run_batch(jobs, work, engine, journal, killer)}

    assert sorted(records) == sorted(job.input for job in jobs)
    assert "bad.png must be a complete image" in (records.pop("bad.png").error or "")
    assert {name: (record.error, record.attempts) for name, record in records.items()} == {
        "more/p4.png": (None, 1), "p0.png": (None, 1), "p1.png": (None, 2), "p2.png": (None, 1), "p3.png": (None, 1),
    }  # fmt: skip
    # Two workers, kept from photo to photo, and the replacement of the dead one, if it started in time.
    assert len({pid for pids in killer.places.values() for pid in pids}) <= 3
    first, second = killer.places["p1.png"]
    assert first != second
    assert sorted(os.listdir(out)) == [CSV_NAME, JSON_NAME, "more", *(f"p{k}.svg" for k in range(4))]

    # The same batch by the command: only the bad photo is left, and the bytes are those of a single machine.
    times = {path: path.stat().st_mtime_ns for path in out.rglob("*.svg")}
    options = [*OPTIONS, "--recursive", "--engine", "ray", "--json"]
    result = invoke("batch", f"file://{photos}", f"file://{out}", *options)
    assert result.exit_code == 1, result.output
    assert result.stdout, result.exception
    facts = json.loads(result.stdout)
    assert (facts["skipped"], facts["done"], facts["failed"]) == (5, 0, 1)
    assert {path: path.stat().st_mtime_ns for path in out.rglob("*.svg")} == times
    alone = tmp_path / "p1.svg"
    assert invoke("run", photos / "p1.png", alone, "-q", *OPTIONS).exit_code == 0
    assert alone.read_bytes() == (out / "p1.svg").read_bytes()


def test_what_is_not_tried_again_is_given_up(cluster: None, tmp_path: Path) -> None:
    jobs = ["dies", "fails", "a"]
    engine = RayEngine("cpu", 1, None, 0, None)
    outcomes = {outcome.job: outcome for outcome in engine.run(jobs, Trial(tmp_path), _ignore)}
    assert {job: outcomes[job].attempts for job in jobs} == {"dies": 1, "fails": 1, "a": 1}
    assert outcomes["a"].error is None
    assert outcomes["fails"].error == "ValueError: no luck"
    outcome = outcomes["dies"]
    assert outcome.error is not None
    assert outcome.error.startswith("the Ray worker died (")
    assert "\n" not in outcome.error


class Unloadable:
    """Work that a worker cannot load."""

    def __reduce__(self) -> tuple[object, ...]:
        return int, ("no number",)


def test_workers_that_never_begin_are_an_error(cluster: None, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("warpvec.batch.engines.ray._FAILED_STARTS_MAX", 1)
    with pytest.raises(RuntimeError, match="workers die before they start: .*ValueError: invalid literal for int"):
        list(RayEngine("cpu", 1, 1, 1, None).run(["a"], Unloadable(), _ignore))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("device", "threads", "words"), [("cpu", 3, "must have 3 CPU for a worker, got 2 CPU"), ("cuda", 1, "1 GPU")]
)
def test_a_cluster_without_room_is_an_input_error(
    cluster: None, device: str, threads: int, words: str, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=words):
        list(RayEngine(device, threads, None, 0, None).run(["a"], Trial(tmp_path), _ignore))


# without a cluster


def test_a_device_by_number_is_refused(photos: Path, tmp_path: Path) -> None:
    result = invoke("batch", photos, tmp_path / "svgs", "--engine", "ray", "--device", "cuda:1")
    assert_refused(result, "--device must be auto, cpu or cuda with Ray", "cuda:1")


def test_without_ray_the_extra_is_named(photos: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "ray", None)
    assert_refused(invoke("batch", photos, tmp_path / "svgs", "--engine", "ray"), "warpvec[cluster]")
