"""Draw the SVG on stdin with resvg and write the PNG to stdout, in a process that can do little else.

`warpvec.svg.resvg` runs this file as a script with one argument, the `Limits` as JSON. A message for the user is on
stderr, after ``MARK``. The limits that a system does not have are left out.
"""

from __future__ import annotations

import ctypes
import faulthandler
import json
import os
import signal
import sys
from contextlib import suppress
from typing import Any, TypedDict

MARK = "resvg says: "
"""What is before the message for the user on stderr."""


_PR_SET_PDEATHSIG = 1
"""Of linux/prctl.h: the signal to get when the thread ends that started this process."""


class Limits(TypedDict):
    """What to draw, and within which limits."""

    options: dict[str, Any]
    """Keyword arguments of resvg."""
    memory: int
    """Address space in bytes."""
    seconds: int
    """Time limit, of the clock and of the processor. The starting process ends the drawing before that."""
    parent: int
    """Id of the starting process, without which nobody needs the drawing."""


def main() -> None:
    """Draw stdin as the argument says."""
    limits: Limits = json.loads(sys.argv[1])
    # Even if nobody stops this process. The timer is a thread of native code, which the drawing does not hold up.
    faulthandler.dump_traceback_later(limits["seconds"], exit=True)
    _end_with_parent(limits["parent"])
    _limit_resources(RLIMIT_AS=limits["memory"], RLIMIT_CORE=0, RLIMIT_CPU=limits["seconds"])
    import resvg_py

    text = sys.stdin.buffer.read().decode()
    _forbid_files()
    try:
        png = resvg_py.svg_to_bytes(text, **limits["options"])
    except BaseException as error:
        sys.exit(MARK + str(error))
    sys.stdout.buffer.write(png)


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
            resource.setrlimit(getattr(resource, name), (value, value))


def _forbid_files() -> None:
    """Let nothing be opened from here on.

    Where a system has no such limit, names without a slash are those of the root, where users write no files.
    """
    os.chdir(os.path.abspath(os.sep))
    _limit_resources(RLIMIT_NOFILE=0, RLIMIT_FSIZE=0)


if __name__ == "__main__":
    main()
