"""Save a fit to disk and read it back: everything that decides its next iteration.

After a crash the fit continues to the same bytes. A file is a NumPy archive with a header in JSON and the arrays that
the header refers to. Reading it executes no code from it.
"""

from __future__ import annotations

import io
import json
import os
import struct
import zipfile
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor

from warpvec import __version__
from warpvec.config.fit_config import FitConfig
from warpvec.config.presets import make_config
from warpvec.errors import InputError
from warpvec.files import write_atomic
from warpvec.fit.state import State

FORMAT, VERSION = "warpvec checkpoint", 2
"""The version changes with the content of the state, so that an old file is refused and not misread."""

MAX_BYTES = 2**30
"""Largest size when unpacked, so that a small file cannot fill the memory. A fit of 2**16 paths takes 80 MB."""

_TENSOR = "__tensor__"

# Errors that a damaged archive, its arrays or their JSON raise: encrypted members raise RuntimeError, an unknown
# compression NotImplementedError, arrays of absurd shapes MemoryError.
_DAMAGE_ERRORS = (
    ValueError, KeyError, TypeError, AttributeError, IndexError, EOFError, RuntimeError, MemoryError, OverflowError,
    zipfile.BadZipFile, zlib.error, struct.error,
)  # fmt: skip


@dataclass(frozen=True)
class Checkpoint:
    """A fit after some iteration: its settings, the digest of its target, and its state."""

    config: FitConfig
    target_digest: str
    state: State


def write_checkpoint(path: str | os.PathLike[str], checkpoint: Checkpoint) -> None:
    """Write ``path``, completely or not at all.

    Raises:
        OSError: the file cannot be written.
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
    np.savez_compressed(buffer, **named)
    write_atomic(path, buffer.getvalue())


def read_checkpoint(path: str | os.PathLike[str]) -> Checkpoint:
    """Read a file that `write_checkpoint` wrote.

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
    except OSError as error:
        value = f"{label!r} ({error.strerror})"
        raise InputError("checkpoint", "must be a file", value, "check the path") from error
    except _DAMAGE_ERRORS as error:
        remedy = "check the path, or start again without it"
        raise InputError("checkpoint", "must be a checkpoint of warpvec", repr(label), remedy) from error
    if version != VERSION:
        value = f"version {version!r} in {label!r}, written by warpvec {header.get('warpvec')}"
        remedy = "continue with that release or start again without it"
        raise InputError("checkpoint", f"must have version {VERSION}", value, remedy)
    try:
        config = make_config(**header["config"])
        return Checkpoint(config, header["target_digest"], _from_plain(header["state"], arrays))
    except (KeyError, TypeError, InputError) as error:
        value = f"{label!r} ({error})"
        raise InputError("checkpoint", "must hold a fit", value, "start again without it") from error


def _read_arrays(path: Path) -> dict[str, Any]:
    if path.exists() and not path.is_file():  # a device may be endless
        raise ValueError("not a file")
    data = path.read_bytes()
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        if sum(member.file_size for member in archive.infolist()) > MAX_BYTES:
            raise ValueError(f"more than {MAX_BYTES} bytes")
    with np.load(io.BytesIO(data), allow_pickle=False) as archive:
        return {name: archive[name] for name in archive.files}


def _to_plain(value: Any, arrays: list[Tensor]) -> Any:
    """Return ``value`` with each tensor moved to ``arrays`` and replaced by its index there."""
    if isinstance(value, Tensor):
        arrays.append(value)
        return {_TENSOR: len(arrays) - 1}
    if isinstance(value, dict):
        return {name: _to_plain(item, arrays) for name, item in value.items()}
    return value


def _from_plain(value: Any, arrays: dict[str, Any]) -> Any:
    """Undo `_to_plain`."""
    if isinstance(value, dict) and _TENSOR in value:
        return torch.from_numpy(arrays[f"array_{value[_TENSOR]}"])
    if isinstance(value, dict):
        return {name: _from_plain(item, arrays) for name, item in value.items()}
    return value
