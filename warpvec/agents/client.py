"""End the server when its client is gone, also during a fit: the package "mcp" waits for its end."""

from __future__ import annotations

import os
import select
import signal
import sys
import threading


def end_without_reader() -> None:
    """End this process by SIGTERM, which leaves no temporary file, once nobody can read what it writes to stdout.

    Where stdout is a file, or the system cannot tell, nothing happens.
    """
    if hasattr(select, "poll"):  # Windows has none
        pipe = os.dup(sys.stdout.fileno())  # the package lends the number of stdout to stderr
        threading.Thread(target=_watch, args=(pipe,), daemon=True).start()


def _watch(pipe: int) -> None:
    poll = select.poll()
    poll.register(pipe, 0)  # errors and hang-ups alone
    poll.poll()
    os.kill(os.getpid(), signal.SIGTERM)
