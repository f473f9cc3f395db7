"""The tuned numbers of soft light in flat art: shadows and glows."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class SoftnessConstants:
    """The numbers of `warpvec.flat.softness`; lengths in pixels, colours in 8-bit levels."""

    alike: float = 1.5
    """Largest difference of neighbours in one plateau, and of a pixel from a flat ground: rounding is half a level."""

    jump: float = 12.0
    """Least difference in levels across the edge of a shape that casts a shadow. The bands of a shadow of one level
    each differ by one or two."""

    ground_share: float = 0.04
    """Least share of the picture that the ground has on which a shadow lies. Smaller ones are parts of a drawing."""

    plate_share: float = 0.1
    """Least share of the picture that a ground inside it has."""

    shaded_unexplained: float = 0.02
    """Largest share of the energy beside a gradient along a line that a shadow may leave of such an area. The pages
    with a card leave 0.002 to 0.01."""

    graded_rounds: int = 6
    """Times that the gradient of a ground is fitted without the pixels that are off. Those in a shadow are found in the
    first two."""

    graded_samples: int = 5_000
    """Most pixels to which it is fitted: three numbers a channel need no more."""

    overlapping: float = 0.12
    """Share of a shadow up to which the picture may differ from it, as ``unexplained``, and yet show nothing else."""

    below_share: float = 0.5
    """Share of the visible pixels of a ground from which on a path that covers them is the ground, or lies below it.
    The ground covers nearly all of them. A path above it covers hardly any."""

    zone_area: int = 60
    """Fewest pixels of a soft zone: a shadow of 1 px around a shape of 20 px has as many."""

    amplitude_min: float = 6.0
    """Least difference in levels between a ground and its shadow. Fainter ones are rather a JPEG's traces."""

    sigma_min: float = 0.7
    """Least standard deviation of what is called soft; below, an edge is only less sharp than others."""

    sigma_max: float = 60.0
    """Largest one that is looked for."""

    offset_max: float = 80.0
    """Largest offset that is looked for: designers move shadows by less than four standard deviations."""

    room: float = 9.0
    """Least area of a ground over the square of the sigma of a shadow on it. The shadow of a card has 400 and more, and
    that of a button on its card 380. The sky between two houses is explained by a sigma of 27 px on 821 pixels."""

    unexplained: float = 0.12
    """Share of the energy of a soft zone that a spot may leave unexplained, and a slab that is soft light. Those that
    were drawn leave below 0.02, gradients beside a shape 0.3 and more."""

    error_right: float = 2.0
    """Largest error of a drawing with soft paths, the root of the mean square in levels, if regions leave less. The
    logo of the tests has 1.8, a page of cards with 100 paths 1.5."""

    clean_max: float = 6.0 / 255.0
    """Largest difference of two pixels of a picture without its soft spots if nothing else is on its ground."""

    blur_max: float = 1.0
    """Largest blur in pixels that a picture may seem to have because of its shadow; the sharp edges in front of a
    shadow of 5 px look blurred by 0.6 px."""

    coarse_side: int = 128
    """Side in pixels of the small copy on which a shadow is looked for first. It tells most gradients from shadows."""

    spot_blurs: tuple[float, ...] = (0.15, 0.5)
    """Standard deviations from which the fit of a soft spot begins, in smaller radii: with either alone some spots are
    missed."""

    spot_unexplained: float = 0.006
    """The same as ``unexplained`` for a soft spot, whose form is free: a ball with a gradient leaves 0.005 to 0.03, the
    shadow below a figure, which its filter cut off, 0.003."""

    spot_seen: float = 0.25
    """Least share of a soft spot that is seen. The shadow below a figure has 0.6. Spots that explain a few pixels of a
    road, and would lie below all of a map, have up to 0.14."""

    spot_part_unexplained: float = 0.002
    """The same around one of several things. Spots that were drawn leave 0.0001; gradients around a figure 0.004."""

    fitted: float = 1e-3
    """Relative change of the error below which a fit ends: the fit of the drawing does the rest."""

    fine_side: int = 512
    fine_sigma: float = 2.0
    """Least side in pixels of the copy in which a shadow is fitted after that, and its least standard deviation there.
    A picture of 1024 px takes a quarter of the time in it, and a kernel of less than 2 px is badly sampled."""

    coarse_unexplained: float = 0.3
    """The same in the small copy."""

    shadows_max: int = 6
    """Most shadows of a picture, each with a look of its own."""

    things_max: int = 12
    """Most things on a ground around each of which a shadow is looked for; more are taken for letters of a text."""

    part_seen: float = 0.1
    """Least share of the region around one of several things that shows the bare ground. Around buttons with a glow
    0.24 and more does, between the letters and fields of a form 0 to 0.09."""

    part_unexplained: float = 0.05
    """The same around one of several things: shadows there leave below 0.01."""

    well_explained: float = 0.005
    """Share that a shadow may leave unexplained before slabs beside the shapes are tried as parts of it, and up to
    which the look of one shape's shadow is that of all. Glows of two colours leave 0.09, one shadow of two shapes
    0.0003."""

    explained: float = 0.02
    """The same for a shadow of all shapes, after which neither parts nor a spot are tried, nor its ground again."""

    start_unexplained: float = 0.75
    """Largest share that the best of the rough starts of a fit may leave: shadows leave up to 0.62, and what is none
    0.7 to 0.99."""

    rounds: int = 4
    """Most fits of a shadow after the first. Before each, shapes that the shadow explains are left out of what casts
    it. With a shadow of 2 px, whose edges mix with those of the shapes, the third one changes little."""

    shapes_max: int = 24
    """Most separate shapes of which each is asked whether it casts the shadow: each takes a blur of the picture."""

    samples: int = 16_384
    """Most pixels to which a shadow is fitted, whose six numbers need no more."""

    off_levels: float = 40.0
    """Difference from the shadow in levels above which a pixel of its zone belongs to something on the ground: words
    there are off by 90 and more."""

    off_amplitude: float = 0.4
    """The same in the amplitude of the shadow. One of 2.4 px and 219 levels is off by 60 levels beside a corner whose
    coverage is not known well."""

    cast_off: float = 0.15
    """Largest share of the zone of a shadow that belongs to something on the ground. More is another shadow."""

    settled: float = 0.01
    """Relative change of the standard deviation below which no other round follows: a tenth of what is asked for."""

    # Outlines of a shadow (softness/shapes.py)

    covered_min: float = 0.002
    """Coverage from which on a pixel tells nothing of the shadow: half a level between black and white."""

    # Traced grounds and pieces (softness/traced_grounds.py, traced_casters.py)

    noises: float = 3.0
    """Standard deviations of the noise by which a pixel may differ and say nothing."""

    piece_bends: tuple[float, ...] = (8.0, 20.0)
    """Second differences in levels above which a piece ends at an edge. A shadow of 1.5 px and 85 levels has 9, and an
    edge half of its contrast; what ends at a faint edge or has a steep shadow is found with one of the two."""

    flat_share: float = 0.35
    """Least share of the pixels of a traced ground that have its colour: a tracing joins some of the shadow to it."""

    ringing: float = 0.3
    ringing_max: tuple[float, float] = (3.0, 0.5)
    """Share of the pixels of a ground whose largest difference from it in a channel is about one standard deviation of
    its noise, and the most that this may be: so many times the noise of neighbours, and so many levels more."""

    reached_share: float = 0.5
    """Share of the border of a piece without an edge from which on it is a slab of soft light. It is near 0 or 1."""

    grounds_max: int = 5
    """Most regions that are asked whether a shadow lies on them."""

    pieces_max: int = 200
    """Most regions of a picture whose pieces may cast a shadow: more are the texture of a photo."""

    piece_area: int = 9
    """Fewest pixels of a piece that is asked whether it casts a shadow."""

    starts_max: int = 6
    """Most pieces that the search begins with, each alone."""

    rough_side: int = 64
    """Side in pixels of the copy on which the choices that the search begins with are compared."""

    fits_max: int = 2
    """Most of them that are fitted."""

    slab_border: float = 0.3
    """Least share of the border of a slab of a shadow that it has with its shape, and with the ground."""

    bleed_sigma: float = 2.0
    bleed_offset: float = 0.5
    """Blur and offset in pixels up to which a shadow in a JPEG is its colours, which it stores at half size: they are
    blurred by 1 px, and by 1.6 to 1.8 where white cuts them off, and not moved."""

    better: float = 0.98
    """Error with another choice of pieces, in the one before, below which it is better."""

    same_rounds: int = 2
    """Times that the shapes are fitted above the shadow, and it below them. A third time changes no file."""

    iterations: int = 120
    """Iterations of the fit of a whole drawing with its soft paths."""


SOFTNESS = SoftnessConstants()
