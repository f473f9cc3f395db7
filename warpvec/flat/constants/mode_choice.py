"""The numbers of flat art: how the mode of a picture is chosen."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class ModeChoiceConstants:
    """How the mode of a picture is chosen."""

    # Flat art, photos, and black and white art (mode_choice.py)

    side: int = 512
    """Longest side in pixels of the copy that is looked at, which takes 0.1 s. Larger pictures are reduced by means."""

    still_change: int = 8
    strong_change: int = 64
    """Largest change of levels (of 255) in 3 x 3 pixels, after a median, of a still place; and smallest of a strong
    edge. JPEG of quality 60 changes still places by up to 8."""

    edge_reach: int = 6
    """Pixels around a strong edge in which weak steps may be traces of JPEG or of anti-aliasing."""

    block_side: int = 8
    """Side of the blocks in pixels. Few of them in flat art have more than two paints."""

    near_share: float = 0.2
    near_levels: int = 8
    """A level is between the darkest and the lightest of its block if it is farther from both than this share of their
    difference, and than these levels."""

    bias: float = 20.7
    weak_weight: float = 8.6
    between_weight: float = 49.0
    shading_weight: float = 32.0
    lonely_weight: float = 12.0
    """Flat art has a weighted sum of the four shares below the bias. The numbers come from a logistic regression on the
    sixteen pictures of flat art and 28 photos (Kodak, scikit-image), as they are, as JPEG of quality 60 to 95, reduced
    to 48 to 256 pixels, blurred, noisy, grey, filtered and cropped. Seven of 868 come out wrong, six of them with 48 to
    128 pixels."""

    photo_flatness: float = -10.0
    """Up to this the shares tell a photo; from there to 0 they leave a doubt, and the shorter description decides
    (evidence/explanation.py). It bounds the work: of the copies of four photos by bench/strangers.py, 31 of 40 are
    below, and none takes the time of regions."""

    icon_side: int = 40
    """Longest side in pixels of a picture that is an icon in any case. Of 62 icons of 16 px the measures take 13 for
    photos, of 107 of 32 px two; of 48 px none, nor any photo of 48 px for flat art."""

    color_area: float = 0.002
    """Smallest share of the picture that counts as a colour in the reason."""

    colors_shown: int = 24
    """With more colours, the reason says that there are many."""

    grey_max: int = 24
    """Largest difference of the channels of a grey, as scans and JPEG show it."""

    colored_max: float = 0.002
    """Largest share of coloured pixels in black and white art."""

    middle_range: tuple[float, float] = (0.25, 0.75)
    """Greys this far from ink to paper are neither of the two."""

    middle_max: float = 0.002
    middle_per_edge: float = 0.5
    """Largest share of pixels in the middle in black and white art: of still ones, and of all ones for each pixel at a
    strong edge."""

    clean_black: int = 16
    clean_white: int = 240
    scanned_black: int = 96
    scanned_white: int = 190
    """Levels of ink and paper: as drawn by a program, and as scanned, where both are uneven."""

    scan_noise: int = 2
    """Median change of levels in 3 x 3 pixels far from strong edges, after a median, from which a picture is a scan.
    Drawn ones have 0, and at most 1 as JPEG."""

    shade_levels: int = 12
    shade_share_max: float = 0.005
    """Difference of levels from both ink and paper, and the largest share of pixels far from strong edges with more of
    it in black and white art that is no scan: a light shade is a third colour."""

    shade_step: int = 20
    shade_step_share_max: float = 0.01
    """Change of levels in 3 x 3 pixels at the border of such a shade, and the largest share of pixels with more of it
    in scans, whose paper may grow darker slowly."""

    ink_max: float = 0.5
    """Largest share of ink: art is dark on light, except that of two levels."""

    edges_max: float = 0.5
    """Most sides between ink and paper for each pixel of light art on dark of two levels. Icons and text of 9 to 16 px
    have up to 0.11, photos dithered to two levels 1.0 to 1.3."""


MODE_CHOICE = ModeChoiceConstants()
