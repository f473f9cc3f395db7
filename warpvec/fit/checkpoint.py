"""Save a fit to disk and read it back: everything that decides its next iteration.

After a crash the fit continues to the same bytes. A file is a NumPy archive with a header in JSON and the arrays that
the header refers to. Reading it executes no code from it.
"""

from __future__ import annotations

import errno
import io
import json
import math
import os
import re
import struct
import zipfile
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from warpvec import __version__
from warpvec.config.fit_config import FitConfig
from warpvec.config.presets import with_new_names
from warpvec.errors import InputError
from warpvec.files import write_atomic
from warpvec.fit.state import Saving, State, digest
from warpvec.fit.state_form import check_fields, field_set, integer, require, text

FORMAT, VERSION = "warpvec checkpoint", 4
"""The version changes with the content of the state, so that an old file is refused and not misread."""

MAX_BYTES = 2**29
"""Largest size of a file, and of its arrays when unpacked, so that no file can fill the memory. A fit of 2**16 paths
takes 60 MB."""

MAX_HEADER = 2**23
"""Largest size of the JSON, whose values take up to 30 times as much memory. The history has up to 50,000 entries of
105 bytes each; see `HISTORY_MAX`."""

_OVERHEAD = 1.001
"""Largest size of an archive divided by that of its arrays, which may be incompressible."""

MAX_DIRECTORY = 2**16
"""Largest size of the archive's directory, of about 60 bytes an array. A fit has some 30 arrays."""

_LOCATOR_SIZE = 20
"""Bytes before the end of an archive of more than 65,535 members or 4 GB that say so."""

_SHOWN = 200
"""Most characters of a file that a message shows."""

_TYPES = tuple(np.dtype(kind).str for kind in (np.float32, np.int64, np.uint8))
"""The types of arrays in a state, as NumPy writes them on this machine."""

# The description of an array as NumPy writes it; NumPy itself would evaluate it as Python.
_DESCRIPTION = re.compile(
    rb"\{'descr': '(?P<type>[^']{1,9})', 'fortran_order': (?P<transposed>True|False), "
    rb"'shape': \((?P<shape>[0-9, ]*)\), \} *\n"
)

_TENSOR = "__tensor__"

# Errors that a damaged archive, its arrays or their JSON raise: encrypted members raise RuntimeError, an unknown
# compression NotImplementedError, arrays of absurd shapes MemoryError.
_DAMAGE_ERRORS = (
    ValueError, KeyError, TypeError, AttributeError, IndexError, EOFError, RuntimeError, MemoryError, OverflowError,
    zipfile.BadZipFile, zlib.error, struct.error,
)  # fmt: skip


@dataclass(frozen=True)
class Checkpoint:
    """A fit after some iteration: settings, digest of the target, and state."""

    config: FitConfig
    target_digest: str
    state: State


def saving_to(
    path: str, every: int, config: FitConfig, target: NDArray[np.float32], on_error: Callable[[OSError], None]
) -> Saving:
    """Return the request to write a checkpoint of a fit of ``target`` to ``path`` after every ``every``-th iteration.

    ``on_error`` is called when the file cannot be written; the fit goes on, as it is worth more than its checkpoint.
    """
    target_digest = digest(torch.from_numpy(target))

    def save(state: State) -> None:
        try:
            write_checkpoint(path, Checkpoint(config, target_digest, state))
        except OSError as error:
            on_error(error)

    return Saving(every, save)


def write_checkpoint(path: str | os.PathLike[str], checkpoint: Checkpoint) -> None:
    """Write ``path``, completely or not at all.

    Raises:
        OSError: the file cannot be written, or `read_checkpoint` would refuse it as too large.
    """
    arrays: list[Tensor] = []
    header = {
        "format": FORMAT,
        "version": VERSION,
        "warpvec": __version__,
        "config": checkpoint.config.to_dict(),
        "target_digest": checkpoint.target_digest,
        "state": _to_plain(checkpoint.state, arrays),
    }
    buffer = io.BytesIO()
    named: dict[str, Any] = {f"array_{k}": value.detach().cpu().numpy() for k, value in enumerate(arrays)}
    named["header"] = np.frombuffer(json.dumps(header).encode(), np.uint8)
    size = sum(array.nbytes for array in named.values())
    if size * _OVERHEAD > MAX_BYTES or named["header"].nbytes > MAX_HEADER:
        raise OSError(errno.EFBIG, f"{size} bytes are too many for a checkpoint, give fewer paths", os.fspath(path))
    np.savez_compressed(buffer, **named)
    write_atomic(path, buffer.getvalue())


def read_checkpoint(path: str | os.PathLike[str]) -> Checkpoint:
    """Read a file that `write_checkpoint` wrote. The fit checks the state before it uses it.

    Raises:
        InputError: the file does not exist, is not a checkpoint, is damaged, or has another version.
    """
    label = os.fspath(path)
    try:
        arrays = _read_arrays(Path(path))
        header = json.loads(arrays.pop("header").tobytes())
        if header["format"] != FORMAT:
            raise ValueError("not a checkpoint")
        version = header["version"]
    except (OSError, *_DAMAGE_ERRORS) as error:
        # A damaged directory of the archive may lead to a place before the file, which is an invalid argument.
        if isinstance(error, OSError) and error.errno != errno.EINVAL:
            value = f"{label!r} ({error.strerror})"
            raise InputError("checkpoint", "must be a file", value, "check the path") from error
        remedy = "check the path, or start again without it"
        raise InputError("checkpoint", "must be a checkpoint of warpvec", repr(label), remedy) from error
    if version != VERSION:
        value = f"version {_brief(version)} in {label!r}, written by warpvec {_brief(header.get('warpvec'))}"
        remedy = "continue with that release or start again without it"
        raise InputError("checkpoint", f"must have version {VERSION}", value, remedy)
    try:
        return _to_checkpoint(header, arrays)
    except _DAMAGE_ERRORS as error:
        if isinstance(error, InputError) and error.name == "checkpoint":
            raise
        value = f"{label!r} (it is damaged: {_brief(str(error))})"
        raise InputError("checkpoint", "must hold a fit", value, "start again without it") from error


def _brief(value: object) -> str:
    """Return a text, or the repr of a number, in one line of no more than ``_SHOWN`` characters."""
    if not isinstance(value, str):
        value = repr(value) if isinstance(value, int | float) else "unknown"
    return " ".join(value.split())[:_SHOWN]


def _to_checkpoint(header: dict[str, Any], arrays: dict[str, Any]) -> Checkpoint:
    """Return what the ``header`` describes; it takes all ``arrays``.

    Raises:
        InputError: a setting is wrong or unknown, or the header is not as `write_checkpoint` makes it.
    """
    del header["version"]
    check_fields("header", header, format=text, warpvec=text, config=field_set, target_digest=text, state=field_set)
    state = _from_plain(header["state"], arrays)
    require(not arrays, "state", "leaves arrays unused")
    return Checkpoint(FitConfig(**with_new_names(header["config"])), header["target_digest"], state)


# Arrays


def _read_arrays(path: Path) -> dict[str, Any]:
    """Read all members of an archive. No more than ``MAX_BYTES`` are read or unpacked, whatever its directory says."""
    if path.exists() and not path.is_file():  # a device may be endless
        raise ValueError("not a file")
    with path.open("rb") as file:
        _check_directory(file, os.fstat(file.fileno()).st_size)
        with zipfile.ZipFile(file) as archive:
            members = archive.infolist()
            if len({member.filename for member in members}) < len(members):
                raise ValueError("two arrays of one name")
            arrays: dict[str, Any] = {}
            left = MAX_BYTES
            for member in members:
                name = member.filename.removesuffix(".npy")
                arrays[name] = _read_array(archive, member, min(left, MAX_HEADER) if name == "header" else left)
                left -= arrays[name].nbytes
    return arrays


def _check_directory(file: IO[bytes], size: int) -> None:
    """Raise ValueError unless the archive of ``size`` bytes is small enough, and has a small directory at its end.

    The directory is small if the archive has few members: `zipfile` reads all of it at once.
    """
    end = struct.Struct("<4s4H2LH")
    if not end.size <= size <= MAX_BYTES:
        raise ValueError("not an archive, or too large")
    file.seek(-min(size, end.size + _LOCATOR_SIZE), os.SEEK_END)
    tail = file.read()
    signature, *_, directory_size, _, comment_size = end.unpack(tail[-end.size :])
    has_large_form = tail[: -end.size].startswith(b"PK\6\7")
    if signature != b"PK\5\6" or comment_size or has_large_form or directory_size > MAX_DIRECTORY:
        raise ValueError("not an archive of few arrays")


def _read_array(archive: zipfile.ZipFile, member: zipfile.ZipInfo, limit: int) -> NDArray[Any]:
    """Return the array of a member, as `numpy.save` writes it, of ``limit`` bytes at most."""
    if member.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        raise ValueError("a compression that unpacks any amount at once")
    with archive.open(member) as stream:
        start = stream.read(10)
        if start[:8] != b"\x93NUMPY\x01\x00":
            raise ValueError("not an array")
        found = _DESCRIPTION.fullmatch(stream.read(int.from_bytes(start[8:], "little")))
        if found is None or found["type"].decode() not in _TYPES:
            raise ValueError("not an array of numbers")
        dtype = np.dtype(found["type"].decode())
        shape = [int(size) for size in found["shape"].split(b",") if size.strip()]
        if math.prod(shape) * dtype.itemsize > limit:
            raise ValueError(f"more than {limit} bytes")
        is_transposed = found["transposed"] == b"True"
        array = np.empty(shape[::-1] if is_transposed else shape, dtype)
        _fill(stream, array)
    return np.ascontiguousarray(array.T) if is_transposed else array


def _fill(stream: IO[bytes], array: NDArray[Any]) -> None:
    """Read exactly the bytes of ``array``; the stream checks their sum at its end."""
    data = array.reshape(-1).view(np.uint8).data
    done = 0
    while done < len(data):
        count = stream.readinto(data[done:])  # type: ignore[attr-defined]
        if not count:
            raise ValueError("an array is cut short")
        done += count
    if stream.read(1):
        raise ValueError("an array has too much data")


# The state as JSON


def _to_plain(value: object, arrays: list[Tensor]) -> Any:
    """Return ``value`` with each tensor moved to ``arrays`` and replaced by its index there."""
    if isinstance(value, Tensor):
        arrays.append(value)
        return {_TENSOR: len(arrays) - 1}
    if isinstance(value, dict):
        return {name: _to_plain(item, arrays) for name, item in value.items()}
    return value


def _from_plain(value: object, arrays: dict[str, Any]) -> Any:
    """Undo `_to_plain`, and take each array out of ``arrays``: two values that shared memory would change together."""
    if isinstance(value, dict) and _TENSOR in value:
        check_fields("array", value, **{_TENSOR: integer(0, MAX_DIRECTORY)})
        array = arrays.pop(f"array_{value[_TENSOR]}")
        # NumPy's strides of an array without values are zeros, which Warp refuses; torch makes its own.
        return torch.from_numpy(array.reshape(-1)).reshape(array.shape)
    if isinstance(value, dict):
        return {name: _from_plain(item, arrays) for name, item in value.items()}
    return value
