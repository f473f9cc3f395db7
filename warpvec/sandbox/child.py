"""Do the work on stdin and write its result to stdout, in a process that can do little else.

`warpvec.sandbox.run` runs this file as a script with one argument, the `Task` as JSON. An error is on stderr, as JSON
after ``MARK``: the parts of an `InputError`, or a message. The limits that a system does not have are left out.
"""

from __future__ import annotations

import ctypes
import faulthandler
import importlib
import json
import os
import signal
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any, TypedDict

MARK = "warpvec.sandbox: "
"""What is before the error on stderr."""

_PR_SET_PDEATHSIG = 1
"""Of linux/prctl.h: the signal to get when the thread ends that started this process."""


class Task(TypedDict):
    """What to do, and within which limits."""

    work: str
    """Name of the module with the function ``work``."""
    options: dict[str, Any]
    """Keyword arguments of the work."""
    memory: int
    """Address space in bytes."""
    seconds: int
    """Time limit of the processor."""
    patience: int
    """Time limit of the clock in seconds. The starting process ends the work before that."""
    files: int
    """Most files that the work may have open at a time: temporary ones of a library."""
    parent: int
    """Id of the starting process, without which nobody needs the result."""


def main() -> None:
    """Do the task of the argument."""
    task: Task = json.loads(sys.argv[1])
    # Even if nobody stops this process. The timer is a thread of native code, which the work does not hold up.
    faulthandler.dump_traceback_later(task["patience"], exit=True)
    _end_with_parent(task["parent"])
    _limit_resources(RLIMIT_AS=task["memory"], RLIMIT_CORE=0, RLIMIT_CPU=task["seconds"])
    sys.path.append(str(Path(__file__).parents[2]))  # the package need not be installed
    work = importlib.import_module(task["work"]).work
    data = sys.stdin.buffer.read()
    _limit_files(task["files"], task["memory"])
    try:
        for part in work(data, **task["options"]):
            sys.stdout.buffer.write(part)
        sys.stdout.flush()
    except BaseException as error:
        sys.exit(MARK + json.dumps(_report(error)))


def _report(error: BaseException) -> str | tuple[str | None, ...]:
    if type(error).__name__ == "InputError":
        return error.__reduce__()[1]  # its arguments
    if isinstance(error, MemoryError):
        return "more memory is needed than there may be"
    return str(error) or type(error).__name__


def _end_with_parent(parent: int) -> None:
    """End this process when the ``parent`` ends, even if that is killed. Only Linux can do so."""
    if sys.platform != "linux":
        return
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:  # it ended before the call, which then has no effect
        sys.exit("the starting process has ended")


def _limit_resources(**values: int) -> None:
    try:
        import resource
    except ImportError:  # Windows
        return
    for name, value in values.items():
        with suppress(AttributeError, ValueError, OSError):  # macOS does not have all of them
            # A process that reaches the second limit is killed without a word, at the first one with a signal for it.
            resource.setrlimit(getattr(resource, name), (value, value + (name == "RLIMIT_CPU")))


def _limit_files(count: int, size: int) -> None:
    """Let at most ``count`` files of ``size`` bytes be opened from here on.

    Where a system has no such limit, names without a slash are those of the root, where users write no files.
    """
    os.chdir(os.path.abspath(os.sep))
    free = os.dup(0)  # the lowest number that is not in use
    os.close(free)
    _limit_resources(RLIMIT_NOFILE=free + count if count else 0, RLIMIT_FSIZE=size if count else 0)


if __name__ == "__main__":
    main()
