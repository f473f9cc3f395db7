"""The numbers of flat art: how outlines are found and fitted by lines and cubics."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class CurveConstants:
    """How outlines are found and fitted by lines and cubics."""

    # Contours of coverage (curves/contours.py)

    contour_level: float = 0.5
    """Coverage of a pixel whose centre the contour passes."""

    saturated: float = 0.95
    """An edge ends at the first pixel that is covered at least so much, or at most 1 less this."""

    contour_reach: int = 2
    """Pixels beyond the crossing that an edge may take on either side: at 45 degrees it covers two in all."""

    vertex_dominance: float = 0.8
    """A vertex counts if the field changes along its grid line at least by so much of its change across it. The others
    are less precise, and beside each of them is one that counts."""

    vertex_share_min: float = 0.25
    """Least share of vertices that count; a contour with fewer is a speck, of which all are kept."""

    # Places where a curve may begin (curves/outline_nodes.py)

    sample_step: float = 0.5
    """Pixels between the samples of an outline. Its own points are up to 1.4 pixels apart."""

    sample_count_min: int = 16
    """Least number of samples of a loop, however small it is."""

    corner_gap: int = 2
    """Samples beside a corner that are not looked at: marching squares round them off."""

    long_side: int = 12
    short_side: int = 5
    """Samples on one side that tell where the outline goes: a parabola through the long part, or a line through the
    short one where the outline turns again soon."""

    samples_at_once: int = 4096
    """Samples and vertices whose neighbours are looked at together: their arrays stay in the processor's cache, which
    takes a third of the time for an outline of a million samples."""

    parabola_residual_max: float = 0.08
    """Largest mean distance in pixels of a parabola from the samples that it is trusted with."""

    corner_turn_min: float = math.radians(22.0)
    """Least change of direction at a corner. A circle of radius 3 turns by 19 degrees a pixel, but its parabolas
    follow."""

    corners_apart: int = 3
    """Samples between two corners, at least."""

    sharp_turn: float = math.radians(140.0)
    sharp_gap: int = 7
    """Change of direction at a sharp tip, beside which more samples are not looked at: where a wedge is less than a
    pixel wide, its sides cannot be told apart."""

    corner_reach_max: float = 5.0
    corner_reach_share: float = 0.1
    """Pixels that a corner may lie outside of the outline, at most, and per pixel of its length. The tip of a wedge of
    10 degrees lies 3 px outside."""

    spacing_min: float = 1.5
    spacing_max: float = 4.0
    spacing_share: float = 1 / 120
    """Pixels between smooth nodes: a share of the length of the loop, within limits."""

    rough_samples_min: int = 300
    """Samples of the shortest loop whose roughness is measured."""

    smooth_reach: int = 6
    """Samples on either side that tell the direction of the outline at a smooth node."""

    # Ends of thin strokes (curves/stroke_ends.py)

    stroke_near: float = 3.5
    stroke_far: float = 7.5
    """Pixels along the outline, from the middle of the end on either side, at which the width of a stroke is
    measured."""

    stroke_width_max: float = 5.5
    """Pixels between the corners of an end, at most. Those of wider strokes see enough of their own sides."""

    stroke_growth: float = 0.25
    """The sides of a stroke are parallel: its width grows by fewer pixels from near to far. A wedge of 4 degrees grows
    by 0.28."""

    stroke_turn_min: float = math.radians(90.0)
    """Least change of direction of a tip, or of two corners together. At an end it is 180 degrees, blurred by
    pixels."""

    # Cubics closest to points (curves/cubic_fitting.py)

    fit_plan: tuple[int, float] = (8, 1.5)
    """Rounds, and the factor of the steps of the parameters between them. In a round the handles are found, and then
    the points' parameters where the cubic is closest. The two follow each other slowly: after three rounds with a
    factor of 1, a quarter circle of radius 80 is off by 0.07 px on average, else by 0.05."""

    thirds_weight: float = 1e-5
    """Weight of handles at thirds of the chord, where all points together have 1. It decides where points are too
    few."""

    # Tolerance (chains/traced.py)

    tolerance: float = 0.2
    """Largest distance in pixels between an outline and what it traces, as noise may cause it. An outline from
    anti-aliased pixels is within 0.05."""

    spread_share: float = 0.1
    """Deviation of the places of an outline in tolerances. With 0.14, 16 pictures of 512 px have 0.4 dB less and 2 %
    fewer numbers; with 0.08, 0.2 dB more and 2 % more."""

    noise_factor: float = 18.0
    noise_tolerance_max: float = 0.6
    """Tolerance per roughness of an outline, and the largest that roughness leads to. Anti-aliased edges have a
    roughness of 0.005 px, faint ones in a JPEG of quality 80 have 0.02."""


CURVES = CurveConstants()
