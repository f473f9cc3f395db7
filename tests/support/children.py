"""Processes that tests start, and how long tests wait for them.

A script's background job and `nohup` ignore SIGINT or SIGHUP, and processes inherit that. `take_default_signals` undoes
it for this process, so that what it starts can be interrupted. Limits of time grow with the load of the machine.
"""

from __future__ import annotations

import ctypes
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from glob import glob
from typing import Any, TypeVar

Found = TypeVar("Found")

SECONDS = 60.0
"""Longest wait on a machine with a free core. What takes longer hangs."""

_DIE_WITH_PARENT = 1  # PR_SET_PDEATHSIG of prctl(2)

_libc = ctypes.CDLL(None) if sys.platform == "linux" else None
_started: list[subprocess.Popen[Any]] = []


def take_default_signals() -> None:
    """Handle the signals that end a process as in a terminal, also if they are ignored."""
    for name in ("SIGINT", "SIGTERM", "SIGHUP"):
        number = getattr(signal, name, None)  # Windows has no SIGHUP
        if number is not None and signal.getsignal(number) == signal.SIG_IGN:
            signal.signal(number, signal.default_int_handler if name == "SIGINT" else signal.SIG_DFL)


def start(command: Sequence[object], **options: Any) -> subprocess.Popen[Any]:
    """Start a process as `subprocess.Popen` does. It ends with this process at the latest, or with `kill_all`."""
    before = options.pop("preexec_fn", None)

    def prepare() -> None:
        if _libc is not None:
            _libc.prctl(_DIE_WITH_PARENT, signal.SIGKILL)
        if before is not None:
            before()

    process = subprocess.Popen([str(word) for word in command], preexec_fn=prepare, **options)
    _started.append(process)
    return process


def kill_all() -> None:
    """Kill what `start` has started and still runs, as after a test that has failed."""
    for process in _started:
        with process:  # closes its streams, and waits for its end
            process.kill()
    _started.clear()


def limit(seconds: float = SECONDS) -> float:
    """Return a limit of time that is ``seconds`` on a machine with a free core, and longer on a busy one."""
    return seconds * max(1.0, os.getloadavg()[0] / (os.cpu_count() or 1))


def wait_for(find: Callable[[], Found], process: subprocess.Popen[Any] | None = None) -> Found:
    """Call ``find`` until it returns something true, and return that; ``process`` must run until then."""
    begin = time.monotonic()
    while not (found := find()):
        assert process is None or process.poll() is None, f"ended with {process.returncode}"
        assert time.monotonic() - begin < limit(), "waited too long"
        time.sleep(0.005)
    return found


def runs(number: int) -> bool:
    """Return whether a process runs, by its number; one of which only the exit code is left does not."""
    try:
        with open(f"/proc/{number}/stat") as file:
            return file.read().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def descendants(number: int) -> list[int]:
    """Return the children of a process, their children, and so on. Empty where there is no /proc."""
    found: list[int] = []
    for path in glob(f"/proc/{number}/task/*/children"):
        with suppress(OSError), open(path) as file:
            for child in map(int, file.read().split()):
                found += [child, *descendants(child)]
    return found


def work_of(number: int) -> float:
    """Return seconds of processor time of a running process and of its children that have ended."""
    with suppress(OSError), open(f"/proc/{number}/stat") as file:
        times = file.read().rpartition(")")[2].split()[11:15]  # utime, stime, cutime, cstime of proc(5)
        return sum(map(int, times)) / os.sysconf("SC_CLK_TCK")
    return 0.0
