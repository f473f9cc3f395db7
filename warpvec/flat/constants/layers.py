"""The numbers of flat art: how regions are stacked into layers, and how far layers go on beneath others."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class LayerConstants:
    """How regions are stacked into layers, and how far layers go on beneath others."""

    # Junctions of three paints (layers/junctions.py)

    neighbour_distance: float = 0.8
    """Pixels outside of an outline where its neighbour is looked up."""

    border_samples_min: int = 5
    """Samples of an outline, half a pixel each, with one neighbour; shorter parts are mixtures of other paints."""

    junction_turn_max: float = math.radians(45.0)
    """Turn of an outline at a junction from which on it does not go on there."""

    # Parts that another shape interrupts (layers/merging.py)

    paints_apart: float = 2.5 / 255
    """Largest difference of a channel of two paints that count as equal."""

    facing_cosine: float = math.cos(math.radians(25.0))
    """Cosine of the largest angle between an outline, where it goes beneath another shape, and the way to where it
    comes out again. A circle of which a sixth is hidden goes on at 30 degrees, half of it on either side."""

    straight_cosine: float = math.cos(math.radians(12.0))
    """The same where an outline goes on so straight that one is enough. Else two are needed: a band has two sides."""

    ends_apart: float = 4.0
    """Pixels between two ends of one outline that count as two."""

    way_samples: int = 48
    """Points of the way from end to end that must be hidden."""

    pairs_at_once: int = 2**18
    """Pairs of junctions that are compared at once, which take some 30 MB."""

    # Order of layers (layers/stacking.py)

    border_evidence: float = 0.8
    area_evidence: float = 0.1
    surrounding_evidence: float = 100.0
    """Evidence about the order of two regions, beside that of junctions, which is at most 1. The first: a region lies
    above its only neighbour. The second: the smaller region lies above. The third: a surrounded region lies above."""

    translucence_evidence: float = 1000.0
    """Evidence that an opaque region lies above a translucent neighbour: more than all other, as the colours prove
    it."""

    clear_evidence: float = 0.3
    """Evidence that keeps a region from moving below another one, to be one layer with others."""

    alone_min: int = 3
    """Shapes of one paint that stand alone and become one path. Of two, one may be a figure and the other its foot."""

    layer_moves_max: int = 8
    """Rounds in which each layer may move to where it agrees best with the others."""

    # Lines (layers/line_regions.py)

    line_width_share: float = 0.12
    line_width_error: float = 0.8
    """Largest difference from the median half width of a line, as a share of it or in pixels, whichever is more."""

    line_depth_min: float = 0.5
    """Least distance from the edge on the ridge, as a share of the largest: that at crossings is 0.7 of a width."""

    line_share: float = 0.85
    """Least share of the ridge of a line with that half width; the rest lies at ends and crossings."""

    line_length_min: float = 6.0
    """Least length of a line, in widths."""

    # What a layer covers beneath others (layers/covering.py)

    cover_margin: float = 2.5
    """Pixels that a layer stays away, beneath another one, from what neither of them covers: its colour would show
    along the edge of the upper one."""

    cover_taper: float = 0.7
    """Pixels of that margin per pixel from what the layer shows, so that no gap opens where the three meet."""

    cover_depth_min: float = 6.0
    cover_depth_share: float = 0.7
    """Pixels that a layer may go on beneath others: at least, and per pixel of the side of a square of its visible
    area. Much smaller layers than those above would get much longer borders than they show."""

    # Hidden borders (layers/hidden_borders.py)

    hidden_run_min: float = 2.0
    """Pixels of an outline that must be hidden in a row before it is changed."""

    blurred_end: float = 1.25
    """Pixels at either end of a part that shows where three paints mix, so that its place is uncertain."""

    tangent_reach: float = 4.0
    """Pixels of an outline that tell in which direction it goes on beneath the layer above."""

    extension: float = 2.0
    """Pixels that a part that shows goes on beneath the layer above before its border turns."""

    hidden_margin: float = 1.9
    hidden_wedge: float = 0.25
    """Pixels that the border of a layer stays away, beneath another one, from what neither covers; and pixels of that
    per pixel from its ends."""

    link_points: int = 48
    """Points of a hidden border between which straight lines are tried."""

    links_max: int = 4
    """Most lines of a hidden border; beyond, it follows the layers above in curves instead."""

    detours_max: int = 24
    """Times that another way is looked for because a line passes something on the wrong side."""

    enclosed_max: int = 6
    """Pixels of anything else that may lie between a hidden border and its simple form: those that touch its ends."""

    border_smoothing: int = 9
    """Points of a hidden border, about a pixel apart, whose mean replaces each of them, so that steps of pixels
    vanish."""

    link_samples: int = 64
    """Points of such a line that must lie beneath the layers above."""

    # Outlines of layers (layers/outlines.py)

    loop_area_min: float = 1.0
    """Area in square pixels of the smallest loop that is kept beside larger ones."""

    only_loop_area_min: float = 0.1
    """The same if a part has no larger one: the dot of an i fills hardly more than half of two pixels."""

    module_side_min: int = 2
    """Shortest side in pixels of a shape made of squares of pixels. Slopes and curves without anti-aliasing have steps
    of one pixel."""

    module_corners_min: int = 24
    """Fewest corners of such shapes of a layer. Bars and frames have fewer, and are traced like other shapes."""


LAYERS = LayerConstants()
