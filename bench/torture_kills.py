"""Kill runs, and send them signals, at random moments. Check their files, their leftovers and their exit codes.

A killed run (SIGKILL) is run again, with `--resume` if it has written a checkpoint. The file must then have the bytes
of an undisturbed run, and no temporary file may be left. A run that gets SIGINT, SIGTERM or SIGHUP must exit with 128
plus the number of the signal, write the whole file if the fit had begun and none otherwise, and leave no temporary
file. Python itself takes some 20 ms to start and to end: a signal at that time ends the process without the help of
warpvec, which subprocess reports as a negative exit code.
"""

from __future__ import annotations

import signal
import subprocess
import sys
import tempfile
import time
from functools import cache
from pathlib import Path
from random import Random
from typing import NamedTuple
from xml.etree import ElementTree

from torture_case import OK, Case, Wrong, limit
from torture_disks import write_photo

SIGNALS = (signal.SIGKILL, signal.SIGINT, signal.SIGTERM, signal.SIGHUP)

FIT = (
    "--curves", "32", "--initial-curves", "8", "--inflation-gap", "20", "--iterations", "150", "--device", "cpu", "-q",
    "--checkpoint", "checkpoint", "--every", "1",
)  # fmt: skip
"""A fit of about a second, half of which goes into writing 150 checkpoints."""

EARLY_SHARE = 0.25
"""Share of the moments before the first checkpoint, while Python starts and modules are loaded."""

ATTEMPTS_MAX = 20
"""Largest number of runs for one case. A run that is over before its moment is done again with another moment."""

RUN_SECONDS, CASE_SECONDS = 60.0, 180.0
"""Longest time of a run, and of a case: three runs or so, and for the first case two more, which measure."""

_EXITING = 4
"""Flag of a process that Linux is ending, to which no signal matters any more: PF_EXITING."""


class Hit(NamedTuple):
    """A run that a signal has hit: its exit code and stderr, and which files were there before the signal."""

    code: int
    stderr: str
    had_checkpoint: bool
    had_file: bool


def case(chance: Random) -> Case:
    """Return one kill or one signal."""
    undisturbed()  # here, and not in the process of each case
    number = chance.choice(SIGNALS)
    return Case(f"run {number.name}", lambda folder: check(folder, number, chance), seconds=CASE_SECONDS)


def check(folder: Path, number: signal.Signals, chance: Random) -> str:
    """Send ``number`` to a run at a random moment; return `OK`.

    Raises:
        Wrong: a rule is broken.
    """
    start, rest, svg = undisturbed()
    for _ in range(ATTEMPTS_MAX):
        for path in folder.iterdir():
            path.unlink()
        is_early = chance.random() < EARLY_SHARE
        hit = _hit(folder, number, is_early, chance.random() * (start if is_early else rest))
        if hit is not None and number == signal.SIGKILL:
            return _check_killed(folder, svg)
        if hit is not None:
            return _check_ended(folder, number, hit)
    raise Wrong(f"no run of {ATTEMPTS_MAX} was hit by {number.name}")


@cache
def undisturbed() -> tuple[float, float, bytes]:
    """Return the seconds of a run until its first checkpoint and from there to its end, and the bytes of its file."""
    with tempfile.TemporaryDirectory() as name:
        folder, begin = Path(name), time.monotonic()
        process = _start(folder)
        _wait_for_checkpoint(folder, process)
        start = time.monotonic() - begin
        _, stderr = process.communicate()
        if process.returncode != 0:
            raise RuntimeError(f"the undisturbed run failed: {stderr}")
        return start, time.monotonic() - begin - start, (folder / "out.svg").read_bytes()


def _check_killed(folder: Path, svg: bytes) -> str:
    process = _start(folder, *(["--resume", "checkpoint"] if (folder / "checkpoint").exists() else []))
    _, stderr = process.communicate(timeout=limit(RUN_SECONDS))
    if process.returncode != 0:
        raise Wrong(f"the run after a kill exited with {process.returncode}: {stderr[-300:]}")
    if (folder / "out.svg").read_bytes() != svg:
        raise Wrong("the run after a kill wrote other bytes")
    _check_leftovers(folder, "the run after a kill")
    return OK


def _check_ended(folder: Path, number: signal.Signals, hit: Hit) -> str:
    out = folder / "out.svg"
    _check_leftovers(folder, number.name)
    if hit.had_checkpoint and not out.exists():
        raise Wrong(f"{number.name} during the fit left no file; exit code {hit.code}")
    if out.exists():
        _check_whole(out)
    by_system = hit.code == -number and (hit.had_file or not hit.had_checkpoint)
    words = "" if out.exists() else "warpvec: interrupted before there was a drawing; none is written\n"
    if not by_system and (hit.code != 128 + number or hit.stderr not in ("", words)):
        raise Wrong(f"{number.name} ended in exit code {hit.code}: {hit.stderr[-300:]}")
    return OK


def _check_leftovers(folder: Path, what: str) -> None:
    left = {path.name for path in folder.iterdir()} - {"photo.png", "out.svg", "checkpoint"}
    if left:
        raise Wrong(f"{what} left {sorted(left)}")


def _check_whole(out: Path) -> None:
    from warpvec.svg.resvg import rasterize

    try:
        ElementTree.fromstring(out.read_bytes())
        rasterize(out.read_text(), sandboxed=False)
    except Exception as error:
        raise Wrong(f"the file is not whole: {error}") from error


def _hit(folder: Path, number: signal.Signals, is_early: bool, seconds: float) -> Hit | None:
    """Start a run and send it ``number``; return None if it was over before.

    The moment is ``seconds`` after the start, or after the first checkpoint unless ``is_early``.
    """
    process = _start(folder)
    try:
        if not is_early:
            _wait_for_checkpoint(folder, process)
        time.sleep(seconds)
        had_checkpoint, had_file = (folder / "checkpoint").exists(), (folder / "out.svg").exists()
        is_over = process.poll() is not None or _is_exiting(process.pid)
        process.send_signal(number)
        _, stderr = process.communicate(timeout=limit(RUN_SECONDS))
    except subprocess.TimeoutExpired:
        raise Wrong(f"the run goes on after {number.name}") from None
    finally:
        process.kill()
    return None if is_over else Hit(process.returncode, stderr, had_checkpoint, had_file)


def _is_exiting(pid: int) -> bool:
    facts = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return bool(int(facts[6]) & _EXITING)


def _start(folder: Path, *options: str) -> subprocess.Popen[str]:
    photo = write_photo(folder)
    command = [sys.executable, "-m", "warpvec", "run", photo.name, "out.svg", *FIT, *options]
    return subprocess.Popen(
        command, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, start_new_session=True
    )


def _wait_for_checkpoint(folder: Path, process: subprocess.Popen[str]) -> None:
    while not (folder / "checkpoint").exists() and process.poll() is None:
        time.sleep(0.001)
