"""Draw SVG text with resvg, in the sandbox where it could do harm.

resvg is native code. Drawings with plain fills only are drawn in this process. All others (with patterns, filters,
masks, strokes or style sheets) are drawn in the sandbox, because a few bytes can take hours, take more memory than
there is, or fail an assertion that ends the process.
"""

from __future__ import annotations

import io
from typing import Any

import numpy as np
import resvg_py
from numpy.typing import NDArray
from PIL.PngImagePlugin import PngImageFile

from warpvec.errors import InputError
from warpvec.sandbox.run import SandboxError, run_in_sandbox
from warpvec.svg.resvg_work import LANGUAGES

_BAND_PIXELS = 4_000_000
"""Pixels of a drawing that are converted at a time."""

_KEPT_MAX = 2**20
"""Longest text in characters, and most bytes of its drawing, that are kept for the next call: a run measures its file
several times, and a child process takes a tenth of an icon's fit."""

_last_drawing: dict[tuple[str, tuple[tuple[str, Any], ...]], bytes] = {}

# The fonts of the system are not loaded: that takes time, they differ between machines, and paths need none.
_OPTIONS = {"dpi": 96, "skip_system_fonts": True}


def rasterize(
    text: str, width: int | None = None, height: int | None = None, *, transparent: bool = False, sandboxed: bool = True
) -> NDArray[np.uint8]:
    """Draw ``text`` at its own size, or at the largest size of its proportions within ``width`` x ``height`` pixels.

    The result is sRGB over white [h, w, 3], or with straight alpha [h, w, 4] if ``transparent``. ``sandboxed`` draws in
    the sandbox.

    Raises:
        InputError: resvg cannot draw it, or not within the limits of the sandbox.
    """
    background = None if transparent else "#ffffff"
    options = {"width": width, "height": height, "background": background, **_OPTIONS}
    png = (_draw_in_sandbox if sandboxed else _draw_here)(text, options)
    # Not Image.open, which would warn about large images.
    with PngImageFile(io.BytesIO(png)) as image:
        return _pixels(image, "RGBA" if transparent else "RGB")


def _pixels(image: PngImageFile, mode: str) -> NDArray[np.uint8]:
    """Return the pixels [h, w, c] of ``image`` in ``mode``. They are copied in bands: Pillow makes several copies."""
    image.load()
    pixels = np.empty((image.height, image.width, len(mode)), np.uint8)
    row_count = max(1, _BAND_PIXELS // image.width)
    for top in range(0, image.height, row_count):
        bottom = min(top + row_count, image.height)
        pixels[top:bottom] = np.asarray(image.crop((0, top, image.width, bottom)).convert(mode))
    return pixels


def _draw_here(text: str, options: dict[str, Any]) -> bytes:
    try:
        return resvg_py.svg_to_bytes(text, languages=LANGUAGES, **options)
    except BaseException as error:
        # A failed assertion of resvg has a type that cannot be imported and is not an Exception.
        if isinstance(error, ValueError | OverflowError) or type(error).__name__ == "PanicException":
            raise _refusal(str(error)) from None
        raise


def _draw_in_sandbox(text: str, options: dict[str, Any]) -> bytes:
    key = (text, tuple(options.items()))
    drawn = _last_drawing.get(key)
    if drawn is not None:
        return drawn
    try:
        png = run_in_sandbox("warpvec.svg.resvg_work", text.encode(), **options)
    except SandboxError as error:
        raise _refusal(str(error)) from None
    _last_drawing.clear()
    if max(len(text), len(png)) <= _KEPT_MAX:
        _last_drawing[key] = png
    return png


def _refusal(reason: str) -> InputError:
    reason = " ".join(reason.split())[:200]
    return InputError("SVG", "must be one that resvg can draw", f"an error ({reason})", "open it in a viewer to check")
