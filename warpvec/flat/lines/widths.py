"""Widths that lines share: a drawing has few pens."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from warpvec.flat.constants.lines import LINES
from warpvec.flat.lines.line import DrawnLine


def by_width(lines: list[DrawnLine]) -> list[list[DrawnLine]]:
    """Return ``lines`` in groups of one width each, the widest first. The width is the mean along the lines."""
    groups: list[list[DrawnLine]] = []
    for line in sorted(lines, key=lambda line: -line.width):
        widest = groups[-1][0].width if groups else 0.0
        if groups and widest - line.width <= max(LINES.width_shared * widest, LINES.width_shared_min):
            groups[-1].append(line)
        else:
            groups.append([line])
    return [_shared(group) for group in groups]


def _shared(group: list[DrawnLine]) -> list[DrawnLine]:
    order = sorted(group, key=lambda line: line.width)
    total = np.cumsum([line.length + line.width for line in order])
    # Half of the length is drawn by no wider lines.
    width = order[int(np.searchsorted(total, total[-1] / 2.0))].width
    return [replace(line, width=width) for line in group]
