"""Standard streams that are closed, missing or full. Only a command that must use such a stream fails."""

from __future__ import annotations

import io
import os
import sys
from contextlib import suppress

from warpvec.errors import InputError
from warpvec.inputs import read_stream


def prepare_streams() -> None:
    """Open stdin, stdout and stderr where they are missing, and keep a failing stderr from ending the command.

    A file that is opened while a standard stream is closed gets the number of this stream, and native code would print
    into the file. In Python a stream that was missing stays None.
    """
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.set_inheritable(os.open(os.devnull, os.O_RDWR), True)  # the system gives out the lowest free number
    if isinstance(sys.stderr, io.TextIOWrapper) and sys.stderr is sys.__stderr__:
        sys.stderr = _Forgiving(
            sys.stderr.buffer, encoding=sys.stderr.encoding, errors=sys.stderr.errors, line_buffering=True
        )


def settle_stdout() -> None:
    """Write what stdout still holds. If this fails, drop the rest: Python would fail again when it ends."""
    if sys.stdout is None:
        return
    try:
        sys.stdout.flush()
    except (OSError, ValueError):
        with suppress(OSError, ValueError):
            sink = os.open(os.devnull, os.O_WRONLY)
            os.dup2(sink, sys.stdout.fileno())
            os.close(sink)


def check_stdout(name: str) -> None:
    """Raise InputError if the argument ``name`` asks for stdout and there is none."""
    if sys.stdout is None:
        raise InputError(name, "must be a file when stdout is closed", "- for stdout", "name a file")


def read_stdin(limit: int, name: str) -> bytes:
    """Return the bytes of stdin, for the argument ``name``.

    Raises:
        InputError: it is closed, cannot be read, or has more than ``limit`` bytes.
    """
    if sys.stdin is None:
        raise InputError(name, "must be a file when stdin is closed", "- for stdin", "name a file")
    try:
        return read_stream(sys.stdin.buffer, limit, name, "stdin")
    except OSError as error:
        reason = error.strerror or "not open for reading"
        raise InputError(name, "must be a file when stdin cannot be read", f"- ({reason})", "name a file") from error


def write_stdout(data: bytes) -> None:
    """Write ``data`` to stdout at once, so that an error comes here.

    Raises:
        OSError: stdout is full or was closed.
    """
    sys.stdout.buffer.write(data)
    sys.stdout.buffer.flush()


class _Forgiving(io.TextIOWrapper):
    """A stderr that drops messages it cannot write: a lost message is no reason to lose a fit."""

    def write(self, text: str, /) -> int:
        try:
            return super().write(text)
        except OSError:
            return len(text)

    def flush(self) -> None:
        with suppress(OSError):
            super().flush()
