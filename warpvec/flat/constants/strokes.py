"""The numbers of flat art: how shapes that are strokes are found."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class StrokeConstants:
    """How shapes that are strokes are found, and how their centre lines are drawn."""

    # Widths (strokes/inner_disks.py)

    segments_max: int = 1500
    """Most segments of a path that is looked at. Shapes of icons have up to some hundred; the centre lines of a spiral
    with thousands take minutes."""

    points_min: int = 8
    """Fewest such points of a part that is looked at."""

    sample_gap: float = 0.5
    """Distance in pixels of the points along an outline at which disks are fitted into the shape."""

    disk_rounds: int = 24
    """Most rounds in which a disk shrinks; the usual ones need five."""

    disk_error: float = 0.02
    """Share of its radius by which another point of the outline may lie inside of a disk that has shrunk enough."""

    disk_error_max: float = 0.5
    """Most of it in pixels: disks inside wide areas would pass over the ends of lines."""

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

    glance_gap: int = 8
    """One point in so many is looked at first. Most shapes of flat art are no strokes, and a few points show it."""

    glance_points_min: int = 32
    """Least number of such points. Shapes with fewer are looked at as a whole at once."""

    glance_share_min: float = 0.4
    """Least share of the outline, by these points, at which the disks have one width. Blobs have less. Strokes have
    0.75 and more, so that they pass although a few points measure the share roughly."""

    width_min: float = 1.5
    """Narrowest stroke in pixels. Thinner ones show no two sides."""

    length_min: float = 3.0
    """Least length of the centre lines of a component, in widths. Shorter ones are dots, bars or blobs."""

    round_length_min: float = 1.0
    """The same for lines with round caps, whose ends are no ends of bars."""

    outline_share: float = 1 / 64
    """Width of bars, in longer sides of the picture, from which on they are outlines where no round pen shows: a 64th.
    Icons that are drawn by outlines have bars of a 24th and more; lines of charts and plans are a hundredth at most."""

    # Skeletons (strokes/skeleton.py)

    ridge: float = 1.25
    """By how many pixels the disks at the pixels of a ridge may be smaller than half the width. With one pixel, slanted
    lines fall to pieces; wider ridges get side branches."""

    spur: float = 0.8
    """Branches that end nearer to their junction, in widths, are no lines unless they show a cap: corners and thick
    junctions make them."""

    cap_degrees: float = 175.0
    """Least part of a circle about the end of such a branch that is outline, in degrees. A round cap has 180 and some
    10 at both sides, a corner as much as the line turns."""

    cap_error: float = 0.02
    cap_error_min: float = 0.15
    """Share of the radius by which that outline may be off the circle, and least such difference in pixels: outlines
    are fitted to a tenth."""

    # Centre lines (strokes/center_lines.py)

    reach: float = 1.0
    """Length in widths of the part of a line that tells its direction at a junction."""

    overhang: float = 0.1
    """A line goes on through a junction if the shape reaches by more than so many widths beyond the other lines."""

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

    # Lines (strokes/line_fitting.py)

    step: float = 1.0
    """Distance of the points of a centre line in pixels."""

    nodes_max: int = 48
    """Most nodes of the cubics by which a line is drawn first, besides corners."""

    node_gap: float = 3.0
    """Least distance of these nodes in pixels."""

    corner_degrees: float = 25.0
    """A centre line has a corner where its direction changes by more within a short part."""

    crossing_min: float = 0.2
    """Least sine of the angle between two lines whose crossing is taken for their corner."""

    corner_span: float = 0.45
    """Half of the length of that part in widths. Bends of a stroke with a corner look round over half a width."""

    spread: float = 0.23
    spread_share: float = 0.012
    """Deviation of the places of a centre line in pixels before it is fitted to the picture, and the same in widths. Of
    28 icons of lucide at 512 px, three more lose lines with half of it, and two with one and a half times as much."""

    again_shares: tuple[float, ...] = (1.2, 1.2, 0.4)
    """Deviation of places by which lines are said again once they are fitted to the picture, in shares of the detail:
    first twice that of outlines, as few rows show most plainly where corners are round. The picture says whether a
    stroke moves too far; then it is drawn once more with the next share, and with round corners, and at last with twice
    the rows. After a stroke is accepted, and fitted again, the first share says whether it can be simpler still."""

    form_share: float = 1.7
    """Largest distance of a form from such a line, in these deviations: nine places of ten are nearer."""

    meeting_reach: float = 0.75
    """What is within so many widths of another line may lie below it, and tells nothing of the form of a line."""

    round_reach: float = 0.15
    """Where a corner may be round, the fit begins with a cubic of so many widths to both sides of it."""

    round_near: float = 0.75
    """What is within so many widths of a corner is blamed on it."""

    round_error: float = 0.25
    """Corners with at least this share of the error of the worst one become round."""

    round_share: float = 0.3
    """Largest share of a curve that such a cubic takes."""

    # Acceptance (strokes/recognition.py)

    iterations: int = 30
    """Most iterations of a fit of strokes."""

    gain_min: float = 0.1
    """Such a fit ends once five steps gain a smaller share of the loss: that is enough to judge a stroke. Those that
    stay are fitted once more."""

    last_gain_min: float = 0.04
    """The same for this last fit."""

    detail_share: float = 1.2
    """Share of the detail by which the outlines of a stroke may move. A corner of a centre line that is a little round
    becomes sharp with 1.2, not with 1."""

    detail_peak: float = 3.0
    """The same for each segment of an outline alone: where it moves by more, ends of lines stick out by a pixel.
    Strokes of lucide-static with 0.37 and 0.5 px were off by 1 and 2.5 px somewhere, those with 0.3 px by half one."""

    close_share: float = 0.8
    """Share of the detail by which outlines may move without a difference. Strokes that move farther are tried with
    more nodes, and kept if that does not help: the stroke is the designer's word."""

    close_peak: float = 2.0
    """The same for each segment of an outline alone. The end of a line in a wrong direction makes a notch that everyone
    sees, and that the mean of a long outline hides."""

    worth_min: float = 1.0
    """Worth from which a segment tells how far it has moved: that of a pixel of full contrast."""

    width_shared: float = 0.1
    """Widths that differ by no more pixels are the same; fitted ones are within 0.05 of the designer's."""

    hopeless: float = 8.0
    """After the first fit, strokes whose outlines move by more than so many times the detail are given up, to save
    time. Icons of lucide with round corners begin with four to six times."""

    worst_share: float = 0.5
    """Of such strokes, those go first whose outlines move by at least this share of the farthest move. The move of the
    others is measured again without them: a fill that is no stroke covers and uncovers what lies around."""

    cost_share_max: float = 0.95
    """Largest share of the numbers that a shape had before, with which it becomes a stroke."""


STROKES = StrokeConstants()
