"""The files that the page saves."""

from __future__ import annotations

from contextlib import suppress

from warpvec.app.making import MACHINE_FILES
from warpvec.errors import InputError
from warpvec.making.packages import can_make
from warpvec.writers.png import canvas_of, drawing_size
from warpvec.writers.registry import WRITERS
from warpvec.writers.writer import Target

MEDIA_TYPES = {suffix[1:]: writer.media_type for suffix, writer in WRITERS.items()}
MEDIA_TYPES |= {kind: media_type for kind, (media_type, _) in MACHINE_FILES.items()}
"""Format -> the type that the answer states."""


def usable_formats() -> list[str]:
    """Return the formats that can be written here; some need packages of an extra."""
    found = []
    for suffix, writer in WRITERS.items():
        with suppress(InputError):
            writer.check(f"drawing{suffix}", "format")
            found.append(suffix[1:])
    return [*found, *MACHINE_FILES] if can_make() else found


def encode(
    text: str, kind: str, width: int | None = None, *, name: str = "drawing", transparent: bool = False
) -> bytes:
    """Return the bytes of the file of ``kind`` with the drawing ``text``.

    Args:
        text: SVG text.
        kind: one of ``MEDIA_TYPES``.
        width: width of a PNG in pixels; None for that of the drawing.
        name: of the file, which becomes that of a component.
        transparent: whether a PNG has alpha instead of white paper.

    Raises:
        InputError: the text is no SVG that can be drawn, the kind is unknown or not usable, or the width is none.
    """
    if kind not in MEDIA_TYPES:
        raise InputError("format", f"must be one of {', '.join(MEDIA_TYPES)}", repr(kind), "reload the page")
    drawing_size(text)
    if kind in MACHINE_FILES:
        return MACHINE_FILES[kind][1](text)
    canvas = canvas_of(text, width, transparent=transparent) if kind == "png" else None
    return WRITERS[f".{kind}"].encode(text, Target(canvas, name=name))
