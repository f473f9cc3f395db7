"""Colours of PNG files that have no ICC profile: the chunks gAMA and cICP, as browsers take them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

_PNG = b"\x89PNG\r\n\x1a\n"

_SRGB_GAMMA, _GAMMA_STEP = 1 / 2.2, 0.05
"""The exponent of files that mean sRGB, and the least relative difference that libpng heeds (PNG_GAMMA_THRESHOLD)."""

_BT709, _P3, _SRGB_CURVE = 1, 12, 13
"""Numbers of primaries and of a transfer function (ITU-T H.273, tables 2 and 3)."""

_P3_TO_SRGB = np.array([[1.22494, -0.22494, 0], [-0.042057, 1.042057, 0], [-0.019638, -0.078636, 1.098274]])
"""Linear colours of Display P3 as those of sRGB: both have the white D65 (CSS Color 4, section 18)."""


def png_curve(info: dict[Any, Any], count: int = 256) -> NDArray[np.float64] | None:
    """Return the sRGB values in [0, 1] of the ``count`` levels of a PNG by its gAMA; None if they stay as they are.

    ``info`` is that of the PIL image; a profile and the chunks sRGB and cICP count more.
    """
    gamma = info.get("gamma")
    if not gamma or any(key in info for key in ("icc_profile", "srgb", "cicp")):
        return None
    if abs(gamma / _SRGB_GAMMA - 1) < _GAMMA_STEP:
        return None
    return srgb_encoded(np.linspace(0, 1, count) ** (1 / gamma))


def png_matrix(data: bytes) -> NDArray[np.float64] | None:
    """Return the matrix [3, 3] from the linear colours of the PNG ``data`` to those of sRGB; None if they are those.

    Raises:
        ValueError: its chunk cICP names other colours, such as those of HDR.
    """
    cicp = _cicp(data)
    if cicp is None or cicp[:2] == (_BT709, _SRGB_CURVE):
        return None
    if cicp[:2] == (_P3, _SRGB_CURVE):
        return _P3_TO_SRGB
    raise ValueError(f"colours of cICP {cicp[0]}, {cicp[1]}; save it as sRGB")


def in_srgb(color: NDArray[np.uint8], matrix: NDArray[np.float64]) -> NDArray[np.uint8]:
    """Return ``color`` [h, w, 3], of the curve of sRGB, after ``matrix`` has mixed its linear values."""
    levels = np.arange(256) / 255
    linear = np.where(levels <= 0.04045, levels / 12.92, ((levels + 0.055) / 1.055) ** 2.4).astype(np.float32)
    rows = [srgb_encoded((linear[row] @ matrix.T.astype(np.float32)).clip(0, 1)) for row in color]
    return np.stack([(row * 255).round().astype(np.uint8) for row in rows])  # by rows, for the memory


def srgb_encoded(linear: NDArray[Any]) -> NDArray[Any]:
    """Return linear light in [0, 1] as sRGB (IEC 61966-2-1)."""
    return np.where(linear <= 0.0031308, linear * 12.92, 1.055 * linear ** (1 / 2.4) - 0.055)


def _cicp(data: bytes) -> tuple[int, ...] | None:
    """Return the four numbers of the chunk cICP, which comes before the samples."""
    place = len(_PNG)
    while data.startswith(_PNG) and (kind := data[place + 4 : place + 8]) not in (b"", b"IDAT"):
        length = int.from_bytes(data[place : place + 4], "big")
        if kind == b"cICP" and length == 4:
            return tuple(data[place + 8 : place + 12])
        place += 12 + length
    return None
