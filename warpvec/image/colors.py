"""Colours as users write them."""

from __future__ import annotations

import contextlib
import re

import numpy as np
from numpy.typing import NDArray
from PIL import ImageColor

from warpvec.errors import InputError


def parse_color(text: str, name: str = "background") -> NDArray[np.float32]:
    """The sRGB-encoded colour [3] in [0, 1] that "#rgb", "#rrggbb" or a CSS colour name stands for.

    Raises:
        InputError: ``text`` is none of these.
    """
    if isinstance(text, str) and re.fullmatch(r"#[0-9a-fA-F]{3}|#[0-9a-fA-F]{6}|[a-zA-Z]+", text):
        with contextlib.suppress(ValueError):
            return np.array(ImageColor.getrgb(text)[:3], np.float32) / np.float32(255)
    raise InputError(f"{name} must be #rgb, #rrggbb or a colour name, got {text!r}; try white or '#ffffff'")
