"""The numbers of flat art: how black and white art is traced."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class MonoConstants:
    """How black and white art is traced."""

    # Outlines of ink (mono.py)

    area_min: float = 2.0
    """Marks and holes of fewer square pixels may be specks. It is what potrace calls turdsize, with potrace's
    default."""

    dot_reach: int = 4
    """Pixels from a small mark to a stroke that it may belong to: umlauts and commas of letters of 9 to 16 px have 1 to
    3."""

    thin_radius: float = 1.5
    """Radius in pixels of the widest part near a small mark that may belong to it: strokes of one or two pixels have 1
    to 1.4. Dots of letters with wider strokes are larger than specks."""

    chance_factor: float = 2.0
    """Small marks beside thin strokes are meant if there are more than this factor times as many as dust would leave
    there, by what it leaves elsewhere."""

    lone_max: int = 4
    """Small marks that lie alone, up to which those of a picture of two levels are meant: dust has more."""

    point_area: float = 1e-6
    """Outlines of fewer square pixels are points, where the grey of a pixel is exactly that which parts ink from paper.
    They have no direction, and no length to be sampled along."""

    faint_level: float = 0.2
    faint_window: int = 5
    faint_pixels: int = 6
    """Least ink of a pixel of a line too thin to be drawn; side in pixels of the squares around ink whose soft edges
    are no lines; and the fewest pixels of such a line. Noise of scans has no connected pixels of as much ink."""

    two_level_share: float = 0.02
    """A picture has two levels only if fewer of its pixels along edges lie in between; else over half of them do."""

    between_levels: float = 0.1
    """A level is in between if it is so far from both ink and paper, as a share of their difference."""

    staircase_blur: float = 0.45
    """Standard deviation in pixels of the blur of pictures of two levels, which makes slopes of their staircases. More
    of it closes the gaps between the lines of an engraving, and opens thin lines."""

    joint_level: float = 0.15
    joint_window: int = 7
    """By how much the mean of the four pixels must exceed a half where two pixels of a line touch at a corner, so that
    the blur leaves them joined; and side in pixels of the square that tells whether ink or paper is the line there. A
    line of one pixel came apart where it is oblique, as the arc of the door in plan_1bit. Five drawings of
    `bench/mono.py` change by at most 0.0001 of IoU; with 0.1 the engraving loses 0.001."""

    long_edge: int = 4
    """Pixels of a level or upright edge, in a picture of two levels, from which a corner beside it is meant."""

    ink_pixels_max: int = 500_000
    """Most pixels of a picture in which dots and thin lines get their ink back: so many take 280 MB and 3 s."""

    ink_rounds: int = 4
    ink_gain: float = 2.0
    ink_reach: float = 0.7
    ink_missing_min: float = 0.06
    ink_samples: int = 4
    """Rounds in which thin parts get back the ink that the blur takes; the change of the field for missing ink; the
    deviation in pixels of the Gaussian over which it is measured; less is a step of a staircase; samples along a side
    of a pixel. Of eighteen drawings and texts of two levels (game icons, Lucide, text of 9 to 16 px), 167 marks were
    lost without, and 41 are with these, finer tolerances and no limit of area. With 0.03 the curves need
    3 % more segments."""

    staircase_scale: float = 4.0
    """Enlargement at which curves are fitted to outlines of two levels: corners of letters are a pixel apart. Those
    drawings have 0.2 dB more at 4 times the size than with 2."""

    letter_side: float = 24.0
    full_width: float = 2.5
    thin_tolerance: float = 0.14
    """Longer side in pixels of an outline that may be a letter; its mean width in pixels from which it has the whole
    tolerance. Thinner ones have less in proportion, but not less than the third: a stroke of one pixel that may move by
    0.56 on either side becomes a spindle. The long lines of an engraving would follow the steps of their staircases."""

    staircase_tolerance: float = 0.56
    """Tolerance in pixels for pictures of two levels: an edge may lie anywhere within a pixel of a staircase. With 0.4,
    a circle of radius 33 has 18 segments in place of at most 8; with 0.6, the side of a bar is no line."""

    noise_deviations: float = 3.0
    """Standard deviations of the noise that the tolerance grows by, because every outline has some points that far
    off."""

    edge_slope: float = 0.4
    """Least change of coverage per pixel across an edge of a usual scan; noise over it is the error of the edge's
    place."""

    sharp_share: float = 0.7
    """Least share of the partly covered pixels with both ink and paper beside them, in a picture with sharp edges. It
    is 0.79 to 1 in icons that a renderer drew, at 32 to 512 px, with JPEG 50 too, and 0.08 to 0.54 if they are blurred
    by half a pixel, as by a scanner, or enlarged. Where edges are sharp, sums of coverage are exact (`contours_of`);
    where they are not, interpolation is, and it suffers less from noise."""

    soft_scale: float = 2.0
    """Enlargement at which curves are fitted to outlines of scans and of pictures of two levels: the fit expects
    corners as sharp as those of a renderer, farther apart than in the letters of a scan. The IoU of scan_deed with the
    clean ink is 0.86, at scale 1 it is 0.81; that of ink_photo 0.96 and 0.94, that of plan_1bit 0.914 and 0.907. At 3,
    no picture has more. Where the blur of a clean picture is known, a fit undoes it, and the scale is 1 at most and
    less the wider the blur is: two arrows of 400 px, blurred by 2 px, have 20 parameters as their designer's have, and
    96 at scale 1."""

    pure_levels: float = 0.05
    """A pixel is ink or paper if its level is at most so far from that, as a share of their difference."""

    solid_count: int = 64
    """Least number of pixels inside of strokes that tell the level of ink; without them all strokes are thin."""

    thin_quantile: float = 0.1
    """Share of the ink's pixels that are as dark as ink, where all strokes are thin."""

    bins: int = 256
    """Levels of the histogram, as many as those of eight bits."""

    outlines_max: int = 4096
    """Most outlines of a picture, the largest of it. A page of small text has 3,000; noise has any number, of which
    each takes two milliseconds."""

    outlines_at_once: int = 256
    """Outlines that are fitted together; half a second of them passes before Ctrl-C is noticed."""

    # Circles, ellipses and rectangles (modes/mono.py)

    form_loops_max: int = 256
    """Most outlines among which forms are looked for: the page of a book has thousands of letters."""


MONO = MonoConstants()
