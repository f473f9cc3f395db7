"""Levels of what shades: how far they are apart, and the opacities of paths that lie on each other."""

from __future__ import annotations

from collections.abc import Sequence

from warpvec.svg.quantize import OPACITY_DECIMALS

STEP = 1.0 / 25.0
"""Largest step of a colour or an opacity from one path to the next: a shade over the whole picture then is within 10 of
255 levels, 3 on average, which is 39 dB."""

CLOSE = 0.55
"""Distance of an edge from where it belongs, as a share of that to the next one: more shows beside the steps."""


def opacities(wanted: Sequence[float]) -> list[float]:
    """Return the opacity of each of several paths on each other, so that all up to it have that ``wanted``.

    What one loses by rounding, the next makes up for.
    """
    found, shown = [], 0.0
    for target in wanted:
        opacity = round(max(0.0, (target - shown) / (1.0 - shown)), OPACITY_DECIMALS) if shown < 1.0 else 0.0
        shown += opacity * (1.0 - shown)
        found.append(opacity)
    return found
