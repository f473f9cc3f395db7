"""The numbers of flat art: how shapes that are strokes are found."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class StrokeConstants:
    """How shapes that are strokes are found, and how their centre lines are drawn."""

    # Widths (strokes/inner_disks.py)

    points_min: int = 8
    """Fewest such points of a part that is looked at."""

    sample_gap: float = 0.5
    """Distance in pixels of the points along an outline at which disks are fitted into the shape."""

    disk_rounds: int = 24
    """Most rounds in which a disk shrinks; the usual ones need five."""

    disk_error: float = 0.02
    """Share of its radius by which another point of the outline may lie inside of a disk that has shrunk enough."""

    width_error: float = 0.06
    """Share of the width by which the disk at a point of a stroke may differ: joints and bends widen it a little."""

    center_error: float = 0.015
    """As the error of the width, of the disks whose centres are taken for those of the stroke. Where two lines meet,
    the disks grow slowly, and their centres move off the lines."""

    center_error_min: float = 0.15
    """Least such difference in pixels."""

    width_share_min: float = 0.6
    """Least share of an outline at which the disks have the width of the stroke. Those of lucide and of openmoji have
    0.75 and more, blobs and letters with a contrast of thick and thin below 0.4."""

    width_min: float = 1.5
    """Narrowest stroke in pixels. Thinner ones show no two sides."""

    length_min: float = 3.0
    """Least length of the centre lines of a component, in widths. Shorter ones are dots, bars or blobs."""

    round_length_min: float = 1.0
    """The same for lines with round caps, whose ends are no ends of bars."""

    # Skeletons (strokes/skeleton.py)

    ridge: float = 1.25
    """By how many pixels the disks at the pixels of a ridge may be smaller than half the width. With one pixel, slanted
    lines fall to pieces; wider ridges get side branches."""

    spur: float = 0.8
    """Branches that end nearer to their junction, in widths, are no lines: corners and thick junctions make them."""

    # Centre lines (strokes/center_lines.py)

    reach: float = 1.0
    """Length in widths of the part of a line that tells its direction at a junction."""

    through_degrees: float = 35.0
    """Two lines go on as one through a junction if the turn is at most so much."""

    corner_gap: float = 0.25
    """A gap in a centre line of more than so many widths may have a corner."""

    corner_reach: float = 0.6
    """Length in widths of the parts of a line beside a corner that tell its directions."""

    corner_far: float = 2.0
    """Farthest place of a corner from the last centres beside it, in widths: that of an angle of 30 degrees."""

    miter_min: float = 1.15
    """Length of a miter in widths from which on a corner tells it from a round join: that of a turn of 60 degrees."""

    miter_max: float = 4.0
    """Longest miter that is looked for. Renderers cut off longer ones, unless a file says otherwise."""

    cap_probe: float = 0.8
    """Where a cap is looked at: so many half widths to both sides of the line, and a fifth of one before its end. There
    is a square corner, and no round cap."""

    # Pieces (strokes/line_fitting.py)

    step: float = 1.0
    """Distance of the points of a centre line in pixels."""

    nodes_max: int = 48
    """Most places of a line at which a piece may end, besides corners."""

    node_gap: float = 3.0
    """Least distance of these places in pixels."""

    corner_degrees: float = 25.0
    """A centre line has a corner where its direction changes by more within a short part."""

    crossing_min: float = 0.2
    """Least sine of the angle between two lines whose crossing is taken for their corner."""

    corner_span: float = 0.45
    """Half of the length of that part in widths. Bends of a stroke with a corner look round over half a width."""

    tolerance: float = 0.35
    """Largest distance in pixels between a centre line and its pieces before they are fitted to the picture."""

    form_share: float = 2.0
    """Share of the detail within which a closed line has a form, before that is fitted to the picture."""

    again_share: float = 0.6
    """The same distance once the centre line is fitted to the picture, in shares of the detail."""

    line_cost: float = 2.0
    """Cost of a line, as the numbers that a file needs for it."""

    cubic_cost: float = 6.0
    """Cost of a cubic, as the numbers that a file needs for it."""

    excess_cost: float = 50.0
    """Cost of a pixel by which a piece is farther from the line than the tolerance."""

    kink_cost: float = 3.0
    """Cost of a joint that is not smooth, away from corners."""

    kink_degrees: float = 4.0
    """Largest turn of a smooth joint between a line and its neighbour."""

    # Acceptance (strokes/recognition.py)

    first_iterations: int = 20
    """Iterations of the fit of strokes as they are found, after which their lines are drawn by fewer pieces."""

    iterations: int = 30
    """Iterations of the fit of these, before the drawing is judged."""

    detail_share: float = 1.2
    """Share of the detail by which the outlines of a stroke may move. A corner of a centre line that is a little round
    becomes sharp with 1.2, not with 1."""

    hopeless: float = 2.2
    """After the first fit, strokes whose outlines move by more than so many times the detail are given up."""

    cost_share_max: float = 0.95
    """Largest share of the numbers that a shape had before, with which it becomes a stroke."""


STROKES = StrokeConstants()
