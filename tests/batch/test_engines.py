"""Engines: every job has one outcome even if workers die; workers are kept from job to job."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from functools import partial
from pathlib import Path

import pytest
from batch_work import Trial
from children import runs, wait_for

from warpvec.batch.engines.base import Failure, Outcome, Queue, WorkerShare
from warpvec.batch.engines.local import LocalEngine, machine_shares

TESTS = Path(__file__).parents[1] / "support"


def _run(jobs: list[str], folder: Path, *, workers: int = 1, retries: int = 1) -> dict[str, Outcome[str, str]]:
    engine = LocalEngine(["cpu"], 1, workers, retries)
    outcomes = list(engine.run(jobs, Trial(folder), lambda job, text: None))
    assert sorted(outcome.job for outcome in outcomes) == sorted(jobs)
    return {outcome.job: outcome for outcome in outcomes}


# the local engine


def test_workers_are_kept_from_job_to_job(tmp_path: Path) -> None:
    outcomes = _run([f"job{k}" for k in range(6)], tmp_path, workers=2)
    assert {outcome.attempts for outcome in outcomes.values()} == {1}
    pids = {outcome.value for outcome in outcomes.values()}
    assert 1 <= len(pids) <= 2
    assert str(os.getpid()) not in pids


def test_each_worker_prepares_once_before_its_first_job(tmp_path: Path) -> None:
    engine = LocalEngine(["cpu"], 1, 1, retries=0, prepare=partial(_note_process, tmp_path / "prepared"))
    outcomes = list(engine.run(["a", "b"], Trial(tmp_path), lambda job, text: None))
    assert {outcome.value for outcome in outcomes} == {(tmp_path / "prepared").read_text()}


def _note_process(path: Path) -> None:
    with path.open("x") as file:
        file.write(str(os.getpid()))


def test_a_worker_that_dies_costs_only_its_job(tmp_path: Path) -> None:
    outcomes = _run(["a", "once", "dies", "b"], tmp_path, retries=2)
    assert [outcomes[job].attempts for job in ("a", "b", "once", "dies")] == [1, 1, 2, 3]
    assert outcomes["once"].error is None
    assert outcomes["dies"].error == "the worker process was killed by signal 9 (out of memory?)"
    assert outcomes["dies"].value is None


def test_a_failure_gets_a_new_process_and_an_input_error_no_second_attempt(tmp_path: Path) -> None:
    outcomes = _run(["wrong", "fails", "a"], tmp_path)
    assert (outcomes["wrong"].attempts, outcomes["fails"].attempts) == (1, 2)
    assert outcomes["wrong"].error == "IN must be right, got wrong; mend it"
    assert outcomes["fails"].error == "ValueError: no luck"
    first, second = Trial(tmp_path).begun("fails")
    assert first != second
    assert Trial(tmp_path).begun("wrong") == [first]


def test_the_caller_is_notified_where_a_job_runs_and_how_far_it_is(tmp_path: Path) -> None:
    news: list[tuple[str, str]] = []
    engine = LocalEngine(["cpu"], 3, 1, retries=1)
    outcomes = list(engine.run(["once"], Trial(tmp_path), lambda job, text: news.append((job, text))))
    first, second = Trial(tmp_path).begun("once")
    assert [text for _, text in news] == [
        f"attempt 1 in process {first}",
        "once on 3 threads",
        "tried again: the worker process was killed by signal 9 (out of memory?)",
        f"attempt 2 in process {second}",
        "once on 3 threads",
    ]
    assert outcomes == [Outcome("once", str(second), None, 2)]


def test_closing_ends_the_workers_in_the_middle_of_a_job(tmp_path: Path) -> None:
    work = Trial(tmp_path)
    outcomes = LocalEngine(["cpu"], 1, 2, retries=0).run(["endless", "a"], work, lambda job, text: None)
    assert next(outcomes).job == "a"
    wait_for(lambda: work.begun("endless"))
    outcomes.close()
    assert not any(runs(pid) for pid in work.begun("endless"))


def test_no_worker_outlives_who_started_it(tmp_path: Path) -> None:
    code = (
        "from pathlib import Path; from batch_work import Trial; "
        " from warpvec.batch.engines.local import LocalEngine;"
        f" list(LocalEngine(['cpu'], 1, 1, 0).run(['endless'], Trial(Path({str(tmp_path)!r})), print))"
    )
    path = os.pathsep.join([str(TESTS), str(TESTS.parent)])
    environment = {**os.environ, "PYTHONPATH": path}
    with subprocess.Popen([sys.executable, "-c", code], env=environment, stdout=subprocess.DEVNULL) as starter:
        wait_for(lambda: Trial(tmp_path).begun("endless"))
        starter.send_signal(signal.SIGKILL)
    (pid,) = Trial(tmp_path).begun("endless")
    wait_for(lambda: not runs(pid))


# the queue


def test_a_job_to_be_tried_again_goes_behind_all_others() -> None:
    queue = Queue(["a", "b"], 1, lambda job, text: None)
    first = queue.pop()
    assert first is not None
    assert queue.finish(first, Failure("lost", final=False)) is None
    assert [attempt and (attempt.job, attempt.number) for attempt in (queue.pop(), queue.pop(), queue.pop())] == [
        ("b", 1),
        ("a", 2),
        None,
    ]
    assert queue.unfinished == 2


# shares


@pytest.mark.parametrize(
    ("devices", "threads", "jobs", "job_count", "expected"),
    [
        (["cpu"], None, None, 99, [WorkerShare("cpu", 1)] * 8),
        (["cpu"], 4, None, 99, [WorkerShare("cpu", 4)] * 2),
        (["cpu"], 20, None, 99, [WorkerShare("cpu", 20)]),
        (["cpu"], None, 3, 99, [WorkerShare("cpu", 2)] * 3),
        (["cpu"], 5, 3, 99, [WorkerShare("cpu", 5)] * 3),
        (["cpu"], None, 20, 99, [WorkerShare("cpu", 1)] * 20),
        (["cpu"], None, 5000, 9999, [WorkerShare("cpu", 1)] * 32),
        (["cpu"], 5000, 5000, 9999, [WorkerShare("cpu", 5000)] * 32),
        (["cpu"], None, None, 2, [WorkerShare("cpu", 4)] * 2),
        (["cpu"], None, 3, 2, [WorkerShare("cpu", 4)] * 2),
        (["cuda:0", "cuda:1"], None, None, 99, [WorkerShare("cuda:0", 4), WorkerShare("cuda:1", 4)]),
        (
            ["cuda:0", "cuda:1"],
            1,
            3,
            99,
            [WorkerShare("cuda:0", 1), WorkerShare("cuda:1", 1), WorkerShare("cuda:0", 1)],
        ),
        (["cuda:1"], None, None, 99, [WorkerShare("cuda:1", 8)]),
    ],
)
def test_devices_and_cores_are_shared_out(
    devices: list[str],
    threads: int | None,
    jobs: int | None,
    job_count: int,
    expected: list[WorkerShare],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("warpvec.batch.engines.local.core_count", lambda: 8)
    assert machine_shares(devices, threads, jobs, job_count) == expected
