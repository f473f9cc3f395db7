"""Run work on hostile input in a child process, which ends within limits and can open no file or connection.

A few bytes can take hours, take more memory than there is, or end the process that reads them, in native code and in
Python alike. The child process is no container: see `warpvec.sandbox.child` for its limits.

A *work* is a module with a function ``work(data, **options)`` that returns buffers. What it imports must be imported
when the module is.
"""

from __future__ import annotations

import json
import math
import os
import signal
import subprocess
import sys
from importlib.util import find_spec
from typing import Any

from warpvec.errors import InputError
from warpvec.sandbox import child
from warpvec.sandbox.child import MARK, Task

MAX_SECONDS = 15.0
"""Time of the processor that a child process may take; the largest drawings of editors take some seconds, and so does
the largest canvas."""

PATIENCE = 8.0 if find_spec("resource") else 1.0
"""Time limit of the clock, as a multiple: a drawing of 4 s took more than 15 s beside fifteen other processes. On
Windows the processor's time has no limit, and the clock is all there is."""

MAX_MEMORY = 2**31
"""Address space of a child process in bytes, where the system can limit it: for resvg four canvases of the largest
size, which are enough for a drawing with one layer (3.6 canvases), and for two (8.5) up to 60 megapixels."""

_TIME_IS_UP = -getattr(signal, "SIGXCPU", 0) or None
"""Return code of a process that has used up its time of the processor; None where there is no such limit."""

_ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
"""Threads of libraries that reserve memory for each."""


class SandboxError(Exception):
    """The work failed, or exceeded a limit. The message says which in a few words."""


def run_in_sandbox(work: str, data: bytes | bytearray | memoryview, files: int = 0, **options: Any) -> bytes:
    """Return what the module ``work`` makes of ``data``.

    Args:
        work: name of the module.
        data: the hostile input.
        files: most files that the work may have open at a time; 0 unless a library needs a temporary one.
        options: further arguments of the work, which JSON can hold.

    Raises:
        InputError: the work raised it.
        SandboxError: the work failed, or took more than ``MAX_SECONDS`` of the processor or ``MAX_MEMORY``.
    """
    task = Task(
        work=work,
        options=options,
        memory=MAX_MEMORY,
        seconds=math.ceil(MAX_SECONDS),
        patience=math.ceil(PATIENCE * MAX_SECONDS) + 1,
        files=files,
        parent=os.getpid(),
    )
    try:
        done = subprocess.run(
            # -P: modules of the current folder must not replace installed ones.
            [sys.executable, "-P", child.__file__, json.dumps(task)],
            input=data,
            capture_output=True,
            timeout=PATIENCE * MAX_SECONDS,
            check=False,
            env={**os.environ, **_ONE_THREAD},
        )
    except subprocess.TimeoutExpired:
        raise SandboxError(f"not done in {PATIENCE * MAX_SECONDS:g} s") from None
    if done.returncode == 0:
        return done.stdout
    if done.returncode == _TIME_IS_UP:
        raise SandboxError(f"not done in {MAX_SECONDS:g} s")
    raise _error(done)


def _error(done: subprocess.CompletedProcess[bytes]) -> Exception:
    """Return the error that a child process has reported, or a word on its end."""
    _, mark, report = done.stderr.decode(errors="replace").rpartition(MARK)
    if not mark:
        return SandboxError(f"it failed with code {done.returncode}")
    facts = json.loads(report)
    if isinstance(facts, str):
        return SandboxError(" ".join(facts.split())[:200])
    return InputError(*facts)
