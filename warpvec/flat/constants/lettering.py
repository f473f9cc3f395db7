"""The numbers of flat art: how small marks on one paint, such as letters, are found and outlined."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class LetteringConstants:
    """How small marks on one paint, such as letters, are found and outlined."""

    # Marks on one paint (regions/lettering.py, marks.py, words.py, word_inks.py, islands.py, box_gaps.py), and on
    # several (crossing_marks.py)

    noise_max: float = 2.5 / 255
    """Noise of a picture up to which marks are looked for. Screens with gradients have 2.0 levels."""

    ground_area_min: int = 256
    part_area_min: int = 64
    """Pixels of a region that can be the ground of marks, and of one of the same flat paint as a larger one. The
    counters of letters of 40 px have fewer than the first; their strokes are seldom as large as the second."""

    part_side_min: int = 5
    """Longer side in pixels, less one, of the smallest mark among edges of grounds. Edges leave smaller ones over."""

    edge_share_max: float = 0.5
    """Largest share of the pixels around a mark that are edges of its ground, such as a narrow halo."""

    height_max: int = 48
    width_max: int = 96
    """Shorter and longer side in pixels of the largest mark: letters of 40 px with their accents, two of which may
    touch."""

    islands_max: int = 8192
    marks_max: int = 2048
    """Most islands in grounds that are looked at, and most marks, on one ground and on several: more are a texture. The
    time grows by the first, and the memory by the square of the second, up to 150 MB."""

    pure_part_max: float = 0.6
    """Share of the ink of a group of marks that lies in pixels of pure ink. With more, the usual regions are as good:
    letters of 8 to 20 px have 0 to 0.5, and letters of 40 px have 0.7."""

    pure_word_max: float = 0.8
    """The same of a word of several marks: bold letters of 20 px have 0.65."""

    pure_share: float = 0.95
    """Share of ink in a pixel of pure ink."""

    mix_part: float = 0.98
    """Share of the pixels of a mark that are a mix of its ink and the ground."""

    crossing_part: float = 0.8
    """The same of a mark on several grounds, whose edges it crosses."""

    covered_run: int = 3
    side_ink_min: float = 0.05
    pure_difference: float = 2.0 / 255
    """Pixels of a straight side of a stroke that reaches into both neighbours of each, and so shows its ink; least ink
    in these, as a share; and by how much such pixels may be less pure than the purest. Of 1245 words of 9 to 16 px, in
    twelve colours a page, 344 letters show their ink so or by five equal pixels; one of these was off, by 16 %."""

    ink_difference: float = 4.0 / 255
    """Distance of two inks that count as one: rounding moves each channel by half a level."""

    ink_contrast_min: float = 0.15
    """Least difference of ink and ground in some channel: fainter marks are shades."""

    reach_across: float = 0.6
    reach_down: float = 0.3
    reach_min: float = 1.5
    """Distances between two marks of one word or line, beside and above each other: as shares of the height of the
    larger one, and the least in pixels. Spaces have 0.4; lines of text are 0.3 and more apart."""

    reach_of_dots: float = 1.0
    """Distance of a dot from a letter of its line, as a share of the letter's height: one between two words has a space
    on both sides."""

    depth_share_min: float = 0.7
    """Marks of one ink are at least so pure, as a share of the purest beside them: a pale word beside a dark one has an
    ink of its own."""

    weak_side_max: int = 2
    """Rows or columns of marks that may have no pure pixel, such as dots and the letter l."""

    ink_near: float = 0.85
    lone_ink_near: float = 0.6
    """Ink of a word, and of a mark alone, that reaches this share of an ink known from elsewhere is that ink: thin
    letters may have no pure pixel, and one alone says less. Of several such inks, it is the nearest: with the
    farthest, 66 of the 1245 words are off by more than 10 dE, and not 17."""

    agreeing_pixels: int = 4
    agreeing_marks: int = 2
    """Least number of pixels as pure as the purest one, and of marks that have such pixels, from which a word shows its
    ink: without them, gray words of a page took the colour of the thin ring beside them."""

    # Words too small to be read (regions/small_text.py)

    word_marks_min: int = 3
    legible_height: float = 7.0
    """Least marks of a word, and the height in pixels, with the soft edges, below which its letters cannot be read:
    small letters of a font of 10 px have 7, which `bench/reading.py` reads, and those of 8 px have 6."""

    # Outlines of thin parts (layers/fine_outlines.py, straight_sides.py)

    fineness: int = 4
    """Sub-pixels along the side of a pixel."""

    rounds: int = 4
    """Rounds in which the ink of each pixel goes where most is on a line through it. One more, by rows and columns,
    makes sides smooth: without it rings of 1.1 to 1.8 px are rough."""

    line: int = 5
    directions: int = 16
    line_near: float = 1.2
    line_share: float = 0.6
    """What counts in these rounds: the sub-pixels of a line, the directions of lines, of which the one with the most
    ink counts, the deviation in sub-pixels of a Gaussian, and the weight of the line. Of text of 8 to 17 px in four
    fonts, 0.179 of the ink is on wrong sub-pixels. With rows and columns alone, it is 0.194, and strokes of a W break.
    """

    near: float = 1.5
    along: int = 9
    along_share: float = 0.3
    """What counts as around a sub-pixel in the last round: the deviation of a Gaussian in sub-pixels, the sub-pixels of
    a row and of a column, and the weight of these. Without them, corners of stems are 0.26 px off in place of 0.21.
    With a half, the top of a t comes off (ss_chat)."""

    steepness: float = 4.0
    """Rise of the ink of a sub-pixel with the ink around it: those within an eighth of the level are partly full, so
    that contours lie between sub-pixels. With 2 or 8, rings of 1.1 to 1.8 px are off by 0.03 px in place of 0.013."""

    halvings: int = 10
    """Times that the range of the level which parts full from empty sub-pixels is halved: to 0.001."""

    thin_line_max: float = 0.45
    thin_line_inside: float = 0.15
    thin_line_area: float = 32.0
    """Share of a line that may lie in pixels that it fills, or be hidden, for it to be outlined so; pixels with four
    neighbours in it, as a share of its area; and its least area in square pixels. The sides of roads of 0.8 px fill
    0.15 to 0.4, have 0.1 inside at crossings, and 36 square pixels at least. What edges leave over has 3 to 31
    (gif_vscode), and a blurred shape has 0.25 inside (blur2_puppet)."""

    thin_line_box: int = 400_000
    """Most pixels of the box of such a line. A net of lines of 1,000 by 1,000 pixels takes 6.7 CPU s and 0.5 GB."""

    loop_area_min: float = 0.25
    """Area in square pixels of the smallest loop of a thin part: the hole of an e of 10 px has 0.5."""

    side_length: float = 3.0
    side_error: float = 0.15
    """Length in pixels of the shortest level or upright side beside a square end, and by how much points of it may lie
    off its line. Letters of 12 px have stems of 9 px, whose ends bulge by so much. With 2 px, names on a map (map) lose
    0.4 dB."""

    side_share: float = 0.85
    """Share of its length that as many points as it has sub-pixels span: some are where it crosses from one column of
    these to the next."""

    lone_side: float = 4.0
    lone_error: float = 0.05
    """The same of a side between two bends: a ring of 32 px across has no such side."""

    end_width_max: float = 2.5
    end_length_max: float = 2.5
    end_error: float = 0.5
    """Width in pixels of the widest stem whose ends are made square, the pixels that are not straight before its end,
    and by how much these may lie outside of its sides: serifs are wider."""

    scale: float = 6.0
    """Enlargement at which curves are fitted to the outline of a thin part: the two corners at the end of a stem are
    nearer to each other than the fit expects of pixels, which drew one spike with 3. Outlines may move as far as
    elsewhere. When that was a third, a chart with text (chart_pie) took a fifth more bytes."""

    shaded_area_min: int = 9
    """Pure pixels of a gradient from which an island is a shaded shape, and no mark of one ink. The tip of a logo
    (skill-icons arch at 48 px), 72 pixels of a gradient, was drawn torn in place of shaded."""

    wide: float = 1.6
    wide_scale: float = 3.0
    """Mean width in pixels from which a thin part is fitted at this enlargement. The two corners of its ends are then
    far enough from each other, and its sides do not follow the noise of a restored picture: up100_mantine, whose parts
    are 1.8 px wide, has 27.3 dB at 4x in place of 26.3. Letters of 12 px are 1.1 px wide."""

    dot_side: float = 3.0
    """Longer side in pixels below which an outline of a thin part is a dot or a hole. It is fitted within the
    tolerance of others divided by its scale, or the dot of an i can vanish (chart_pie)."""


LETTERING = LetteringConstants()
