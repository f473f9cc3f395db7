"""Keep a drawing that cannot be written where it should be: its folder is gone or full, or its kind cannot be made."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import click

from warpvec.errors import InputError
from warpvec.files import write_atomic


def rescued(text: str, out: str, error: OSError | InputError) -> click.ClickException | None:
    """Write the SVG ``text`` where that is possible, and return the error that says where; None if it is nowhere.

    Args:
        text: the drawing.
        out: where it could not be written.
        error: why.
    """
    if Path(out).exists() and not Path(out).is_file():
        return None  # a pipe or a device, which nobody keeps
    for folder in _folders(Path(out)):
        path = _new_path(folder, Path(out).stem)
        try:
            write_atomic(path, text.encode())
        except OSError:
            continue
        reason = f"{out!r} could not be written ({error.strerror})" if isinstance(error, OSError) else str(error)
        return click.ClickException(f"{reason}; the drawing is in {str(path)!r}")
    return None


def _folders(out: Path) -> Iterator[Path]:
    """Yield the nearest folder of ``out`` that is there, the working folder, the user's own, and one for all."""
    with suppress(OSError):  # the working folder may be gone, too
        yield next(folder for folder in Path(os.path.abspath(out)).parents if folder.is_dir())
        yield Path.cwd()
    with suppress(RuntimeError):  # the user has none
        yield Path.home()
    with suppress(OSError):
        yield Path(tempfile.gettempdir())


def _new_path(folder: Path, stem: str) -> Path:
    """Return the path of a file that is not there yet."""
    number = 1
    while (path := folder / f"{stem}-rescued{'' if number == 1 else f'-{number}'}.svg").exists():
        number += 1
    return path
