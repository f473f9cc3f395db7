"""The quarter of a circle as a cubic. Here, without torch, for modules that must load quickly."""

from __future__ import annotations

import math

QUARTER_HANDLE = 4.0 / 3.0 * math.tan(math.pi / 8.0)
"""Length of the handles of a quarter of a circle of radius 1."""
