"""Read input files and streams up to a limit, so that an endless one is refused before it fills the memory."""

from __future__ import annotations

import os
from io import BytesIO
from pathlib import Path
from typing import BinaryIO

from warpvec.errors import InputError

_CHUNK_BYTES = 2**20
"""Bytes that are read at a time: large enough to be fast, small beside every limit."""


def read_file(path: str | os.PathLike[str], limit: int, name: str, kind: str = "a file") -> bytes:
    """Return the bytes of the file, pipe or device ``path``.

    Args:
        limit: the most bytes that it may have.
        name: the caller's name for the argument, for the message.
        kind: what it must be, for the message.

    Raises:
        InputError: it cannot be read, or has more than ``limit`` bytes.
    """
    label = repr(os.fspath(path))
    try:
        with Path(path).open("rb") as stream:
            if os.fstat(stream.fileno()).st_size > limit:
                raise too_long(limit, name, label)
            return read_stream(stream, limit, name, label)
    except (OSError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        reason = error.strerror if isinstance(error, OSError) else error
        raise InputError(name, f"must be {kind}", f"{label} ({reason})", "check the path") from error


def read_stream(stream: BinaryIO, limit: int, name: str, label: str) -> bytes:
    """Return the bytes of ``stream`` to its end; ``name`` and ``label`` are for the message.

    Raises:
        InputError: there are more than ``limit`` bytes.
        OSError: the stream cannot be read.
    """
    # A list of chunks would be joined to a second copy of all bytes.
    buffer = BytesIO()
    while chunk := stream.read(_CHUNK_BYTES):
        buffer.write(chunk)
        if buffer.tell() > limit:
            raise too_long(limit, name, label)
    return buffer.getvalue()


def too_long(limit: int, name: str, label: str) -> InputError:
    """Return the error for an input ``label`` of more than ``limit`` bytes; ``name`` is for the message."""
    return InputError(name, f"must have at most {limit} bytes", f"more in {label}", "give a smaller file")
