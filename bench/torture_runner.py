"""Run cases of `torture_case`, each in a process of its own that may crash, hang or fill the memory.

A case runs in a fork of this process, which has loaded torch and the kernels already. This process only watches.
"""

from __future__ import annotations

import contextlib
import faulthandler
import importlib
import json
import os
import random
import resource
import shutil
import signal
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path

from torture_case import FAULTS, MAX_MEMORY, OK, REFUSED, Case, Wrong, be_patient, limit

POLL_SECONDS = 0.02
"""Time between two looks at the cases that run."""

ADDRESS_SPACE = 2**34
"""Address space of a case in bytes, so that a fault cannot take the memory of the machine."""

MAX_MESSAGE = 500
"""Longest message of an `InputError`; it is read as one line."""


@dataclass(frozen=True)
class Ended:
    """The end of a case. ``kind``, ``seed`` and ``number`` are all that is needed to run it again."""

    kind: str
    seed: int
    number: int
    name: str
    outcome: str
    detail: str
    seconds: float
    peak: int
    stderr: str


@dataclass
class Tally:
    """The counts of one kind."""

    outcomes: Counter[str] = field(default_factory=Counter)
    seconds: float = 0.0
    slowest: float = 0.0
    peak: int = 0

    def add(self, ended: Ended) -> None:
        """Count one case."""
        self.outcomes[ended.outcome] += 1
        self.seconds += ended.seconds
        self.slowest, self.peak = max(self.slowest, ended.seconds), max(self.peak, ended.peak)


def case_of(kind: str, seed: int, number: int) -> Case:
    """Return a case by its name; the same on every machine."""
    if kind == "corpus":
        return importlib.import_module("torture_corpus").case_at(number)
    module = importlib.import_module(f"torture_{kind}")
    sys.set_int_max_str_digits(0)  # the cases have numbers of any length, but warpvec meets them with the limit
    try:
        case: Case = module.case(random.Random(f"{kind} {seed} {number}"))
    finally:
        sys.set_int_max_str_digits(sys.int_info.default_max_str_digits)
    return case


def run_all(
    shares: dict[str, float], seed: int, limits: dict[str, int], folder: Path,
    worker_count: int = 1, seconds: float = 3600.0, patience: float = 1.0, report: Callable[[Ended], None] = print,
) -> tuple[dict[str, Tally], list[Ended]]:  # fmt: skip
    """Run cases for so many ``seconds``, or until each kind has had as many as ``limits`` says.

    Args:
        shares: kind -> its share of the time.
        seed: the seed of all cases.
        limits: kind -> most cases.
        folder: receives a report of every fault, and its input.
        worker_count: number of cases at a time.
        seconds: time for all.
        patience: factor of all time limits, for a machine that is busy with other work.
        report: called with every fault.

    Returns:
        The counts of each kind, and the faults.
    """
    folder.mkdir(parents=True, exist_ok=True)
    os.environ["PYTHONPATH"] = str(Path(__file__).resolve().parents[1])  # for commands that cases start elsewhere
    tallies, numbers, faults = {kind: Tally() for kind in shares}, Counter[str](), []
    deadline, running = time.monotonic() + seconds, list[Running]()
    try:
        while True:
            wanted = [kind for kind in shares if numbers[kind] < limits.get(kind, sys.maxsize)]
            if len(running) < worker_count and wanted and time.monotonic() < deadline:
                kind = min(wanted, key=lambda kind: (tallies[kind].seconds + 1e-3 * numbers[kind]) / shares[kind])
                running.append(Running(kind, seed, numbers[kind], folder, patience))
                numbers[kind] += 1
                continue
            if not running:
                return tallies, faults
            for each in [each for each in running if each.has_ended()]:
                running.remove(each)
                ended = each.finish()
                tallies[ended.kind].add(ended)
                if ended.outcome in FAULTS:
                    faults.append(ended)
                    _keep(ended, each.case, folder)
                    report(ended)
            time.sleep(POLL_SECONDS)
    finally:
        for each in running:
            each.kill()


def _keep(fault: Ended, case: Case, folder: Path) -> None:
    path = folder / f"{fault.kind}-{fault.seed}-{fault.number}.json"
    path.write_text(json.dumps(vars(fault), indent=1))
    path.with_suffix(".input").write_bytes(case.data)


class Running:
    """A case in a process that is forked from this one."""

    def __init__(self, kind: str, seed: int, number: int, folder: Path, patience: float = 1.0) -> None:
        self._label = kind, seed, number
        be_patient(patience)
        self.case = case_of(kind, seed, number)
        self._place = Path(tempfile.mkdtemp(dir=folder.resolve(), prefix="case-"))
        self._begin, self._peak, self._killed = time.monotonic(), 0, ""
        self._usage: tuple[int, int] | None = None
        with warnings.catch_warnings():
            warnings.simplefilter(
                "ignore"
            )  # Python 3.12 warns of threads: those of warpvec stand it, see test_thread_pool
            self._pid = os.fork()
        if self._pid == 0:
            _serve(self.case, self._place)

    def has_ended(self) -> bool:
        """Return whether the process has ended; kill it if it takes too long or too much memory."""
        if self._usage is None:
            pid, status, usage = os.wait4(self._pid, os.WNOHANG)
            if pid:
                self._usage = os.waitstatus_to_exitcode(status), usage.ru_maxrss << 10
                return True
            self._peak = max(self._peak, *map(_resident, family(self._pid)))
            if self._peak > MAX_MEMORY:
                self.kill("memory")
            elif time.monotonic() - self._begin > limit(self.case.seconds):
                self.kill("hang")
        return self._usage is not None

    def kill(self, reason: str = "stopped") -> None:
        """Kill the process and all that it started. It first writes its traceback to stderr."""
        members = family(self._pid)
        os.kill(self._pid, signal.SIGABRT)
        time.sleep(0.2)
        for member in members:
            with contextlib.suppress(ProcessLookupError):
                os.kill(member, signal.SIGKILL)
        _, _, usage = os.wait4(self._pid, 0)
        self._killed, self._usage = reason, (0, usage.ru_maxrss << 10)

    def finish(self) -> Ended:
        """Return how the process ended, and remove its folder."""
        assert self._usage is not None
        (code, peak), seconds = self._usage, time.monotonic() - self._begin
        stderr, answer = (_text(self._place / name) for name in ("stderr", "answer"))
        outcome, _, detail = answer.partition("\n")
        peak = max(peak, self._peak)
        if self._killed:
            outcome, detail = self._killed, f"after {seconds:.1f} s, {peak >> 20} MB"
        elif code or not outcome:
            outcome, detail = "crash", f"exit code {code}"
        elif peak > MAX_MEMORY:
            outcome, detail = "memory", f"{peak >> 20} MB"
        _remove(self._place)
        return Ended(*self._label, self.case.name, outcome, detail, seconds, peak, stderr)


def _serve(case: Case, place: Path) -> None:
    """Run a case in the forked process, write its outcome to a file, and end the process."""
    try:
        stderr = os.open(place / "stderr", os.O_RDWR | os.O_CREAT | os.O_APPEND)
        for number, stream in enumerate((os.open(os.devnull, os.O_RDWR), os.open(os.devnull, os.O_RDWR), stderr)):
            os.dup2(stream, number)
        _limit(place)
        outcome, detail = _result(case, place / "case")
        left = [*os.listdir(place / "tmp"), *(str(path) for path in (place / "case").rglob(".warpvec-*"))]
        if left and outcome in (OK, REFUSED):
            outcome, detail = "wrong", f"left behind: {left[:3]}"
        (place / "answer").write_text(f"{outcome}\n{detail}", errors="replace")
    except BaseException:  # no answer, which counts as a crash
        traceback.print_exc()
    finally:
        os._exit(0)


def _limit(place: Path) -> None:
    """Prepare this process for a case: its limits, its folders, and how it ends."""
    os.setsid()
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGALRM):
        signal.signal(number, signal.SIG_DFL)
    faulthandler.enable(open(2, "w", closefd=False))  # noqa: SIM115 - it is used until the end
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_AS, (ADDRESS_SPACE, ADDRESS_SPACE))
    resource.setrlimit(resource.RLIMIT_FSIZE, (2**31, 2**31))  # huge files must not fill the disk
    warnings.resetwarnings()
    warnings.simplefilter("error")
    for name in ("case", "tmp"):
        (place / name).mkdir()
    os.chdir(place / "case")
    os.environ.update(TMPDIR=str(place / "tmp"), OMP_NUM_THREADS="1")
    tempfile.tempdir = str(place / "tmp")
    Path("/proc/self/clear_refs").write_text("5")  # forgets the peak of the process that this one was forked from


def _result(case: Case, place: Path) -> tuple[str, str]:
    from warpvec.errors import InputError

    try:
        outcome = case.run(place)
        return (outcome, "") if outcome in (OK, REFUSED) else ("wrong", f"the case returned {outcome!r}")
    except InputError as error:
        message = str(error)
        if "\n" in message or len(message) > MAX_MESSAGE:
            return "wrong", f"a message of {len(message)} characters: {message!r}"[:MAX_MESSAGE]
        return REFUSED, ""
    except Wrong as error:
        return "wrong", str(error)
    except BaseException as error:  # SystemExit and Rust's PanicException among them
        return "exception", f"{type(error).__name__}: {error} ({_place_of(error)})"[:MAX_MESSAGE]


def _place_of(error: BaseException) -> str:
    """Return file and line of the code of warpvec that the error left last, or else of any code."""
    places = [(Path(frame.filename), frame.lineno) for frame in traceback.extract_tb(error.__traceback__)]
    path, line = ([place for place in places if "warpvec" in place[0].parts] or places)[-1]
    return f"{path.parent.name}/{path.name}:{line}"


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


def _text(path: Path) -> str:
    """Return the beginning and the end of a file, or nothing if there is none."""
    data = path.read_bytes() if path.exists() else b""
    return (data if len(data) <= 8000 else data[:4000] + b"\n...\n" + data[-4000:]).decode(errors="replace")


def _remove(place: Path) -> None:
    """Remove a folder, also one in which the case has made folders that cannot be entered."""
    for root, folders, _ in os.walk(place):
        for path in (os.path.join(root, name) for name in folders):
            if not os.path.islink(path):
                os.chmod(path, 0o700)
    shutil.rmtree(place, ignore_errors=True)


def table(tallies: dict[str, Tally]) -> str:
    """Return the counts by kind as a table in Markdown."""
    names = [OK, REFUSED, *FAULTS]
    total = Tally(sum((tally.outcomes for tally in tallies.values()), Counter()))
    total.slowest = max(tally.slowest for tally in tallies.values())
    total.peak = max(tally.peak for tally in tallies.values())
    return "\n".join([
        f"| kind | cases | {' | '.join(names)} | slowest | peak |", "|---" * (len(names) + 4) + "|",
        *(_row(kind, tally, names) for kind, tally in {**tallies, "all": total}.items()),
    ])  # fmt: skip


def _row(kind: str, tally: Tally, names: Iterable[str]) -> str:
    counts = " | ".join(f"{tally.outcomes[name]:,}" for name in names)
    return f"| {kind} | {tally.outcomes.total():,} | {counts} | {tally.slowest:.1f} s | {tally.peak >> 20:,} MB |"
