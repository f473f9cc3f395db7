"""Say what a drawing could not keep of its picture. The run has found it out."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from warpvec.checks import counted
from warpvec.drawing.drawing import Drawing

TEXTURE_PSNR = 30.0
"""Closeness in dB below which a drawing lacks texture or detail that one sees beside the picture."""

LEGIBLE_HEIGHT = 7
"""Height of letters in pixels, with their soft edges, below which flat art counts a word as small. The reasons stand at
`LETTERING.legible_height` in the room of flat art, which imports this one."""

COLORED_MIN = 48.0 / 255.0
"""Difference of a pixel's channels from which it is coloured: ink and paper in photos of scans have up to 40 levels."""


def not_kept(drawing: Drawing) -> dict[str, str]:
    """Return what the ``drawing`` could not keep: a short name that stays, and words for people.

    Of a refined drawing only the picture's file counts: it has no less than the drawing that came in.
    """
    unread = drawing.encoding.picture.unread
    read = {"parts of the file": unread} if unread else {}
    if drawing.start_psnr is not None:
        return read
    said = {**read, **{name: say(drawing) for name, say in _KINDS.items()}}
    return {name: words for name, words in said.items() if words}


def _text(drawing: Drawing) -> str | None:
    count = drawing.roughly.get("small word", 0)
    return f"text of letters below {LEGIBLE_HEIGHT} px, not legible in {counted(count, 'place')}" if count else None


def _areas(drawing: Drawing) -> str | None:
    count = drawing.roughly.get("area", 0)
    return f"{counted(count, 'small area')} beyond the largest number of paths (more by --curves)" if count else None


def _colors(drawing: Drawing) -> str | None:
    settings = drawing.encoding.settings
    if settings.mode in ("mono", "lines"):
        return "colours (drawn in black and white)" if _has_lost_colors(drawing) else None
    if settings.palette is not None:
        return "colours outside of the palette"
    return f"colours beyond {settings.colors} (drawn in the nearest of these)" if settings.colors else None


def _has_lost_colors(drawing: Drawing) -> bool:
    """Return whether the picture of a drawing is coloured, and the drawing is not."""
    pixels, fills = drawing.encoding.picture.reduced[..., :3], drawing.scene.color.numpy(force=True)
    return bool(np.ptp(pixels, -1).max() > COLORED_MIN >= np.ptp(fills, -1).max(initial=0.0))


def _shades(drawing: Drawing) -> str | None:
    count = drawing.roughly.get("gradient", 0)
    if count:
        return f"{counted(count, 'gradient')} (drawn in one colour each)"
    if drawing.encoding.settings.mode != "photo" or drawing.scene.gradients is not None:
        return None
    soft_count = drawing.scene.soft_count
    but = f", but for {counted(soft_count, 'soft path')}" if soft_count else ""
    return f"smooth shades, if there are any (drawn in steps of one colour each{but})"


def _texture(drawing: Drawing) -> str | None:
    settings = drawing.encoding.settings
    if settings.mode not in ("photo", "flat") or settings.paper != "auto" or _colors(drawing):
        return None
    is_photo = settings.mode == "photo"
    was_jpeg = drawing.condition is not None and drawing.condition.jpeg is not None
    if drawing.psnr_as_fitted >= TEXTURE_PSNR or (was_jpeg and not is_photo):  # a JPEG has ringing that is not meant
        return None
    return "fine texture (drawn as smooth areas)" if is_photo else "some fine detail (drawn as plain areas)"


def _noise(drawing: Drawing) -> str | None:
    condition = drawing.condition
    is_removed = condition is not None and any(condition.noise) and drawing.encoding.picture.is_restored
    return "noise" if is_removed else None


def _light(drawing: Drawing) -> str | None:
    condition = drawing.condition
    is_evened = condition is not None and condition.light is not None and drawing.encoding.picture.is_restored
    return "light and shadow on the paper" if is_evened else None


def _specks(drawing: Drawing) -> str | None:
    count = drawing.left_out.get("speck", 0) + drawing.left_out.get("sliver", 0)
    return f"{counted(count, 'speck')} too small to be meant" if count else None


def _thin_lines(drawing: Drawing) -> str | None:
    count = drawing.left_out.get("faint line", 0)
    return f"lines thinner than a pixel, in {counted(count, 'place')}" if count else None


def _translucency(drawing: Drawing) -> str | None:
    if drawing.left_out.get("translucent fill", 0):
        return "translucent fills (blended with what lies below)"
    settings, is_transparent = drawing.encoding.settings, drawing.encoding.picture.is_transparent
    return "translucent places" if is_transparent and settings.opacity == "opaque" else None


def _softness(drawing: Drawing) -> str | None:
    count = drawing.left_out.get("blur", 0)
    return f"the blur of {counted(count, 'soft path')} (cut along the outlines)" if count else None


def _size(drawing: Drawing) -> str | None:
    rows, columns = drawing.encoding.picture.reduced_size
    is_reduced = drawing.encoding.picture.enlargement[0] > 1.0 and not drawing.encoding.picture.is_restored
    return (
        f"detail finer than in a picture of {columns} x {rows} px (a larger fit size keeps more)"
        if is_reduced
        else None
    )


def _grid(drawing: Drawing) -> str | None:
    encoding = drawing.encoding
    wanted, pixels = encoding.settings.grid, max(encoding.picture.reduced_size)
    if wanted in ("auto", "off", str(pixels)) or encoding.grid:
        return None
    return f"the grid of {wanted} units (the file is in pixels)"


_KINDS: dict[str, Callable[[Drawing], str | None]] = {
    "text": _text, "areas": _areas, "colors": _colors, "shades": _shades, "texture": _texture, "noise": _noise,
    "light": _light, "specks": _specks, "thin_lines": _thin_lines, "translucency": _translucency,
    "softness": _softness, "size": _size, "grid": _grid,
}  # fmt: skip
"""Name of what may be lost -> function that says so in words. People are told in this order."""
