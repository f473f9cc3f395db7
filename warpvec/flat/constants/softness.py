"""The tuned numbers of soft light in flat art: shadows and glows."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class SoftnessConstants:
    """The numbers of `warpvec.flat.softness`; lengths in pixels, colours in 8-bit levels."""

    alike: float = 1.5
    """Largest difference of neighbours in one plateau, and of a pixel from a flat ground: rounding is half a level."""

    plateau_area: int = 9
    """Fewest pixels of a plateau that may cast a shadow: three by three, which a blurred edge seldom has."""

    speck_area: int = 20
    """Pixels, with those of the edge, below which a shape or a hole in what casts a shadow is none: a plateau with its
    edge has 25."""

    hole_shade: float = 0.5
    """Least share of the pixels of a hole in what casts a shadow that shows the shadow: those of an "e" of 10 px on a
    card, of which some have its colour by chance, have 0.1."""

    jump: float = 12.0
    """Least difference in levels across the edge of a shape that casts a shadow. The bands of a shadow of one level
    each differ by one or two."""

    sharpness: float = 1.6
    """An edge is sharp if the first two pixels across it change the colour so many times as much as the next two. At a
    blur of 1 px, which is the softest sharp edge, the ratio from a plateau outwards is 0.7."""

    ground_share: float = 0.04
    """Least share of the picture that the ground has on which a shadow lies. Smaller ones are parts of a drawing."""

    plate_share: float = 0.1
    """The same as ``ground_share`` for a ground with a gradient, and for a shape inside the picture."""

    card_share: float = 0.2
    """The same for an opaque shape of a transparent picture, such as the square of an app's icon."""

    cards_max: int = 3
    """Most shapes of one colour inside the picture, the largest ones, on which a shadow is looked for."""

    card_growth: float = 1.3
    """Largest size of a card with the shadows that reach its edge, in its own. More is another area that it meets
    without an edge."""

    card_seen: float = 0.2
    """Least share of a card's plateau that has its middle colour. Less is a faint gradient, such as a round face's."""

    bend_max: float = 2.5
    """Largest second difference of neighbours in an even area. A gradient has one by rounding, and a shadow of 3 px
    and 100 levels has 4."""

    edge_bends: tuple[float, ...] = (6.0, 3.0)
    """Second differences above which there is an edge, for what the ground reaches: the edge of a ``jump`` through the
    middle of a pixel has half of it. The second is for faint edges, such as a white rim's on white where its shadow
    ends."""

    ring_from: float = 2.0
    ring_to: float = 5.0
    ring_share: float = 0.2
    """Distances in pixels of a ring around a shape of the colour of the ground, beyond its edge, and the least share of
    it that is soft. Around a sticker's rim about half is, as the other half is the figure; around a hole nothing is."""

    graded_share: float = 0.5
    """Least share of the pixels of a ground that its gradient explains; a shadow takes up to half."""

    shaded_share: float = 0.5
    """Share of an even area at the border below which its largest plateau may be only a band of a gradient that is
    shaded nearly everywhere. On a flat ground the plateau is most of the area."""

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

    own_share: float = 0.5
    """Share of a plateau that is the ground itself, from which on the plateau casts no shadow. A plateau of which a
    gradient explains such a share is a band of the gradient, and no ground. The share is near 0 or 1."""

    one_color: float = 0.99
    """Share of the pixels of an even area that have its middle colour, below which it has a gradient."""

    own_share_graded: float = 0.05
    """The same as ``own_share`` for an area with a gradient: the soft zone around a shape, with a bit of the ground,
    casts nothing."""

    grown: float = 3.0
    """Pixels between the inside of an even area and its edge."""

    zone_area: int = 60
    """Fewest pixels of a soft zone: a shadow of 1 px around a shape of 20 px has as many."""

    inner_area: int = 15
    """Fewest of them with translucent neighbours all around, in a picture with alpha. Edges have none."""

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
    """Share of the energy of a soft zone that a shadow may leave unexplained. Shadows that were drawn leave below
    0.02, gradients beside a shape 0.3 and more."""

    byte_exponent: float = 0.5
    """Error times this power of the bytes decides: half of the bytes are worth 1.5 dB. A logo's shadow of 90 bands has
    44 dB in 40 KB; as one soft path in 7 KB it needs 40.2 dB."""

    paths_right: int = 200
    error_right: float = 2.0
    """Most paths of a drawing with a soft path, and its largest error (root of the mean square, in levels), for which
    bands are not tried: they would need half of the error, or a quarter of the bytes. The logo of the tests has 1.8,
    a page of cards with 100 paths 1.5."""

    casting_max: int = 40
    """Most paths above a shadow that are asked whether they cast it: each is drawn alone."""

    lights_blur_min: float = 2.5
    """Least blur in pixels from which a blurred picture may be one of soft spots alone. One with less is rather a
    blurred drawing of sharp shapes: scans and enlarged logos have 0.5 to 2.3."""

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

    spot_rounds: int = 3
    """Most fits of a soft spot. Before each but the first, what the last one was far from is left out."""

    spot_off: float = 0.25
    """Largest share of the soft zone that is left out. Bits of a thin outline that are no plateaus have 0.02; all of it
    has 0.15."""

    fitted: float = 1e-3
    """Relative change of the error below which a fit ends: the fit of the drawing does the rest."""

    fine_side: int = 512
    fine_sigma: float = 2.0
    """Least side in pixels of the copy in which a shadow is fitted after that, and its least standard deviation there.
    A picture of 1024 px takes a quarter of the time in it, and a kernel of less than 2 px is badly sampled."""

    coarse_unexplained: float = 0.3
    """The same as ``unexplained`` in the small copy, whose masks are rough."""

    shadows_max: int = 6
    """Most shadows of a picture, each with a look of its own."""

    part_share: float = 0.01
    """Least share of the picture around one of several things. A button on its card has 0.07; the sky between houses of
    an emoji has 0.003 to 0.006, and each part costs seconds."""

    things_max: int = 12
    """Most things on a ground around each of which a shadow is looked for; more are taken for letters of a text."""

    part_seen: float = 0.1
    """Least share of the region around one of several things that shows the bare ground. Around buttons with a glow
    0.24 and more does, between the letters and fields of a form 0 to 0.09."""

    part_unexplained: float = 0.05
    """The same as ``coarse_unexplained`` around one of several things. Shadows there leave below 0.01, the edges of
    enlarged pictures 0.06 and 0.12; to fit each takes seconds."""

    plateaus_max: int = 1000
    """Most plateaus of a picture in which shadows of shapes are looked for: each takes time."""

    spot_plateaus_max: int = 3000
    """Most plateaus of a picture in which a soft spot is looked for; more are the texture of a photo. A figure with
    gradients has 1,400."""

    well_explained: float = 0.005
    """Most that a shadow may leave unexplained for a second drawing with soft paths, of the first shadows alone, after
    one with all was worse than bands. Glows of buttons leave 0.001; the two shadows of a card, as one, 0.013."""

    explained: float = 0.02
    """The same as ``unexplained`` for a shadow after which no other ground is tried, and no drawing of bands."""

    start_unexplained: float = 0.75
    """The same as ``unexplained`` for the best of the rough starts of a fit in the small copy: shadows leave up to 0.62
    there, and what is none 0.7 to 0.99."""

    rounds: int = 4
    """Most fits of a shadow after the first. Before each, shapes that the shadow explains are left out of what casts
    it. With a shadow of 2 px, whose edges mix with those of the shapes, the third one changes little."""

    shade_error: float = 3.0
    """Difference in levels from the shadow, as the other shapes cast it, up to which a plateau belongs to it. Plateaus
    between letters differ by 0.2 to 2.6, once the shadow is nearly known."""

    graded_error: float = 0.15
    """The same for an area with a gradient, in the amplitude of the shadow: what letters enclose differs by 0.12 from
    the first rough shadow, and shapes of a gradient have other colours."""

    painted_min: float = 0.9
    """Least share of the pixels of a hole that have the colour of the ground, if it is painted. Where a shadow shows in
    a hole, hardly any have."""

    shapes_max: int = 24
    """Most separate shapes of which each is asked whether it casts the shadow: each takes a blur of the picture."""

    shape_gaps: tuple[float, ...] = (0.0, 3.0, 6.0, 12.0)
    """Largest distances in pixels of shapes that count as one: the first that leaves few enough. Letters become words,
    and words lines."""

    samples: int = 16_384
    """Most pixels to which a shadow is fitted, whose six numbers need no more."""

    shape_doubt: float = 0.003
    """Weight of the belief that a shape casts the shadow, in the largest energy of the shadow of one."""

    off_levels: float = 40.0
    """Difference from the shadow in levels above which a pixel of its zone belongs to something on the ground: words
    there are off by 90 and more."""

    off_amplitude: float = 0.4
    """The same in the amplitude of the shadow. One of 2.4 px and 219 levels is off by 60 levels beside a corner whose
    coverage is not known well."""

    cast_off: float = 0.15
    """Largest share of the zone of a shadow that belongs to something on the ground. More is another shadow."""

    seen_min: float = 0.5
    """Share of its shadow that must be seen there. It is 0 or 1, but for what lies there besides."""

    settled: float = 0.01
    """Relative change of the standard deviation below which no other round follows: a tenth of what is asked for."""

    mask_detail: float = 0.5
    """Detail in pixels of the outline of what casts a shadow; its blur shows no more."""

    # Outlines of a shadow (softness/shapes.py)

    gap_inside: float = 0.05
    """Largest share of the area of a path that may lie in what casts the shadow, if the ground shows through the path
    as through a hole."""

    covered_min: float = 0.002
    """Coverage from which on a pixel tells nothing of the shadow: half a level between black and white."""

    # Copies of traced pieces (softness/traced_grounds.py, traced_casters.py, copies.py)

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

    same_worth: float = 2.0
    """Factor by which the error may be higher with the same outline: it is the designer's word. At 76 dB a free outline
    has less, and a colour that is 10 levels off. An outline that is not the same has many times the error."""

    iterations: int = 120
    """Iterations of the fit of a whole drawing with its soft paths."""


SOFTNESS = SoftnessConstants()
