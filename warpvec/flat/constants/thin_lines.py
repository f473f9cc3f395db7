"""The numbers of flat art: how straight lines thinner than two pixels are told from other ink."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class ThinLineConstants:
    """How straight thin lines are told from other ink."""

    paper_share_min: float = 0.1
    """Share of the pixels that the paper has at least: dense hatching leaves a third of it, margins more."""

    contrast_min: float = 12.0
    """Least sum over the channels, in levels, by which a pixel of a line differs from the paper: rounding gives 3."""

    gap_share: float = 0.5
    """Largest difference of the levels beside a line over its height above them: the edge of a shape has 1."""

    width_max: float = 1.7
    """Largest width in pixels: wider lines cover a row of pixels wholly, and are traced well by their outlines."""

    step_max: float = 1.4
    """Largest distance in pixels of the middles in two rows of one line: lines of 45 degrees move by 1."""

    straight_max: float = 0.25
    """Largest distance in pixels of the middle in a row from its line: that of hairlines of Skia is 0.1."""

    bend_max: float = 0.12
    """Largest height in pixels of the arc that fits a piece better than its line, for the piece to be straight."""

    length_min: int = 6
    """Fewest rows of a piece that may be a line: shorter ones are serifs and dots."""

    seed_length: float = 24.0
    """Least length in pixels of a line that others may be like: stems of letters of 30 px are longer only if wider."""

    support_min: float = 0.6
    """Share of a line's ink that a row must have to belong to it."""

    clean_difference: float = 0.25
    """Largest share by which the ink of a row that has nothing but the line differs from the line's."""

    paper_share: float = 0.12
    """Largest share of the ink of a line's pixel that is left beside it: at distances of 3 px, 1.2 px leave 0.1."""

    clean_share_min: float = 0.25
    """Share of the rows of a line, outside of crossings, that must be clean: graph paper has more than half."""

    axis_unclean_min: float = 0.25
    """Least share of the rows of a lone line that are not clean: an axis below bars has 0.6, sides of a frame 0.02."""

    reach_max: float = 1.5
    """A row with more than this many times the ink of the line is a crossing or a larger shape."""

    alike: float = 0.15
    """Largest relative difference of the widths of lines that are equal: resvg draws 1.2 px as 1.0 to 1.25 px."""

    parallel: float = 0.012
    """Largest difference in radians of the directions of parallel lines: 0.5 px on 40."""

    equals_min: int = 4
    """Fewest equal parallel lines of a staff, a hatch, a table or a grid."""

    ink_pixels_min: int = 8
    """Fewest pixels of an exact colour that may be an ink."""

    ink_cosine: float = 0.995
    """Least cosine between the ink of a line and a colour of the picture for that to be its ink: rounding of lines of
    40 levels turns it by less."""

    width_min: float = 0.25
    """Least width in pixels that is stated with a stronger ink; thinner lines are as light as they seem."""

    explained: float = 0.08
    """Largest share of the contrast of a line that its pixels may be off on plain paper: renderers differ by that."""

    dash_max: int = 64
    """Longest side in pixels of a dash."""

    dash_width_max: float = 6.0
    """Largest width in pixels of a dash: wider ones are shapes, and their outlines are good."""

    dashes_min: int = 5
    """Fewest dashes of a dashed line that no other one is like: so many equal steps are no chance."""

    speck_area: int = 3
    """Most pixels of what is left of the end of a line."""


THIN_LINES = ThinLineConstants()
