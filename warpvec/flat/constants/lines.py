"""The numbers of the mode lines: how the lines of a drawing are found."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class LineConstants:
    """How the lines of a drawing are found, fitted and ordered."""

    # Skeletons (lines/local_skeleton.py)

    cells: float = 10.0
    """Cells of the grid of a skeleton across a usual line."""

    scale_min: float = 1.0
    """Least cells per pixel: gaps between bold lines must not close."""

    scale_max: float = 3.0
    """Most cells per pixel, which bound the time and the memory."""

    # Wide areas (lines/wide_areas.py)

    wide_radius: float = 1.5
    """Radius in line widths of the smallest disk in a wide area. Lines that meet at an acute angle hold disks of 1."""

    wide_disks: float = 3.0
    """Most area of a wide area in areas of its largest disk: a line is longer. A square has 1.3."""

    outline_points: int = 8
    """Fewest points of the outline of a wide area on the grid."""

    outline_spread: float = 0.07
    """As the spread of lines, of the outlines of wide areas, which come from a grid."""

    # Branches (lines/branches.py)

    dot_share: float = 0.8
    """A part of ink is a dot if the largest disk in it is at least so large a share of its longest side."""

    dot_width: float = 2.5
    """Widest dot in widths of the usual line; a wider one is an area."""

    snap: float = 1.6
    """A place of a skeleton is moved to a centre of the line if there is one so near, in cells."""

    snap_widths: float = 0.08
    """The same in widths: thinning does not keep to the middle."""

    center_error: float = 0.03
    """Share of the width by which the disk of such a centre may differ from those along the line."""

    center_error_min: float = 0.25
    """Least such difference in pixels."""

    spur: float = 0.5
    """A branch is no line if its ink reaches beyond the disk at its only junction by at most so many radii: the corners
    of butt ends, of miters and of rough edges make such branches."""

    corner_spur: float = 4.0
    """The same length for a branch along which the disks shrink, as they do towards a corner."""

    corner_tip: float = 0.6
    """They do if the disk at the tip is at most so large a share of that half way."""

    junction_share: float = 0.7
    """Within so many radii of the disk at a junction, disks tell nothing of a line."""

    width_reach: float = 2.0
    """Length in widths to both sides of a place over which a line has one width."""

    width_percent: float = 35.0
    """Percentile of the widths there that is taken for it: disks grow beside junctions, and shrink nowhere."""

    overlap: float = 0.9
    """Two junctions are one if the branch between them is at most so many sums of the radii of their disks: lines that
    cross at 30 degrees make two with 0.87."""

    length_min: float = 0.1
    """Least length of a line in usual widths; shorter ones are crumbs of the skeleton."""

    loop_radii: float = 2.0
    """A branch that comes back to its junction is no line if it is at most so many radii long."""

    # Joints (strokes/joints.py)

    arm_reach: float = 1.0
    """Length in widths of the part of a line that tells its direction and bend at a junction."""

    arm_reach_min: float = 5.0
    """Least such length in pixels: that of thin lines must span some pixels."""

    misfit_degrees: float = 45.0
    """Two ends at a junction are one line if an arc between them turns by at most so much more than they do."""

    bend_degrees: float = 75.0
    """Most that lines are believed to bend within a junction."""

    bridge_degrees: float = 120.0
    """Most that an arc through a junction turns; beyond it there is a corner."""

    bridge_step: float = 1.0
    """Distance in pixels of its points."""

    meeting_far: float = 1.5
    """Lines do not meet farther from their junction, in widths."""

    # Widths (lines/widths.py)

    width_shared: float = 0.12
    """Widths of lines that differ by a smaller share are the same."""

    width_shared_min: float = 0.6
    """The same in pixels: noise and blur change the widths of thin lines by so much."""

    # Fit (lines/tracing.py)

    spread: float = 0.024
    """Deviation of the places of a centre line in pixels before it is fitted to the picture. With it, arcs of radius 3
    and more and waves are missed by 0.12 px at most: five deviations."""

    nodes_max: int = 160
    """Most nodes of the cubics by which a line is drawn first, besides corners: letters have corners of 15 degrees."""

    iterations: int = 30
    """Most iterations of the fit of all lines to the picture."""

    gain_min: float = 0.04
    """The fit ends once five steps gain a smaller share of the loss."""

    # Shared nodes (lines/shared_nodes.py)

    node_reach: float = 0.35
    """An end so near to another line, in widths, lies on it: it is deep in the ink of both."""

    attached_reach: float = 1.0
    """The same for an end that lay on another line before the fit. The fit does not see where such a line ends."""

    ahead_px: float = 0.5
    """Largest distance to the side in pixels at which another line is straight ahead."""

    overshoot: float = 0.08
    """A line that goes on by at most so many widths beyond another one ends there."""

    same_node: float = 0.15
    """Lines that meet within so many widths of each other have one node."""

    cut_share: float = 0.002
    """A node is not put nearer to another one than so large a share of the curve."""

    crossing_sine: float = 0.15
    """Least sine of the angle at which lines cross."""

    loop_min: float = 4.0
    """Least length in pixels of a loop of a line that crosses itself."""

    loop_widths: float = 2.0
    """Least length in widths of a loop of a line that ends on itself."""

    # Pens (lines/pens.py)

    ink_distance: float = 0.04
    """Distance from the paper in OKLab from which on a pixel has ink: twice what one sees."""

    black_max: float = 0.5
    """Largest level of a grey pen that counts as black, whose lines are told from the paper by lightness alone."""

    pens_max: int = 16
    """Most pens of a drawing; a picture of more colours is none."""

    pen_pixels: int = 12
    pen_share: float = 0.005
    """Fewest pixels in the middle of a pen's lines, and their share of all such pixels."""

    pen_distance: float = 0.08
    """Distance in OKLab within which colours are of one pen: shades that JPEG and the edges of thin lines make."""

    pen_misfit: float = 0.12
    misfit_share: float = 0.1
    """Largest difference of a channel between a pixel and paper with some ink of one pen, and the share of the ink that
    may be farther off: where pens cross."""

    even_levels: float = 0.04
    even_share: float = 0.2
    """Spread of a channel in a neighbourhood without edges, and the share of such places in the middle of lines that
    are as light as they look, and not thinner than a pixel."""

    full_share: float = 0.85
    """Least share of ink in a pixel that has the colour of its pen."""

    # Order (lines/pen_travel.py)

    travel_rounds: int = 8
    """Most rounds in which parts of the order are reversed; each looks at all pairs of lines."""

    travel_gain: float = 1e-6
    """Least length in pixels by which such a part shortens the way."""

    dot: float = 0.02
    """Length in pixels of the line that draws a dot by its round caps."""


LINES = LineConstants()
