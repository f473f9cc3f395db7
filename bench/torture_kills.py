"""Kill runs, and send them signals, at random moments; check what they wrote, what they left, and their exit codes.

    python bench/torture_kills.py --kills 100 --signals 30 --seed 1 --workers 2

A killed run (SIGKILL) is run again, with `--resume` if it has written a checkpoint. The file must then have the bytes
of an undisturbed run, and no temporary file may be left. A run that gets SIGINT, SIGTERM or SIGHUP must exit with 128
plus the number of the signal, write the whole file if the fit had begun and none otherwise, and leave no temporary
file.

A quarter of the moments is before the first checkpoint (Python starts, modules are loaded), the others from then to the
end of the process. Python itself takes some 20 ms to start and to end: a signal at that time ends the process without
the help of warpvec, which subprocess reports as a negative exit code, and shells as 128 plus the number all the same.
"""

from __future__ import annotations

import argparse
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from random import Random
from xml.etree import ElementTree

import numpy as np
from PIL import Image
from torture_case import OK, Case, Wrong

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)

OPTIONS = (
    "--curves",
    "32",
    "--initial-curves",
    "8",
    "--inflation-gap",
    "20",
    "--iterations",
    "150",
    "--device",
    "cpu",
    "-q",
)
"""A fit of about a second, half of which goes into writing 150 checkpoints."""

EARLY_SHARE = 0.25
"""Share of the moments before the first checkpoint."""

ATTEMPTS_MAX = 20
"""Largest number of runs for one case. A run that is over before its moment is done again with another moment."""

RUN_SECONDS = 60.0
"""A run that takes longer hangs."""

CASE_SECONDS = 180.0
"""Time for one case: three runs or so, and for the first case in a process two more, which measure."""

_EXITING = 4
"""Flag of a process that Linux is ending, to which no signal matters any more: PF_EXITING."""


@dataclass(frozen=True)
class Times:
    """Seconds of an undisturbed run until its first checkpoint and from there to its end, and the bytes of its file."""

    start: float
    rest: float
    svg: bytes


@dataclass(frozen=True)
class Hit:
    """A run that a signal has hit: its exit code and stderr, and which files were there before the signal."""

    code: int
    stderr: str
    had_checkpoint: bool
    had_file: bool


def case(chance: Random) -> Case:
    """Return one kill or one signal."""
    number = chance.choice([signal.SIGKILL, *SIGNALS])

    def run(folder: Path) -> str:
        check(folder, number, chance)
        return OK

    return Case(f"run {number.name}", run, seconds=CASE_SECONDS)


def check(folder: Path, number: signal.Signals, chance: Random) -> list[str]:
    """Send ``number`` to a run at a random moment; return notes on how it ended, for the counts.

    Raises:
        Wrong: a rule is broken.
    """
    times = undisturbed()
    for _ in range(ATTEMPTS_MAX):
        for path in folder.iterdir():
            path.unlink()
        is_early, share = chance.random() < EARLY_SHARE, chance.random()
        hit = _hit(folder, number, is_early, share * (times.start if is_early else times.rest))
        if hit is not None:
            return _check_killed(folder, hit, times) if number == signal.SIGKILL else _check_ended(folder, number, hit)
    raise Wrong(f"no run of {ATTEMPTS_MAX} was hit by {number.name}")


@cache
def undisturbed() -> Times:
    """Run once to compile the kernels, and once more to measure."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for _ in range(2):
            (folder / "checkpoint").unlink(missing_ok=True)
            begin = time.monotonic()
            process = _start(folder)
            _wait_for_checkpoint(folder, process)
            start = time.monotonic() - begin
            _, stderr = process.communicate()
            if process.returncode != 0:
                raise RuntimeError(f"the undisturbed run failed: {stderr}")
        return Times(start, time.monotonic() - begin - start, (folder / "out.svg").read_bytes())


def leftovers(folder: Path) -> list[str]:
    """Return the names of the files that a run should not leave."""
    return sorted({path.name for path in folder.iterdir()} - {"photo.png", "out.svg", "checkpoint"})


def _check_killed(folder: Path, hit: Hit, times: Times) -> list[str]:
    notes = ["with a checkpoint" if hit.had_checkpoint else "before a checkpoint"]
    notes += ["temporary file after the kill"] if leftovers(folder) else []
    process = _start(folder, *(["--resume", "checkpoint"] if (folder / "checkpoint").exists() else []))
    _, stderr = process.communicate(timeout=RUN_SECONDS)
    if process.returncode != 0:
        raise Wrong(f"the run after a kill exited with {process.returncode}: {stderr[-300:]}")
    if (folder / "out.svg").read_bytes() != times.svg:
        raise Wrong("the run after a kill wrote other bytes")
    if leftovers(folder):
        raise Wrong(f"the run after a kill left {leftovers(folder)}")
    return [*notes, "identical"]


def _check_ended(folder: Path, number: signal.Signals, hit: Hit) -> list[str]:
    out = folder / "out.svg"
    if leftovers(folder):
        raise Wrong(f"{number.name} left {leftovers(folder)}")
    if hit.had_checkpoint and not out.exists():
        raise Wrong(f"{number.name} during the fit left no file; exit code {hit.code}")
    if out.exists():
        _check_whole(out)
    by_system = hit.code == -number and (hit.had_file or not hit.had_checkpoint)
    if hit.code != 128 + number and not by_system:
        raise Wrong(f"{number.name} ended in exit code {hit.code}: {hit.stderr[-300:]}")
    if hit.stderr and not by_system:
        raise Wrong(f"{number.name} made the run print {hit.stderr[-300:]}")
    phase = "during the fit" if hit.had_checkpoint else "before the fit"
    return [
        "after the file was written" if hit.had_file else phase,
        "whole file" if out.exists() else "no file",
        "Python started or ended" if by_system else "128 + n",
    ]


def _check_whole(out: Path) -> None:
    from warpvec.svg.resvg import rasterize

    try:
        ElementTree.fromstring(out.read_bytes())
        drawn = rasterize(out.read_text(), sandboxed=False)
    except Exception as error:
        raise Wrong(f"the file is not whole: {error}") from error
    if drawn.shape != (64, 96, 3):
        raise Wrong(f"the file has another size: {drawn.shape}")


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
        _, stderr = process.communicate(timeout=RUN_SECONDS)
    except subprocess.TimeoutExpired:
        raise Wrong(f"the run goes on after {number.name}") from None
    finally:
        process.kill()
    return None if is_over else Hit(process.returncode, stderr, had_checkpoint, had_file)


def _is_exiting(pid: int) -> bool:
    facts = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return bool(int(facts[6]) & _EXITING)


def _start(folder: Path, *options: str) -> subprocess.Popen[str]:
    if not (folder / "photo.png").exists():
        noise = np.random.default_rng(5).integers(0, 256, (8, 12, 3), dtype=np.uint8)
        Image.fromarray(noise).resize((96, 64)).save(folder / "photo.png")
    saving = ("--checkpoint", "checkpoint", "--every", "1")
    return subprocess.Popen(
        [sys.executable, "-m", "warpvec", "run", "photo.png", "out.svg", *OPTIONS, *saving, *options],
        cwd=folder,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        preexec_fn=_restore_signals,
    )


def _restore_signals() -> None:
    """Let the signals reach the child even where a shell has started this script in the background."""
    for number in SIGNALS:
        signal.signal(number, signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, SIGNALS)


def _wait_for_checkpoint(folder: Path, process: subprocess.Popen[str]) -> None:
    end = time.monotonic() + RUN_SECONDS
    while not (folder / "checkpoint").exists() and process.poll() is None:
        if time.monotonic() > end:
            raise Wrong("the run writes no checkpoint")
        time.sleep(0.001)


def main() -> int:
    """Run what the command line asks for, and print the counts; return 1 if a rule was broken."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--signals", type=int, default=30, help="of each kind")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--workers", type=int, default=2)
    options = parser.parse_args()
    numbers = [signal.SIGKILL] * options.kills + [number for number in SIGNALS for _ in range(options.signals)]
    chances = [Random(f"{number.name} {options.seed} {index}") for index, number in enumerate(numbers)]
    begin, times = time.monotonic(), undisturbed()
    with ThreadPoolExecutor(options.workers) as pool:
        ends = list(pool.map(_notes, numbers, chances))
    broken = 0
    for number in dict.fromkeys(numbers):
        notes = Counter(note for each, found in zip(numbers, ends, strict=True) if each == number for note in found)
        broken += sum(count for note, count in notes.items() if note.startswith("WRONG"))
        counts = "; ".join(f"{note} {count}" for note, count in sorted(notes.items()))
        print(f"{number.name}: {numbers.count(number)} runs; {counts}")
    print(
        f"{time.monotonic() - begin:.0f} s, seed {options.seed}, {options.workers} workers; an undisturbed run takes "
        f"{times.start:.1f} s until its first checkpoint and {times.rest:.1f} s from there"
    )
    return int(broken > 0)


def _notes(number: signal.Signals, chance: Random) -> list[str]:
    with tempfile.TemporaryDirectory() as folder:
        try:
            return check(Path(folder), number, chance)
        except Wrong as error:
            print(f"WRONG: {error}", flush=True)
            return [f"WRONG: {error}"]


if __name__ == "__main__":
    sys.exit(main())
