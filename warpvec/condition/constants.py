"""The numbers of the measurement of a picture's condition."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class ConditionConstants:
    """When a picture counts as enlarged, blurred, noisy, saved as JPEG or unevenly lit. Levels are of 255."""

    window: int = 1536
    """Side in pixels of the part of a very large picture that is looked at."""

    # Enlargement (enlargement.py, resampling.py)

    ridge: float = 1e-4
    """Share of the mean diagonal that is added to it, so that every enlargement has an inverse. More of it would blur
    the small picture."""

    cut_off: tuple[float, float] = (0.5, 254.5)
    """Gray levels up to which a pixel is black, and from which it is white, so that an overshoot may be cut off there.
    They are half a level from 0 and 255, as gray is a weighted sum of channels that is not exactly whole."""

    cut_off_rounds: int = 6
    """Rounds in which pixels that were cut off at black or white get the values that the others predict."""

    rows: int = 32
    """Rows and columns that are looked at, among those that change most. The time is in proportion to them."""

    side_min: int = 8
    """Smallest side in pixels of a picture before its enlargement."""

    factor_min: float = 1.3
    """Smallest enlargement that is looked for. Smaller ones leave too little to compare."""

    factors: tuple[float, ...] = (1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 16.0, 20.0, 24.0, 32.0)
    sides: tuple[int, ...] = (
        16, 24, 32, 48, 64, 72, 80, 96, 100, 120, 128, 144, 150, 160, 180, 192, 200, 240, 256, 300, 320, 400, 480, 500,
        512, 600, 640,
    )  # fmt: skip
    """Enlargements, and sides before it, that people use."""

    always: tuple[float, ...] = (1.5, 2.0, 3.0, 4.0)
    usual_count: int = 8
    """Enlargements that are always tried, and number of the others among those that people use, by their spectrum: an
    enlargement by 2 changes every other pixel, which a spectrum hardly shows."""

    peaks: int = 4
    """Peaks of the spectrum of changes that are tried."""

    spectrum_window: int = 121
    change_levels: float = 4.0
    """Entries of a spectrum whose median is the usual height at their middle; and change of levels that counts little
    beside noise."""

    tried: int = 6
    scan_dip_max: float = 0.95
    """Sizes with the deepest dips that all kernels are tried with, and the largest share that they may leave
    unexplained at the first look, whose kernel may be another."""

    dip_reach: int = 5
    """Sizes on either side of one that it is compared with. Drawings with few edges have small dips everywhere."""

    clean_share: float = 0.75
    clean_levels: float = 0.05
    """A picture is clean if this share of the second differences along its busiest lines have at most so many levels.
    An enlargement of it by whole pixels leaves no more unexplained: a ramp on a grid of four pixels leaves 0.4 levels,
    and pixel art after JPEG has differences of 0.5."""

    clean_rest_max: float = 1.0
    clean_whole_rest_max: float = 2.5
    rest_max: float = 1.3
    """Most levels that other enlargements leave unexplained: of clean pictures on both axes, without what was cut off
    at black or white and with it, and of others on the better one. Drawings that were enlarged from 60 to 256 px, which
    are clean, leave up to 0.8 and 1.7, and others, JPEG of 60 among them, up to 0.95. Of 107 drawings at 512 and at
    200 px, none counts as enlarged; those with edges on a grid leave 1.04 to 5.9 with what was cut off."""

    nearest_rest_max: float = 4.5
    """Most levels that an enlargement by whole pixels leaves unexplained of a picture that is not clean, at whose edges
    JPEG rings. Pixel art that was enlarged 4 to 12 times leaves 0.2 to 4.2 at quality 75, and up to 6 at 50. An icon of
    rounded rectangles on a grid leaves 6 and more at 50."""

    dip_levels: float = 0.3
    """Levels that rounding leaves unexplained; they are added to what is compared with."""

    dip_max: float = 0.8
    nearest_dip_max: float = 0.35
    axis_dip_max: float = 0.87
    """Largest share that the right size leaves unexplained of what sizes beside it do: the geometric mean of both axes
    for kernels that interpolate, and for whole pixels, and that of one axis. Of 100 clean drawings of 64 to 512 px, as
    they are, blurred and as JPEG of quality 40 to 90, and 12 photos, the lowest mean is 0.86; one strongly blurred
    drawing with bars has 0.76, and 0.88 on one axis. Of 115 drawings that were enlarged by 1.5 to 8, 107 are found, and
    76 of 105 that were then saved as JPEG of quality 60 to 90."""

    # Reduction (edge_models.py, reduction.py, even_colors.py, unrimming.py)

    patch_reach: int = 3
    patch_slope_min: float = 60.0
    patch_rounds: int = 8
    patches_min: int = 50
    patches_max: int = 1200
    """Pixels on each side of the middle of a patch, as far as Lanczos reaches; least change of levels over two pixels
    there; rounds of the fit; fewest patches with an edge that tell; and most that are looked at, for time."""

    patches_few: int = 150
    """Most patches that tell first whether edges may have rims at all."""

    curvature_max: float = 0.2
    step_min: float = 30.0
    edge_rest_max: float = 0.03
    """Largest curvature of an edge, per pixel; least difference in levels between its sides; and most that its best
    kernel leaves unexplained, as a share of it: corners and thin lines leave more, and tell nothing."""

    rim_max: float = 0.15
    """Largest height of a rim as a share of its edge: Lanczos kernels overshoot by 9 % at one edge, and by 15 % where
    two are near."""

    reduction_share_max: float = 0.9
    """What the best kernel with rims leaves unexplained is at most this share of what the best without does. Right ones
    leave 0.17 to 0.74 in 16 clean pictures, and up150_mio has 0.70. Bicubic and Lanczos are taken for each other where
    most edges are level: rims are undone nearly as well. JPEGs are left as they are: of 11 of quality 80 that were
    reduced by means, a thin one counts as bicubic with 0.6."""

    edge_share_max: float = 0.8
    rimless_edges_max: float = 1.0 / 3.0
    """An edge tells if one kind of kernel leaves at most this share of what the other does; and the largest share of
    edges without rims among those that tell. In reduced drawings it is 0 to 0.04, and 0.3 in logos and maps with many
    level edges. A plot, whose grid touches its frame, has 0.45; a table of a browser 0.96, of which five edges of
    letters had outweighed all others."""

    rimless_colors_max: int = 16
    """Most colours of a picture without rims: icons of 16 colours have none, and their steps look like bicubic ones."""

    unrimmed_pixels_max: int = 300_000
    """Most pixels that rims are undone in, the margins of parts included. A metro plan of 640 x 440 px has 228,000."""

    unrimmed_speed: float = 20_000.0
    """Pixels that rims are undone in within a CPU second."""

    unrimmed_share: float = 0.1
    """Largest share of the time that is left, if it is limited, in which rims are undone. Else they stay."""

    still_share_min: float = 0.3
    """Least share of even areas and gradients in a drawing: kodim15 counts as reduced."""

    gradient_max: float = 0.1
    """Most that gradients may have of the still pixels of a picture that was not enlarged. Charts, maps and logos have
    0.0; icons with gradients have 0.2 to 0.34, of which firefox came out worse by 3 dB at 4x, and microsoft-edge by
    0.5."""

    unrimmed_block: int = 32
    """Side in pixels of the parts that rims are undone in, so that even areas take no time."""

    unrimmed_margin: int = 6
    """Pixels around each part that are looked at with it: twice as far as Lanczos reaches."""

    even_range: float = 1.5 / 255
    """Largest range of the values in a square of 3 x 3 pixels of one colour: rounding may change them by one level."""

    still_bend: float = 2.1 / 255
    """Largest second difference in a gradient: rounding may change it by two levels."""

    even_colors_max: int = 64
    """Most colours of even areas that are looked at."""

    even_pixels_min: int = 24
    """Fewest pixels of such a colour: three squares."""

    even_apart: int = 2
    """Largest difference in levels of two colours that count as one."""

    even_reach: int = 10
    """Distance in pixels at which a pixel may show the colour of an even area: the stems of a large letter lie so far
    apart."""

    even_snap: float = 5.0 / 255
    """Difference from the colour of an even area that counts as none. Total variation leaves up to 4 levels of a thin
    white line, and rounding one more."""

    rim_reach: int = 3
    """Distance in pixels between a rim and what it is a rim against, as far as Lanczos reaches."""

    rim_share: float = 0.2
    """Largest strength of a rim, as a share of the contrast of its edge. Lanczos has 0.07 at one edge and 0.09 beside a
    thin line, and the gap between two stems has twice as much."""

    rim_cosine: float = 0.9
    """Least cosine between the directions of a rim's colour and of its edge: white and black cut a rim off."""

    fineness: int = 3
    fine_weight: float = 100.0
    fine_rounds: int = 150
    """Pixels of the fine picture along a side of one of the given picture; weight of squared errors against total
    variation; and rounds of its minimization. With 4, 100 and 200, the error of an emoji of 150 px that was reduced by
    bicubic and Lanczos falls from 47.7 and 45.2 to 54.7 and 53.7 dB; with 80 rounds, to 50.8 and 48.9 dB."""

    # Noise (noise.py)

    noise_block: int = 8
    noise_side: int = 200
    noise_small_block: int = 5
    noise_rows_min: int = 6
    noise_blocks: int = 4096
    """Side of the blocks; shortest side of a picture from which they have this side, and their side in smaller ones,
    where larger ones would all have edges; fewest rows of blocks; and most blocks."""

    noise_quantile: float = 0.25
    noise_spread: float = 1.5
    noise_spread_up: float = 1.9
    noise_share_min: float = 0.45
    """Noise is about that of the quarter of the white blocks with least; blocks agree within these factors below and
    above, and this share of all does so. With 0.4, the grain of a Kodak photo (kodim09, 1.9 levels) is noise."""

    memory_max: float = 1.3
    """Most by which neighbours differ more than in white noise; film grain and texture have 1.4 and more."""

    cut_share: float = 0.4
    spoiled_share: float = 0.05
    """Share of a block at black or white from which half of its noise was cut off, and from which some was."""

    noise_min: float = 1.0
    noise_max: float = 48.0
    """Least noise in levels that is not rounding, and most that is not the picture."""

    # Before the noise (denoising.py)

    denoised_min: float = 0.5
    """Least deviation of the noise of a channel, in levels, when others have more: a channel of one level has none."""

    alike_reach: int = 6
    alike_side: int = 3
    alike_spread: float = 1.0
    """Reach in pixels in which pixels that are alike are looked for; side of the squares around them that are compared;
    and root mean square by which squares may differ, beyond noise of deviation 1, to count a third. Noise of 8 and 15
    levels on two drawings falls to 41.9 to 49.2 dB; reaching 8 pixels gains 0.9 dB for 1.7 times the time, and squares
    of 5 pixels lose 1.7 to 2.8 dB."""

    # Blur (blur.py)

    blur_pairs: tuple[tuple[float, float], ...] = ((0.7, 1.4), (1.4, 2.8), (2.8, 5.6))
    blur_reach: float = 2.0
    """Pairs of deviations in pixels that slopes are compared at, and the blur over the finer one from which the next
    pair measures better."""

    antialiasing: float = 0.16
    """Variance in square pixels of an edge as a renderer draws it: 0.12 if it is oblique and 0.21 along the grid."""

    blur_min: float = 0.45
    """Smallest blur in pixels. Anti-aliased edges have up to 0.37."""

    blur_tile: int = 64
    blur_tiles: int = 48
    """Side of the tiles in pixels, and number of those with the most edges. More take longer."""

    blur_slope_share: float = 0.25
    blur_noise_factor: float = 3.0
    """An edge is at least so steep, as a share of the steepest, and over the noise of the slopes."""

    blur_edges_min: int = 24
    blur_quantile: float = 0.5
    """Fewest pixels along edges, and which of their blurs counts. Corners and thin lines seem sharper, shades
    softer."""

    blur_least_quantile: float = 0.1
    blur_even_share: float = 0.4
    """Which of the blurs of edges is the least, and its least share of the usual one in a picture that was blurred as a
    whole. Four icons of 512 px have 0.77 to 0.97 if blurred by 0.6 to 3 pixels, with noise and JPEG 80 too. A picture
    of which a third is sharp has 0.14, and a photo of ink on paper 0. Pictures of some 200 px with thin lines may have
    less than this though they are blurred, and are drawn as soft as they are."""

    # JPEG (jpeg.py)

    jpeg_blocks: int = 128
    """Most blocks that are looked at. 91 qualities take 0.1 s for so many."""

    jpeg_change_min: float = 8.0
    """Least range of levels in a block that tells more than its mean."""

    jpeg_equal_max: float = 0.78
    """Largest share of neighbours in these blocks that have exactly the same level. Of 23 icons as JPEG of quality 40
    to 95, 0.71 at most do; the clean icons whose blocks look rounded by chance, an equals sign and a QR code, have 0.96
    and 0.85."""

    jpeg_rounding: float = 1.01
    """Largest change of a pixel's level when a block is rounded to its own steps again: half a level when it was
    decoded, and half when brightness and colours became red, green and blue."""

    jpeg_cut_rounds: int = 3
    """Times that a block is rounded, each with the pixels that were cut off as the last one decoded them."""

    jpeg_bits_min: float = 12.0
    """Least bits of a block that says a quality. With 8, one of 400 clean pictures of 32 to 256 px is a JPEG."""

    jpeg_blocks_min: int = 2
    jpeg_share_min: float = 0.02
    """Fewest blocks, and least share of the blocks that tell, that say the quality. With one, 2 of 400 clean pictures
    are JPEGs. Of 1600 JPEGs of logos of 32 to 256 px, at quality 40 to 90, 1020 say theirs, and none a wrong one; most
    others are small or have one colour."""

    # Levels (levels.py)

    palette_max: int = 64
    palette_step: int = 7
    """Most colours of a palette, and the step between the rows of a first look. Grey JPEGs have up to 256."""

    dither_side_min: int = 64
    dither_share_min: float = 0.02
    dither_step: float = 12.0
    """Shortest side of a dithered picture, because single pixels of pixel art are meant; smallest share of pixels that
    differ from both neighbours in a row, which are alike, in a picture of few colours; and the smallest difference in
    levels. Drawings with sharp edges have at most 0.004."""

    # Light of paper (light.py)

    paper_side_min: int = 96
    paper_tiles: int = 32
    paper_window: int = 11
    """Shortest side of a scan; tiles along its longer side; and tiles along the longest dark area that is ink."""

    paper_color_max: float = 40.0
    """Largest mean difference of the channels of paper, in levels: it may be yellow, but not a sky."""

    paper_quantile: float = 0.25
    paper_grain_max: float = 10.0
    paper_grain_min: float = 1.0
    """Paper varies in a tile as in the quarter of the tiles with least; largest deviation there, in levels, as walls
    vary more; and least median of its second differences: with less, a gradient was drawn, not lit."""

    paper_deviations: float = 3.0
    paper_levels: float = 6.0
    paper_share_min: float = 0.78
    paper_brighter_max: float = 0.01
    """A pixel is paper within so many deviations of the grain, and so many levels more; least share of such pixels; and
    largest share of brighter ones: nothing is brighter than paper."""

    paper_range_min: float = 16.0
    paper_dark_min: float = 64.0
    """Least difference in light that matters, and darkest paper, in levels."""


CONDITION = ConditionConstants()
