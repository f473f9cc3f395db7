"""The files that the page saves."""

from __future__ import annotations

from contextlib import suppress

from warpvec.app.making import MACHINE_FILES
from warpvec.checks import check_choice
from warpvec.errors import InputError
from warpvec.making.packages import can_make
from warpvec.purposes.table import PURPOSES
from warpvec.writers.png import canvas_of, drawing_size
from warpvec.writers.registry import WRITERS
from warpvec.writers.saved import Saved, saved
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
    text: str,
    kind: str,
    width: int | None = None,
    *,
    name: str = "drawing",
    transparent: bool = False,
    purpose: str | None = None,
) -> Saved:
    """Return the file of ``kind`` with the drawing ``text``, and what it cannot show.

    Args:
        text: SVG text.
        kind: one of ``MEDIA_TYPES``.
        width: width of a PNG in pixels; None for that of the drawing.
        name: of the file, which becomes that of a component.
        transparent: whether a PNG has alpha instead of white paper.
        purpose: what the file is for; None for what such files usually are.

    Raises:
        InputError: the text is no SVG that can be drawn, the kind or purpose is unknown or not usable, or the width is
            none.
    """
    if kind not in MEDIA_TYPES:
        raise InputError("format", f"must be one of {', '.join(MEDIA_TYPES)}", repr(kind), "reload the page")
    drawing_size(text)
    if kind in MACHINE_FILES:
        return Saved(MACHINE_FILES[kind][1](text), [])
    if purpose is not None:
        check_choice("purpose", purpose, tuple(PURPOSES))
    canvas = canvas_of(text, width, transparent=transparent) if kind == "png" else None
    return saved(text, f"{name}.{kind}", Target(canvas, name=name), purpose)
