"""The numbers of flat art: how paths, nodes and small irregularities are dropped."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class SimplificationConstants:
    """How paths, nodes and small irregularities are dropped."""

    # How much error nobody sees (simplification/critic.py)

    noise: float = 0.02
    """Squared error, summed over channels, that never counts near an outline: that of a few pixels rounded to 8
    bits."""

    whole_noise: float = 0.05
    """Squared error that never counts if a whole path or loop goes. With ``noise``, specks stay in a third of the
    pictures of flat art, whose files are up to 8 % longer."""

    # Paths beyond the number that is asked for (simplification/fewer_paths.py)

    removal_share: float = 0.25
    """Largest share of the surplus paths that one round removes. The rest are valued again without them."""

    removed_min: int = 4
    """Fewest paths that one round removes, if so many are to go."""

    # Paths that do not show (simplification/path_removal.py)

    removal_rounds: int = 8
    """Most times that paths are removed. What a path costs depends on the others, so each round removes only paths that
    are apart from each other."""

    # Numbers that do not show (chains/fewer_parts.py)

    price_length: float = 12.5
    """Pixels of outline over which an error may cost the nats of a cubic. Where the picture has noise, this says by how
    much an outline may move; see `Critic`."""

    choice_iterations: int = 6
    """Iterations of the fit after each choice of parts."""

    values_exact_max: int = 4_800
    """Most values of a drawing of flat art that is fitted by damped Gauss-Newton steps. Each takes a second of a
    posterised photo of 1,200 segments, which gradients alone fit in a sixth of the time, 0.2 dB worse."""

    unseen: float = 1e-5
    """Mean squared error, that of 50 dB, that the rounding of the file and the edges of viewers add to a drawing: fits
    end once they gain little of both. Files of 37 icons have 44 to 49 dB where their fits have 46 to 55, and the fits
    lose nothing by it: +0.005 dB in the mean, at worst -0.05, for a thirtieth of the time."""

    hidden_tension: float = 0.001
    """Tension of hidden outlines in fits, as a share of that between black and white. With 0.01, the hidden part of a
    disc behind a square moves too far for the disc to be seen as a circle."""

    # Samples of outlines (simplification/outline_samples.py)

    segment_samples: int = 8
    """Points of each segment. A wave in the outline has at least two nodes, so it cannot pass between the points."""

    contrast_half: float = 0.03
    """Squared contrast, of 3 between black and white, at which an outline counts half. An edge of a few levels of 255
    hardly says where it is, and one of a hundred levels says it as well as one of two hundred."""

    off_grid: tuple[float, float] = (0.0137, 0.0071)
    """Move in pixels before contrasts are measured. An edge exactly between two pixels has two derivatives, and
    rounding would choose one."""

    pure_color_error: float = 1e-3
    """Largest rounding error of a colour in [0, 1] that stands for the number of a path, in differences between two."""

    # What shows of outlines (simplification/form_candidates.py, strokes/candidates.py)

    peak: float = 3.0
    """Largest visible distance, in root mean squares that are allowed. A dent so small that it hides in the mean of a
    long span stays."""

    hidden_visibility: float = 0.02
    """Visibility below which a point of an outline is hidden."""

    # Error near a segment (simplification/local_error.py)

    error_spacing: float = 0.8
    """Distance in pixels of the points along a segment around which its pixels are."""

    error_points_max: int = 4096
    """Most points along one segment: it may reach far outside of the picture."""

    # Regular forms (simplification/regularity.py)

    regular_share: float = 0.5
    """Share of the detail that ellipses and other forms may take: an exact word is worth an error, but less than what
    nodes may cause."""

    # Circles and ellipses (simplification/circles.py)

    ellipse_distance_rms: float = 0.3
    ellipse_distance_max: float = 1.0
    """Root mean square and maximum of the visible distance in pixels between an outline and its ellipse. A circle that
    two cubics draw is so far off. The picture decides afterwards."""

    circle_difference: float = 0.3
    """Difference of both half axes in pixels below which an ellipse is tried as a circle."""

    ellipse_tilt_move: float = 0.3
    """An ellipse is tried level if that moves its outline by less, in pixels."""

    ellipse_seen_min: float = 0.6
    """Share of the full turn in which the outline must be visible."""

    ellipse_gap_max: float = 45.0
    """Largest angle in degrees between two points that are seen, between which the outline counts as seen."""

    ellipse_radius_min: float = 1.5
    """Half axis in pixels below which an outline is a dot of any form."""

    # Circles, ellipses and rectangles (simplification/form_candidates.py)

    form_size_min: float = 3.0
    """Size in pixels below which an outline is a dot or a dash of any form."""

    form_determined: float = 0.02
    """Least change of the visible outline, as a share of the largest one, by any combination of the numbers of a form.
    With less, a side that is wholly hidden would be anywhere. The corners of a bar of 12 widths have 0.04."""

    form_seen_min: float = 0.35
    """Share of the outline of a form that must be visible. A disc behind a square whose corner lies at its centre shows
    three quarters."""

    form_points_min: float = 0.2
    """Share of the points of an outline that must be visible before a form is looked for at all."""

    canvas_near: float = 0.5
    """Pixels from each side of the picture up to which an outline may be the rectangle around the picture. Outlines of
    grounds lie at the sides or beyond them; the error decides."""

    form_rows_max: int = 24
    """Most segments of an outline that may be a form: simple ones have 4 to 8, partly hidden ones some more."""

    form_split_min: float = 0.5
    """Share of the parts of a path that must be forms to become paths of their own: the dot of an "i" stays with its
    word."""

    # Fewer stops of gradients (simplification/fewer_stops.py)

    stop_rounds: int = 6
    """Most times that gradients are offered fewer stops: a gradient of eight may lose all."""

    stop_iterations: int = 12
    """Iterations of the fit of the paints that are offered."""

    stop_gap: float = 0.01
    """Distance of two stops, as a share of the gradient, below which they are one bend, or a jump."""

    stop_alike: float = 3.0 / 255
    """Root mean square by which a ramp of fewer stops may differ before it is fitted. A fit moves its other stops,
    which makes up for more than half of that."""

    stop_samples_max: int = 4_000
    """Most pixels of a path whose colours are compared."""

    stop_noise: float = 0.005
    stop_share: float = 0.01
    """Rise of the squared error in the pixels of a path that a stop less may cause: so much, and a share of the error
    that is there. It is below what rounding leaves of an area of a thousand pixels."""

    # Whole levels (simplification/whole_levels.py)

    level_iterations: int = 12
    """Iterations of the fit of gradients whose colours are whole levels."""


SIMPLIFICATION = SimplificationConstants()
