"""The numbers of the mode lines: how the lines of a drawing are found."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class LineConstants:
    """How the lines of a drawing are found, fitted and ordered."""

    # Skeletons (lines/local_skeleton.py)

    cells: float = 10.0
    """Cells of the grid of a skeleton across a usual line."""

    scale_min: float = 0.5
    """Least cells per pixel: gaps between bold lines must not close."""

    scale_max: float = 3.0
    """Most cells per pixel, which bound the time and the memory."""

    # Branches (lines/branches.py)

    dot_length: float = 1.5
    """A part of ink is a dot if its largest side is at most so many of its widths."""

    dot_width: float = 2.5
    """Widest dot in widths of the usual line; a wider one is an area."""

    snap: float = 1.6
    """A place of a skeleton is moved to a centre of the line if there is one so near, in cells."""

    center_error: float = 0.03
    """Share of the width by which the disk of such a centre may differ from those along the line."""

    center_error_min: float = 0.25
    """Least such difference in pixels."""

    spur: float = 1.25
    """A branch that ends within so many radii of the disk at its only junction is no line: the corners of butt ends, of
    miters and of rough edges make such branches."""

    corner_spur: float = 4.0
    """The same length for a branch along which the disks shrink, as they do towards a corner."""

    corner_tip: float = 0.6
    """They do if the disk at the tip is at most so large a share of that half way."""

    junction_share: float = 0.7
    """Within so many radii of the disk at a junction, disks tell nothing of a line."""

    width_reach: float = 2.0
    """Length in widths to both sides of a place over which a line has one width."""

    overlap: float = 0.9
    """Two junctions are one if their distance is at most so many times the sum of the radii of their disks: lines that
    cross at 30 degrees make two with 0.87."""

    # Widths (lines/widths.py)

    width_shared: float = 0.12
    """Widths of lines that differ by a smaller share are the same."""

    width_shared_min: float = 0.6
    """The same in pixels: noise and blur change the widths of thin lines by so much."""

    # Fit (lines/tracing.py)

    tolerance: float = 0.12
    """Largest distance in pixels between a centre line and its pieces before they are fitted to the picture."""

    iterations: int = 30
    """Most iterations of the fit of all lines to the picture."""

    gain_min: float = 0.04
    """The fit ends once five steps gain a smaller share of the loss."""

    # Order (lines/pen_travel.py)

    travel_rounds: int = 8
    """Most rounds in which parts of the order are reversed; each looks at all pairs of lines."""

    travel_gain: float = 1e-6
    """Least length in pixels by which such a part shortens the way."""

    dot: float = 0.02
    """Length in pixels of the line that draws a dot by its round caps."""


LINES = LineConstants()
