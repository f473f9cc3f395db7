"""Read how wide the place is that a GeoTIFF shows (OGC GeoTIFF 1.1)."""

from __future__ import annotations

from PIL import TiffImagePlugin

_PIXEL_SCALE, _GEO_KEYS = 33550, 34735
"""Tags of the size of a pixel, and of the keys."""

_LINEAR_UNIT = 3076
"""Key of the unit of projected coordinates."""

_METERS = {9001: 1.0, 9002: 0.3048, 9003: 1200 / 3937}
"""Number of a unit -> its length: the metre, the foot, and that of surveys in the United States."""


def world_width(image: TiffImagePlugin.TiffImageFile) -> float | None:
    """Return the width in metres of what an opened TIFF file shows; None if it does not say so in a unit of length."""
    scale, keys = image.tag_v2.get(_PIXEL_SCALE), image.tag_v2.get(_GEO_KEYS)
    if not isinstance(scale, tuple) or not isinstance(keys, tuple):
        return None
    # After a head of four, each key has four numbers: its own, the tag of its value (0 for none), a count, the value.
    units = [keys[k + 3] for k in range(4, len(keys) - 3, 4) if keys[k] == _LINEAR_UNIT and keys[k + 1] == 0]
    width = float(scale[0]) * image.width * _METERS.get(units[0] if units else 0, 0.0)
    return width if 0.0 < width < float("inf") else None
