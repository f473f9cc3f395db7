"""The numbers of flat art: how regions are found in a picture."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class RegionConstants:
    """How regions are found in a picture."""

    # The noise of a picture, and which differences of colours do not count (regions/noise.py)

    noise_edge_step: float = 24 / 255
    """Difference in brightness of two neighbours that counts as an edge, around which JPEG leaves ringing."""

    noise_band_near: int = 3
    noise_band_far: int = 8
    """Distances in pixels from edges between which noise is measured: past the mixed pixels, within a block of JPEG."""

    noise_band_area_min: int = 64
    """Fewer pixels in this band say nothing; then the noise is measured in the whole picture."""

    quiet_share: float = 0.75
    loud_share: float = 0.9
    """Quantiles of the second difference: clean pictures are below ``quiet`` at the first; the second is their noise.
    Of the sixteen pictures of the tests, clean ones have 0 to 0.3 levels at the first, those of JPEG quality 80 have
    1.0 to 1.8, and 2 to 5 at the second, those of quality 60 up to 7."""

    quiet: float = 0.35 / 255
    """Second difference that rounding to 8 bits leaves in a gradient."""

    murmur: tuple[float, float] = (1.2 / 255, 12 / 255)
    murmur_share: float = 0.08
    murmur_side: int = 200
    """Second differences that are more than rounding and less than an edge, and the share of pixels with such from
    which a picture of at least this longer side in pixels is noisy though most of it is quiet: white clips the noise on
    one side of a dark mark. Of 96 drawings at 256 and 512 px, clean ones have up to 0.07, those of JPEG quality 80 from
    0.125 on, but for one. Smaller clean ones have details of such contrast. Noise is nearer to edges as well: pages of
    pale words have up to 0.14 in the band, and up to 0.08 in the ring between it and the mixed pixels, where JPEGs have
    0.4 and more."""

    mixed_reach: int = 1
    ring_share: float = 0.2
    ring_murmur_share: float = 0.02
    """Distance in pixels of mixed pixels from an edge; share of such second differences in the ring between them and
    the band from which edges ring, as those of WebP do, whose filter leaves the band still; and the share in the band
    that tells it from the ringing of Lanczos, which ends there. Of 60 icons of 256 and 400 px, none is taken for noisy
    as it is or reduced by means or bicubically, and 5 % are if reduced by Lanczos. Of their copies as WebP of quality
    80, 42 % are, the coloured ones. A coloured icon as WebP had 142 regions, and has 12 so."""

    dither: float = 1.05 / 255
    dither_share: float = 0.94
    """Largest difference of neighbours on a gentle ramp that a browser has dithered, and the share of such in all
    murmurs from which a picture is dithered, and not noisy: a page has 0.99, JPEG of quality 80 to 95 up to 0.59. A
    drawing with dithered steep ramps has 0.45. It stays noisy: as a clean one, it gets specks of its ramps."""

    noise_min: float = 1.2 / 255
    noise_min_small: float = 2.1 / 255
    """Less noise than this is none, the second in pictures smaller than ``murmur_side``: clean ones with ramps have up
    to 2.0 levels there. Those of JPEG quality 80 and 90 have more, and half of those of 95."""

    shaded_side: int = 100
    """Longest side in pixels of an icon, whose shading is steep."""

    rough_min: float = 4.0 / 255
    """Fourth difference of brightness at the first quantile above which an icon is noisy. Shading that bends leaves
    little: six of ten clean icons with gradients that were taken for noisy have 0.6 to 3.9 levels. Of copies as JPEG
    of quality 80 and 90, 94 % have more. Rounding alone leaves 2 levels."""

    deep: int = 8
    """Pixels from all borders of regions from which on a pixel lies deep inside: traces of a JPEG reach as far."""

    deep_share_min: float = 0.2
    """Least share of the pixels beside the canvas that lie deep inside, for these to speak for the picture."""

    structure_blur: float = 1.5
    """Deviation in pixels of the Gaussian that parts what regions leave: structure stays, grain goes."""

    structure_max: float = 1.7
    """Largest structure in levels, a root mean square, that regions of flat art with grain leave deep inside. Ovals of
    photos of the moon, cells and a rocket's sky have 1.8 to 4.2; drawings as JPEG of quality 50 up to 1.4."""

    grain_max: float = 1.0
    """Largest grain in levels that regions of flat art with structure leave deep inside. Those ovals have 1.3 to 2.7.
    Of 40 emoji with soft shading, eight have a structure of 1.7 to 5.8, and a grain of up to 0.7."""

    jpeg_rounds: int = 2
    """Times that the regions of a JPEG are found in the picture before it. The root mean square of its difference from
    the clean picture of an icon of 400 px falls from 2.6 levels to 1.7 and 1.5, of another from 4.8 to 2.4 and 2.3."""

    jpeg_noise: float = 3.0 / 255
    """Noise that is left in the picture before a JPEG of quality 50; that of others has the size of their steps. Of
    four shaded icons of quality 80, the colour error falls from 0.339 to 0.260. With twice as much, which parts of
    like colours do not stand, one of them loses a shape, and the error is 0.289."""

    noisy_end: float = 2.5 / 255
    """A flat paint of a noisy picture of which all channels are nearer to 0 is black, and to 1 white: the steps of a
    JPEG hide as much."""

    noise_max: float = 12 / 255
    """The noisiest pictures are taken for this noisy, so that the tolerances stay below the contrast of drawings."""

    step: tuple[float, float, float] = (2.5, 2.0, 0.25)
    """Difference of neighbours in one area: levels in a clean picture; levels in a noisy one, and how much more for its
    noise. Rounding to 8 bits alone makes a difference of 1."""

    paint: tuple[float, float, float] = (2.0, 3.0, 1.0)
    """The same between a pure pixel and its paint."""

    mix: tuple[float, float, float] = (4.0, 6.0, 2.0)
    """The same between a mixed pixel and the best mix of two paints, both of which are known less well than a pixel."""

    pool: tuple[float, float, float] = (2.0, 4.0, 0.5)
    """The same between colours that were one in the drawing; the mean of many pixels has little noise."""

    sharp_width: float = 2.05
    """Median width in pixels of the edges of sharp pictures at most. On the sixteen pictures of the tests it is 1.3 to
    1.5, and up to 2.0 after JPEG of quality 60; blurred by one pixel or enlarged twice it is 2.1 to 3.1."""

    sharp_reach: int = 3
    reach_max: int = 8
    """Distances in pixels that regions reach into sharp edges, and into the softest ones that are looked at."""

    edge_window: int = 9
    edge_slope_min: float = 0.04
    edge_rise_min: float = 0.15
    edge_count_min: int = 20
    """Edges whose widths are measured: their length in pixels, the least step and rise, and how many say something."""

    chroma_weight: float = 0.4
    """Weight of colour beside brightness in noisy pictures. JPEG stores colour at half the resolution, so that it
    bleeds over edges."""

    thin_chroma: float = 0.4
    """Weight of colour in thin parts of noisy pictures, as a part of that elsewhere: where a line is narrower than the
    double pixels of colour, it takes on the colour around it."""

    # Areas of pure pixels (regions/seeding.py)

    clean_seed_width: int = 2
    noisy_seed_width: int = 3
    """Sides in pixels of squares of pure pixels in clean and in noisy pictures."""

    clean_seed_area: int = 4
    noisy_seed_area: int = 12
    """Smaller areas of pure pixels are not trusted: one square of two pixels in clean pictures, more in noisy ones."""

    translucent_area_min: int = 24
    """Smaller translucent areas of pure pixels are not trusted: tips of shapes cover pixels by half for a while."""

    steep_ramp_error: float = 2.5 / 255
    """Root mean square up to which a paint explains an area with steep parts. If none does, the steep parts are
    edges."""

    # Growth of areas over pixels of their paint (regions/region_growing.py)

    steep_ramp_width: int = 3
    """Side in pixels of squares of pure pixels on steep ramps."""

    steep_ramp_step: float = 16 / 255
    """Largest difference of neighbours on a steep ramp; 16 pixels of it cover all brightness."""

    steep_ramp_bend: float = 2.1 / 255
    """Largest change of this difference from pixel to pixel: rounding to 8 bits changes it by two levels."""

    growth_max: int = 24
    """Rounds of growth, of one pixel each: ringing of JPEG reaches 16 pixels from an edge where colour is halved."""

    # Areas that follow the shading of icons (regions/surface_growing.py, regions/shading_joining.py)

    surface_areas: tuple[int, int, int] = (4, 9, 25)
    """Fewest pixels of an area whose shading is level, a plane, and of the second degree."""

    surface_rest: float = 1.0 / 255
    surface_difference: float = 2.5 / 255
    """Root mean square that a surface may leave of its pixels, and the largest difference, in some channel, of a pixel
    that continues it; of areas of ``ramp_area_min`` and more, it is that of ``paint``. With 2 levels for all, a carrot
    of 32 px has 28.5 dB at 4 times the size in place of 31.5."""

    surface_starts: tuple[tuple[int, int], ...] = ((5, 6), (3, 3))
    """Sides in pixels of the squares with which areas begin, and terms of their surfaces: six are of the second degree,
    and three a plane."""

    start_rest: float = 0.8 / 255
    start_bend: float = 0.08
    start_step: float = 40 / 255
    """Root mean square that the surface of such a square may leave: the first, or so much of its steepest change from
    pixel to pixel, which is at most the last. The mixed pixels of an edge leave a fifth of that, unless one of three
    is mixed by half."""

    surface_area_min: int = 12
    """Smaller areas that begin so are none. With 25, ten icons of 24 and 48 px lose 0.3 dB at 4 times the size, though
    a face of 24 px with glasses gains 4.8."""

    shading_rest: float = 1.0 / 255
    """Root mean square that a gradient may leave of two areas that it joins. What it leaves from ``peel_error_min`` on
    would part them again."""

    shading_part: float = 0.6
    """Least part of the border of two areas of one shading at which the colours change about as before and behind."""

    bin_area: int = 6
    """Fewest pixels of a place at which the colours along a ramp are averaged, in small areas."""

    # Mixes of pixels (regions/assignment.py)

    loose: float = 3.0
    """Multiple of the tolerance at which a pixel of a noisy picture is taken for pure if no mix explains it."""

    ringing_reach: int = 8
    """Distance in pixels that ringing of JPEG reaches: the side of a block."""

    canvas_reach: int = 2
    """Distance in pixels from the end of the picture at which the canvas beyond it can have a share."""

    # Mixes of two and three regions (regions/unmixing.py)

    candidate_count: int = 4
    """Nearest regions of a pixel whose mixes are compared. More than four hardly meet within three pixels."""

    pixels_at_once: int = 8192
    """Pixels whose mixes are found together: their arrays stay in the processor's cache, and a megapixel of noise takes
    little memory."""

    mix_distance_cost: float = 0.25 / 255
    """Residual that a mix with a region at one pixel more of squared distance must save: where colours lie on one line,
    many pairs explain a pixel, and the nearest do in truth."""

    triple_gain: float = 0.5
    """Three regions are taken for a pixel if they leave less than this part of the residual of two."""

    far_share_max: float = 0.35
    """Largest share of what shines through the seam of two shapes that abut: anti-aliasing of both leaves at most a
    quarter of it, and a bit more where three meet."""

    # Bands of colour (regions/banding.py)

    band_width: float = 24 / 255
    """Widest range of colours in a band."""

    bands_max: int = 8
    """Bands of an area at most: each becomes a path."""

    band_error_min: float = 6 / 255
    """Root mean square that the best paint of an area leaves, beside the noise, from which it is divided into bands."""

    # Paints of areas (regions/paint_fitting.py)

    paint_samples_max: int = 4096
    """Pixels of an area that its paint is fitted to, evenly taken from all of them."""

    ramp_area_min: int = 64
    noisy_ramp_area_min: int = 400
    """Smaller areas are flat in clean and in noisy pictures: they show too little of a ramp, and ringing looks like
    one."""

    shared_area_min: int = 32
    """Smaller areas are not compared with the ramps of others, nor have a ramp of their own, except by
    ``small_ramp_deviation``."""

    small_ramp_deviation: float = 4 / 255
    """In clean pictures smaller areas, too, have a ramp if a flat paint leaves so much as a root mean square, and the
    ramp no more than ``small_ramp_rest``. A liquid in an icon of 32 px, in two areas of 43 and 51 pixels, was two flat
    bands: the icon had 28.7 dB at 4 times the size, and has 31.7 with its ramp."""

    small_ramp_rest: float = 1.6 / 255
    """Root mean square that the ramp of a small area may leave."""

    plain_area_min: int = 9
    """Smaller areas have no ramp. Those from here up to ``shared_area_min`` have a linear one of two stops, in clean
    pictures."""

    shared_gain: float = 0.8
    """The ramp of another area is chosen if it leaves less than this part of what a flat paint leaves."""

    shared_small: int = 4
    shared_small_gain: float = 1.5
    """The same for areas of less than this multiple of the least one with a ramp of its own: noise changes these
    more."""

    shared_error: float = 1.5
    """And at most this multiple of what it leaves in that other area, or of what a flat area leaves."""

    ramp_contrast: float = 4 / 255
    """Difference of the stops of a ramp, beside the noise; less is not seen."""

    flat_deviation: float = 0.8 / 255
    """Root mean square that rounding and a few mixed pixels leave in a flat area of a clean picture."""

    stop_deviation: float = 0.45 / 255
    """Root mean square that a ramp may leave in a clean picture, where a stop more would leave less: rounding leaves
    0.29 levels. An eye does not see the difference, but a bend that is left out is one of the designer's stops."""

    stop_price: float = 0.02
    """Squared error, summed over the pixels and channels of an area, that a stop more must save in a clean picture
    even if the ramp is good enough without it: large areas show a bend of half a level, small ones do not. In noisy
    pictures it must save more, by the square of what a ramp may leave there."""

    noise_deviation: float = 0.35
    """Part of the noise of a picture that is the root mean square deviation in flat areas."""

    # Ramps of opacity (regions/paint_fitting.py)

    translucent_max: float = 0.998
    """Opacity of a path whose stops are translucent. It hides nothing, and a file states it as 1."""

    opacity_min: float = 0.25
    """Least opacity of a ramp: colours of paler pixels are too uncertain."""

    opacity_change: float = 4 / 255
    """Least change of the opacity in an area that has a ramp of it."""

    # Ramps of parts of areas (regions/peeling.py)

    peel_error: float = 1.5 / 255
    """Root mean square that the ramp of a part may leave, beside what any ramp may leave."""

    peel_error_min: float = 1.2 / 255
    """Root mean square that the paint of an area leaves, beside the noise, from which a ramp of a part is tried."""

    peel_area_min: int = 150
    """Smaller areas are not divided."""

    peel_rest: float = 3.5 / 255
    """Largest difference from a ramp at which a pixel shows it in any case: three times the rounding of both."""

    peel_spread: float = 4.0
    """Multiple of the median difference at which a pixel may still show the ramp."""

    peel_slope: float = 4.0
    """Multiple of the median slope of an area's blocks up to which a block lies on its ramp, and not on an edge."""

    peel_share: float = 0.35
    """Share of an area that its ramp must show."""

    peel_gain: float = 1.02
    """A ramp of a more general kind is taken if it shows more than this multiple of the pixels."""

    peel_rounds: int = 10
    """Times that a ramp is fitted anew to the pixels that show it. Five are usual."""

    peel_depth: int = 6
    """Parts of an area that get a ramp of their own at most."""

    # Directions of ramps (regions/ramp_directions.py)

    blocks_across: int = 10
    """Blocks across an area, in which the slope of its colours is measured."""

    block_min: int = 3
    block_max: int = 16
    """Sides of a block in pixels: smaller ones show nothing but rounding, larger ones hide curvature."""

    block_fill: float = 0.6
    """Part of a block that lies in the area at least, so that its slope is certain."""

    profile_bins: int = 32
    """Places at which the colours along a ramp are averaged while its direction is refined."""

    refinements: int = 5
    """Steps of Gauss and Newton on the direction or centre. They converge in three."""

    ellipse_refinements: int = 10
    """The same for ellipses, whose four numbers depend on each other more."""

    ellipse_stretch_max: float = 0.97
    """Largest stretch of an ellipse: the ratio of its axes is the root of (1 + stretch) / (1 - stretch), 8 here."""

    center_far: float = 8.0
    """A centre farther from an area than this multiple of its size is that of a linear ramp."""

    # Stops of ramps (regions/ramp_fitting.py)

    ramp_bins: int = 64
    """Places at which the colours along a ramp are averaged before stops are placed."""

    knots_max: int = 8
    """Stops of a ramp at most, as many as a path may have."""

    idle_knots: int = 2
    idle_gain: float = 0.9
    """No more stops are tried if the last so many have brought the error to more than this part of what it was."""

    knot_steps: tuple[float, float, float, float] = (1.0, 0.5, 0.25, 0.125)
    """Steps, in bins, by which stops are moved to where the parts that they join meet best."""

    radial_gain: float = 0.8
    """A radial ramp is chosen if it leaves less than this part of what a linear one leaves, and an elliptic one if it
    leaves less than this part of what these leave."""

    ramp_gain: float = 0.6
    plain_ramp_gain: float = 0.85
    """A ramp is chosen over a flat paint if it leaves less than this part of what the flat one leaves: the second where
    that is seen."""

    plain_ramp_error: float = 2.5 / 255
    """Error of a flat paint, as a root mean square beyond the tolerance, from which one sees that it is a ramp."""

    knot_gain: float = 1.3
    """Fewer stops are taken if they leave at most this multiple of the error of more."""

    flat_step: float = 1.5 / 255
    """Stops whose colours differ by less in each channel show one colour."""

    # Fits of all numbers of a ramp (regions/ramp_refitting.py)

    refit_samples_max: int = 16_384
    """Pixels of an area that the numbers of its ramp are fitted to."""

    refit_rounds: int = 12
    refit_gain: float = 1e-3
    """Most steps of Gauss and Newton, which end once a step lowers the squared error by a smaller share."""

    refit_damping: float = 1e-9
    """What is added to the matrix of a step, whose entries on the diagonal are 1."""

    refit_pad_min: float = 0.01
    """Share of the pixels of an area that must lie beyond an end of its ramp to tell where that end is."""

    refit_reach: float = 0.25
    refit_places: int = 65
    refit_level: float = 0.1
    """An end whose place no pixel tells may lie farther out by so much of the ramp. So many places are tried, until the
    colours are within so many levels of whole ones: those lose least when they are rounded."""

    # Ramps of several regions (regions/inside_pixels.py, regions/ramp_joining.py, regions/joint_ramps.py)

    explained_max: float = 0.7
    """Largest root mean square in levels that regions of a clean picture leave of it, up to which none join. Of the
    sixteen originals they leave 0.05 to 0.55; of drawings whose ramps are in pieces 1.4 to 6."""

    inside_area_min: int = 12
    """Fewer pixels inside a region say nothing about its paint."""

    typical_max: float = 48 / 255
    """Largest difference of a paint from the mean of the pixels inside its region. White lines whose region got pixels
    of a red ground had 168 levels, the tip of a ramp that grew along it 30."""

    joined_max: int = 512
    """Most regions that may join, the largest ones: the time grows by the square, and 1,024 take 2.5 CPU s."""

    joint_area_min: int = 48
    joint_border_min: int = 4
    """Fewest pixels of a ramp over two regions, and fewest of these at their seam."""

    joint_slack: float = 0.5
    """Where one of two regions has a ramp already, a joint ramp may leave more squares than both paints, because it has
    half the stops: this part of the squares that the better one of the two paints leaves."""

    joint_shared: float = 1.25
    """A small region gets the ramp of a large one that leaves up to so much more than its own paint."""

    # Parts without a pure pixel (regions/thin_parts.py)

    thin_rounds_max: int = 6
    """Rounds of new regions. Each explains one colour of an unexplained area; few areas have more."""

    thin_samples_max: int = 400
    """Pixels of an unexplained area that paints are compared on."""

    own_colors: int = 12
    """Colours of an area that are tried for it."""

    first_color_part: float = 0.9
    """The purest colour of an area is taken if it explains at least this part of the pixels that any of them
    explains."""

    known_paint_part: float = 0.85
    """A known paint is taken if it explains at least this part of the pixels that the best of its own colours
    explains."""

    top_residual: float = 0.8
    """Pixels with more than this part of the largest residual show the purest colour of an area."""

    peak_share_min: float = 0.6
    """A paint known from elsewhere explains an area only if some pixels show this share of it. Otherwise the area is
    drawn in its own paler colour: a line of less than half a pixel's width would be lost."""

    plateau_share: float = 0.3
    """Part of an area's pixels that shows one colour, which then is its own colour and not a mix with a paler one."""

    plateau_area: int = 24
    noisy_plateau_area: int = 100
    """Pixels of a line that is drawn in a colour of its own, in clean and noisy pictures; shorter ones are tips."""

    anchor_share: float = 0.45
    """Share of a new region from which a pixel belongs to it: a bit below one half keeps lines of one pixel in one
    piece where they lie between two pixels."""

    seam_part: float = 0.8
    """Part of the pixels of an area that must look like a seam of two regions."""

    thin_strength: float = 2.0
    """An area is looked at if a pixel in it is unexplained by this multiple of the tolerance."""

    pair_gain: float = 0.25 / 255
    """Residual that a mix of three colours must save over one of two."""

    # Lines between two pixels (regions/hairlines.py)

    hairline_width_min: float = 0.5
    noisy_hairline_width_min: float = 0.75
    """Least share of a line in two pixels side by side, and so its width in pixels, at which it is kept in one piece,
    in clean and in noisy pictures."""

    hairline_raised_share: float = 0.55
    """Share that the larger of the two gets at the cost of the other, so that the line has a pixel of its own there."""

    hairline_beside_max: float = 0.3
    """Largest share in the pixels before and behind these two. Beside the edge of a wider region, one has more."""

    hairline_ahead_max: float = 0.92
    """Largest share in the rows of pixels above and below. Where a wider region begins, one has all."""

    # Specks (regions/specks.py)

    clear_contrast: float = 0.25
    """Difference from all regions around, in some channel, from which a speck stands out. The dot of an i has more;
    what ramps and bands leave has far less, and mixes at an edge lie near one of its sides."""

    # Connected areas (regions/label_areas.py)

    corner_share: float = 0.3
    """Least mean share of four pixels that a line has which passes their corner."""

    # Areas that are no regions (regions/region_merging.py)

    small_area: int = 64
    noisy_small_area: int = 400
    """It is less certain that smaller areas of clean and of noisy pictures are regions."""

    small_pool: float = 2.0
    """Multiple of the tolerance within which the colour of a small area is that of a larger one."""

    edge_share_max: float = 0.6
    """An area in which no pixel has a larger share is no region, but the faint side of an edge between two pixels."""

    wisp_share_max: float = 0.9
    wisp_area_max: int = 24
    """A smaller area in which no pixel has a larger share, and which lies between two regions, is a wisp at their
    edge."""

    between_border_share: float = 0.75
    """An area lies between regions if less than this part of its border touches one of them."""

    explained_part: float = 0.8
    """A small area is dropped if the regions around explain this part of its pixels."""

    # The regions of a picture (regions/regions.py)

    speck_area: float = 4.0
    speck_area_of_icons: float = 2.0
    """Areas of fewer pixels are specks; in small pictures each pixel was placed to be seen."""

    clear_speck_area: float = 1.5
    """The same for areas of clean pictures that stand out, as the dot of an i does in text of a screen."""

    soft_speck_area: float = 0.5
    """Area of a speck in pictures with soft edges, as a part of the square of their reach: blur hides them."""

    icon_size: int = 200
    """Longer side in pixels below which a picture is small."""

    seeds_max: int = 4096
    """Most pure areas of flat art. Sixteen drawings have 5 to 106 at 512 px, as PNG or JPEG; squares of 8 pixels in a
    picture of 1024 have 16,384, and noise has none."""

    edges_max: int = 200_000
    edges_share_max: float = 0.2
    """Edges between pixels of two regions, and their share in all pixels, above both of which a picture is no flat art.
    Fits to so long outlines take minutes: rays and a Hilbert curve of 1024 px, with 245,000 and 524,000 edges, ended as
    photos after 130 CPU s. Their shares are 0.23 and 0.5; those of 27 drawings of 500 px and more are below 0.1."""

    canvas_border_share: float = 0.5
    canvas_pure_share: float = 0.9
    canvas_known_share: float = 0.2
    """The paint of an opaque canvas has at least the first share of the picture's border, or the second share of those
    pixels of the border that show one region alone. These pixels must be the third share of the border. The rim of
    fav32_bourbon touches three sides, and leaves four parts of the page. There, 0.23 of the border are pure, and all of
    these show the page."""

    canvas_difference: float = 2.5 / 255.0
    """Largest difference of a paint from that of the canvas it was pooled with."""

    # Pictures of too many regions (regions/fewer_regions.py)

    regions_max: int = 1024
    """Most regions of a drawing, twice the paths of the default. The order of the layers takes time and memory by the
    square of this number: of 1,024 regions a second and 100 MB."""

    # Fewer colours (regions/fewer_colors.py)

    opaque: float = 0.99
    """Regions of at least this opacity are opaque; only regions of equal opacity are joined."""


REGIONS = RegionConstants()
