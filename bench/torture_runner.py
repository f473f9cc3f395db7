"""Run cases of `torture_case` in worker processes that may crash, hang or fill the memory, and count how they end."""

from __future__ import annotations

import contextlib
import json
import os
import select
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from torture_case import FAULTS, MAX_MEMORY

POLL_SECONDS = 0.1
"""Time between two looks at the memory of a worker and the processes that it started."""

START_SECONDS = 120.0
"""Longest start of a worker: importing torch, and what the kind prepares for its first case."""

REPORT_BYTES = 4000
"""Length of the end of stderr that a report of a fault holds, with the traceback of a crash or hang."""


@dataclass(frozen=True)
class Fault:
    """A case that ended badly. `kind`, `seed` and `number` are all that is needed to run it again."""

    kind: str
    seed: int
    number: int
    name: str
    outcome: str
    detail: str
    stderr: str = ""


@dataclass
class Tally:
    """The counts of one kind."""

    outcomes: Counter[str] = field(default_factory=Counter)
    seconds: float = 0.0
    slowest: float = 0.0
    peak: int = 0

    def add(self, answer: dict[str, Any]) -> None:
        """Count one case."""
        self.outcomes[answer["outcome"]] += 1
        self.seconds += answer["seconds"]
        self.slowest, self.peak = max(self.slowest, answer["seconds"]), max(self.peak, answer["peak"])


class Worker:
    """A process of `torture_worker`, started again after every fault that may have damaged it."""

    def __init__(self, folder: Path, patience: float = 1.0) -> None:
        self._folder, self._patience = folder, patience
        self._process: subprocess.Popen[bytes] | None = None

    def run(self, kind: str, seed: int, number: int) -> dict[str, Any]:
        """Run one case; return name, outcome, detail, seconds, peak in bytes and the end of stderr."""
        process = self._start() if self._process is None else self._process
        self._folder.joinpath("journal.json").write_text(json.dumps([kind, seed, number]))
        self._stderr.seek(0)
        self._stderr.truncate()
        asked = time.monotonic()
        assert process.stdin is not None
        self._peak = 0
        case: dict[str, Any] = {"name": "before its start", "seconds": START_SECONDS}
        try:
            process.stdin.write(json.dumps({"kind": kind, "seed": seed, "number": number}).encode() + b"\n")
            process.stdin.flush()
            case = self._answer(START_SECONDS)
            answer = {**case, **self._answer(case["seconds"])}
            answer["peak"] = max(answer["peak"], self._peak)
            if answer["outcome"] == "memory":
                self.stop()
        except (EOFError, BrokenPipeError):
            answer = {**case, "outcome": "crash", "detail": f"exit code {process.wait()}"}
            self._forget()
        except _Stopped as stopped:
            answer = {**case, "outcome": stopped.outcome, "detail": str(stopped)}
        return {"peak": self._peak, **answer, "stderr": self._end_of_stderr(), "seconds": time.monotonic() - asked}

    def stop(self) -> None:
        """End the process and what it started."""
        if self._process is not None:
            _kill(self._process.pid)
            self._forget()

    def keep_input(self, path: Path) -> None:
        """Copy the input of the last case to ``path``."""
        shutil.copyfile(self._folder / "input", path)

    def _forget(self) -> None:
        """Close what belongs to the process, which has ended or was killed."""
        assert self._process is not None and self._process.stdin is not None and self._process.stdout is not None
        self._process.wait()
        for stream in (self._process.stdin, self._process.stdout, self._stderr):
            with contextlib.suppress(BrokenPipeError):
                stream.close()
        self._process = None

    def _start(self) -> subprocess.Popen[bytes]:
        self._folder.mkdir(parents=True, exist_ok=True)
        self._received = b""
        self._stderr = open(self._folder / "stderr", "w+b")  # noqa: SIM115
        command = [sys.executable, str(Path(__file__).with_name("torture_worker.py")), str(self._folder)]
        environment = {**os.environ, "OMP_NUM_THREADS": "1", "PYTHONPATH": _python_path()}
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._stderr, env=environment,
            start_new_session=True,
        )  # fmt: skip
        return self._process

    def _answer(self, seconds: float) -> dict[str, Any]:
        """Return the next line of the worker, and watch its time and memory until then."""
        assert self._process is not None and self._process.stdout is not None
        stdout, deadline = self._process.stdout, time.monotonic() + seconds * self._patience
        while b"\n" not in self._received:
            if select.select([stdout], [], [], POLL_SECONDS)[0]:
                received = os.read(stdout.fileno(), 2**16)
                if not received:
                    raise EOFError
                self._received += received
            else:
                self._peak = max(self._peak, *map(_resident, family(self._process.pid)))
                if self._peak > MAX_MEMORY:
                    self._abort()
                    raise _Stopped("memory", f"{self._peak >> 20} MB")
                if time.monotonic() > deadline:
                    self._abort()
                    raise _Stopped("hang", f"not done in {seconds:g} s")
        line, _, self._received = self._received.partition(b"\n")
        answer: dict[str, Any] = json.loads(line)
        return answer

    def _abort(self) -> None:
        """Stop the worker in a way that writes its traceback to stderr."""
        assert self._process is not None
        self._process.send_signal(signal.SIGABRT)
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(2)
        self.stop()

    def _end_of_stderr(self) -> str:
        return (self._folder / "stderr").read_bytes()[-REPORT_BYTES:].decode(errors="replace")


class _Stopped(Exception):
    """The worker was stopped by its watch."""

    def __init__(self, outcome: str, detail: str) -> None:
        super().__init__(detail)
        self.outcome = outcome


class Torture:
    """Many cases of several kinds on several workers.

    Args:
        shares: kind -> its share of the time.
        seed: the seed of all cases.
        folder: receives a report of every fault, and its input.
        report: called with every fault.
        patience: factor of all time limits, for a machine that is busy with other work.
    """

    def __init__(
        self,
        shares: dict[str, float],
        seed: int,
        folder: Path,
        report: Callable[[Fault], None],
        patience: float = 1.0,
    ) -> None:
        self._patience = patience
        self._shares, self._seed, self._folder, self._report = shares, seed, folder, report
        self._lock, self._stopping = threading.Lock(), False
        self._numbers: Counter[str] = Counter()
        self.tallies = {kind: Tally() for kind in shares}
        self.faults: list[Fault] = []

    def run(self, worker_count: int, seconds: float, limits: dict[str, int] | None = None) -> None:
        """Run cases for so many ``seconds``, or until each kind had as many as ``limits`` says."""
        self._folder.mkdir(parents=True, exist_ok=True)
        self._deadline, self._limits = time.monotonic() + seconds, limits or {}
        threads = [threading.Thread(target=self._work, args=[index]) for index in range(worker_count)]
        for thread in threads:
            thread.start()
        try:
            for thread in threads:
                thread.join()
        except KeyboardInterrupt:
            self._stopping = True
            for thread in threads:
                thread.join()

    def _work(self, index: int) -> None:
        worker = Worker(self._folder / f"worker-{index}", self._patience)
        try:
            while (chosen := self._next()) is not None:
                answer = worker.run(chosen[0], self._seed, chosen[1])
                self._count(*chosen, answer, worker)
        finally:
            worker.stop()
            shutil.rmtree(self._folder / f"worker-{index}", ignore_errors=True)

    def _next(self) -> tuple[str, int] | None:
        """Choose the kind that had the least of its share of the time so far, and the number of its next case."""
        with self._lock:
            open_kinds = [kind for kind in self._shares if self._numbers[kind] < self._limits.get(kind, sys.maxsize)]
            if self._stopping or not open_kinds or time.monotonic() > self._deadline:
                return None
            kind = min(open_kinds, key=lambda kind: self.tallies[kind].seconds / self._shares[kind])
            # A little time for a case that has started, so that the workers do not all take the same kind.
            self.tallies[kind].seconds += 1e-3
            self._numbers[kind] += 1
            return kind, self._numbers[kind] - 1

    def _count(self, kind: str, number: int, answer: dict[str, Any], worker: Worker) -> None:
        with self._lock:
            self.tallies[kind].add(answer)
            if answer["outcome"] not in FAULTS:
                return
            fault = Fault(kind, self._seed, number, *(answer[key] for key in ("name", "outcome", "detail", "stderr")))
            self.faults.append(fault)
            path = self._folder / f"{kind}-{self._seed}-{number}.json"
            path.write_text(json.dumps(asdict(fault), indent=1))
            worker.keep_input(path.with_suffix(".input"))
            self._report(fault)


def family(pid: int) -> list[int]:
    """Return ``pid`` and all processes that it started, directly or not."""
    found = [pid]
    for parent in found:
        with contextlib.suppress(OSError):  # it, or one of its threads, ended meanwhile
            for path in list(Path(f"/proc/{parent}/task").glob("*/children")):
                with contextlib.suppress(OSError):
                    found += map(int, path.read_text().split())
    return found


def _resident(pid: int) -> int:
    try:
        return int(Path(f"/proc/{pid}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    except (OSError, IndexError):
        return 0


def _kill(pid: int) -> None:
    for member in family(pid):
        try:
            os.kill(member, signal.SIGKILL)
        except ProcessLookupError:
            continue


def _python_path() -> str:
    """Return the search path that finds this folder and the checkout, whatever folder a worker is in."""
    here = Path(__file__).resolve().parent
    return os.pathsep.join([str(here), str(here.parent), *filter(None, [os.environ.get("PYTHONPATH")])])
