"""resvg, kept where it can do no harm.

What resvg makes of a file is native code's work. A drawing of plain fills is drawn in this process. Whatever else a
file may hold (patterns, filters, masks, strokes, style sheets) is drawn in a process of its own with limits on time and
memory, since a few bytes can ask for hours, for more memory than there is, or meet an assertion that ends the process.
"""

from __future__ import annotations

import io
import subprocess
import sys
from typing import Any

import numpy as np
import resvg_py
from numpy.typing import NDArray
from PIL.PngImagePlugin import PngImageFile

from warpvec.errors import InputError

MAX_SECONDS = 60.0
"""For one drawing in a process of its own; the largest drawings of editors take some seconds."""

MAX_MEMORY = 2**32
"""Bytes of address space of that process, where the system can limit it: four canvases of the largest size."""

# The system's fonts are left out: they take time to load and differ between machines, and paths need none.
_OPTIONS = {"dpi": 96, "skip_system_fonts": True}

# The text comes in and the picture goes out as bytes; a message that is meant for the user is on stderr, marked.
_CHILD = """
import sys
try:
    import resource
    resource.setrlimit(resource.RLIMIT_AS, ({memory}, {memory}))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
except (ImportError, ValueError, OSError):
    pass
import resvg_py
text = sys.stdin.buffer.read().decode()
try:
    png = resvg_py.svg_to_bytes(text, **{options})
except BaseException as error:
    sys.exit("{mark}" + str(error))
sys.stdout.buffer.write(png)
"""
_MARK = "resvg says: "


def rasterize(
    text: str, width: int | None = None, height: int | None = None, *, transparent: bool = False, sandboxed: bool = True
) -> NDArray[np.uint8]:
    """``text`` drawn by resvg at its size, or the largest within ``width`` x ``height`` pixels of its proportions.

    sRGB over white [h, w, 3]; or, ``transparent``, with straight alpha [h, w, 4]. ``sandboxed`` draws in a process of
    its own.

    Raises:
        InputError: resvg cannot draw it, or, sandboxed, not within ``MAX_SECONDS`` and ``MAX_MEMORY``.
    """
    background = None if transparent else "#ffffff"
    options = {"width": width, "height": height, "background": background, **_OPTIONS}
    png = (_draw_in_sandbox if sandboxed else _draw_here)(text, options)
    # Not Image.open: its guard against unknown large images would warn about our own.
    with PngImageFile(io.BytesIO(png)) as image:
        return np.array(image.convert("RGBA" if transparent else "RGB"))


def _draw_here(text: str, options: dict[str, Any]) -> bytes:
    try:
        return resvg_py.svg_to_bytes(text, **options)
    except (ValueError, OverflowError) as error:
        raise _refusal(str(error)) from None
    except BaseException as error:
        # A failed assertion of resvg. The type has no importable name and is no Exception.
        if type(error).__name__ == "PanicException":
            raise _refusal(str(error)) from None
        raise


def _draw_in_sandbox(text: str, options: dict[str, Any]) -> bytes:
    script = _CHILD.format(memory=MAX_MEMORY, options=options, mark=_MARK)
    try:
        done = subprocess.run(
            # -P: no module of the current folder takes the place of an installed one.
            [sys.executable, "-P", "-c", script],
            input=text.encode(),
            capture_output=True,
            timeout=MAX_SECONDS,
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise _refusal(f"not done in {MAX_SECONDS:g} s") from None
    if done.returncode == 0:
        return done.stdout
    message = done.stderr.decode(errors="replace").rpartition(_MARK)[2]
    raise _refusal(message if _MARK.encode() in done.stderr else f"it failed with code {done.returncode}")


def _refusal(reason: str) -> InputError:
    reason = " ".join(reason.split())[:200]
    return InputError(f"SVG must be one that resvg can draw, got: {reason}; open it in a viewer to check")
