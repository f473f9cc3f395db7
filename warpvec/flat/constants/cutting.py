"""The numbers of flat art: how a drawing is cut into parts that do not overlap."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class CuttingConstants:
    """How a drawing is cut into parts that do not overlap."""

    # Paths (cutting/cutout.py)

    opaque: float = 0.999
    """Least opacity of a path that hides what is below it. A file states three decimals."""

    white: float = 0.998
    """Least level of a channel of a white page: 255 of 255, but for rounding."""

    # Chords that meet in their ends (cutting/noding.py)

    units: int = 1024
    """Units of the grid in a pixel. The error, half a thousandth of a pixel, is below what files state."""

    chord_error: float = 0.005
    chord_error_late: float = 0.05
    """Largest distance in pixels between a chord and its curve, and the same once the time is over. Then curves are
    followed by a third as many chords, and a twentieth of a pixel of two curves that nearly touch may overlap."""

    vertex_near: float = 0.75
    """A chord that passes a vertex at so many units of the grid or less goes through it."""

    strip_units: int = 4096
    pairs_at_once: int = 4_000_000
    """Height of the strips in which chords are compared, 4 pixels: most chords are shorter, so that few are in many.
    And how many pairs of boxes are looked at together, in 150 MB."""

    passes_max: int = 30
    """Most rounds of breaking. Two or three suffice, since chords move by less than a unit when they are broken."""

    # Few parts (cutting/fewest_parts.py)

    joined_error: float = 0.02
    """Largest distance in pixels of a part from those that it replaces: 0.005 mm at 96 pixels an inch, a tenth of what
    a good laser cutter repeats."""

    joined_max: int = 8
    """Most parts that one replaces."""

    joined_samples: int = 16
    """Points of each part, and of all together, at which it is compared."""

    # Slivers (cutting/slivers.py)

    sliver_width: float = 0.15
    """A part whose area is less than so many pixels times half its outline is a sliver. Where two outlines follow the
    same edge of the picture, they differ by less; nothing that thin can be cut, or seen."""

    sliver_share_min: float = 0.25
    """Share of its outline that a sliver must have in common with the neighbour that it goes to, if there is one that
    has so much."""

    sliver_rounds_max: int = 8
    """Most rounds. A sliver between slivers waits for the next round."""

    # Spurs (cutting/spurs.py)

    spur_cosine: float = 0.9
    """Cosine of the angle of a corner from which it may be the tip of a spur."""

    spur_tip_edges: int = 4
    """Most edges of a tip. A blunt one has three: a side, its end, and the other side."""

    spur_length: float = 0.6
    """Shortest spur in pixels, 0.16 mm at 96 pixels an inch. Shorter ones are as small as what a cutter repeats."""

    spur_rounds_max: int = 2
    """Most rounds: where a spur was, a shorter one may be left."""

    spur_step: float = 0.1
    """Distance in pixels between the places where the width of a spur is looked at."""

    spur_search: tuple[float, ...] = (2.0, 60.0)
    """Lengths in pixels along which spurs are looked for: most corners that may be tips are wide soon. Outlines that
    nearly coincide for longer make slivers, or meet again."""

    # Necks (cutting/necks.py)

    neck_neighbours: int = 12
    """Most samples near one among which the other side of a neck is looked for: those of its own side are four."""


CUTTING = CuttingConstants()
