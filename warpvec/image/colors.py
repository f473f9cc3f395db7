"""Parse colours as users write them."""

from __future__ import annotations

import contextlib
import re

import numpy as np
from numpy.typing import NDArray
from PIL import ImageColor

from warpvec.errors import InputError


def parse_color(text: str, name: str = "background") -> NDArray[np.float32]:
    """Return the sRGB-encoded colour [3] in [0, 1] of "#rgb", "#rrggbb" or a CSS colour name.

    Raises:
        InputError: ``text`` has another form; the message calls the argument ``name``.
    """
    if isinstance(text, str) and re.fullmatch(r"#[0-9a-fA-F]{3}|#[0-9a-fA-F]{6}|[a-zA-Z]+", text):
        with contextlib.suppress(ValueError):
            return np.array(ImageColor.getrgb(text)[:3], np.float32) / np.float32(255)
    raise InputError(name, "must be #rgb, #rrggbb or a CSS colour name", repr(text), "try white or '#ffffff'")
