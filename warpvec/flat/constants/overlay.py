"""The numbers of flat art: how words over several grounds are told from what lies below them."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class OverlayConstants:
    """How words over several grounds are told from what lies below them."""

    # Inks and marks (overlay/overlaid_words.py, marks.py)

    inks_max: int = 12
    """Most colours that are tried as inks."""

    ink_pixels_min: int = 12
    """Fewest pixels of an ink in small regions: the stems of one word have as many."""

    row_pixels_min: int = 3
    """Fewest pixels of an ink in a row of marks that shows it."""

    window: int = 15
    """Side in pixels of the window whose median is the ground of a mark: letters of 20 px leave most of it free."""

    core_min: float = 0.3
    """Share of the ink, against the median of the window, from which a pixel is a part of a mark: thin gray lines at
    the sides of a white road have 0.25 of black."""

    contrast_min: float = 0.3
    """Least length of the difference of an ink and the ground. Nearer colours are shades."""

    mark_height_max: int = 24
    """Largest shorter side of a mark in pixels: that of letters of 20 px."""

    mark_width_max: int = 96
    """Largest longer side of a mark in pixels: some letters of 20 px may touch."""

    marks_max: int = 1024
    """Most marks of one ink: more are a texture."""

    pixels_max: int = 8192
    """Most pixels of marks that are tried in a picture: a word of 10 px has 150. It bounds the time to some 8 s."""

    hidden_max: int = 6144
    """Most pixels of one row: more are a texture. It bounds the memory to 200 MB."""

    letters_min: int = 3
    """Fewest letters of a word: two marks lie on a line by chance."""

    letter_share_min: float = 0.5
    """Share of ink from which a pixel counts as one of a letter, so that neighbours come apart."""

    letter_height_min: int = 5
    """Least longer side of a letter in pixels."""

    row_error_max: float = 0.35
    """Root mean square, as a share of the height of the letters, by which their middles may lie off a line."""

    ring_share_min: float = 0.05
    """Least share of the pixels of grounds around a word that show another ground than the most frequent one."""

    ring_ink_max: float = 0.02
    """Largest share of the pixels around a word in its own ink: an edge of a shape looks like marks in the paint beyond
    it."""

    # What lies below (overlay/filling.py)

    margin: int = 20
    """Pixels around a word that say what lies below it."""

    directions: int = 48
    """Directions in which the ground may go on below a word."""

    reach: int = 16
    """Most pixels from a hidden pixel to the ground on either side."""

    step: float = 0.5
    """Distance in pixels of the samples along a direction."""

    profile: tuple[float, ...] = (0.5, 1.0, 2.0, 1.0, 0.5)
    """Weights of the pixels across a direction that are compared on both sides."""

    structure_worth: float = 0.2
    """Worth of what a profile shows: a road goes on below a letter, although the fields beside it agree as well."""

    length_cost: float = 3e-6
    """Cost of the square of the distance in pixels between both sides."""

    ink_cost: float = 60.0
    """Cost of what no mix of the ink and the ground explains. With 5, a letter in the corner of two roads has a tenth
    of its pixels on a wrong ground."""

    neighbor_weight: float = 0.5
    """Weight of the cost at each neighbour: the ground goes on in one direction there."""

    rounds: int = 3
    """Rounds of filling. After each, pixels with hardly any ink, as the fill says, show the ground."""

    free_share_max: float = 0.04
    """Largest share of ink in a pixel that shows the ground."""

    free_error_max: float = 0.06
    """Largest difference in [0, 1] of a pixel that shows the ground from the fill."""

    # What counts as a word (overlay/overlaid_words.py)

    rest_max: float = 12.0 / 255
    """Largest difference of a pixel from its mix of ink and ground that explains it."""

    explained_min: float = 0.93
    """Least share of the pixels of a word that its ink and the ground explain."""

    purest_min: float = 0.75
    """Least share of ink in the purest pixel of a word whose ink is known from another one: strokes of letters of 10 px
    are 0.9 px wide."""

    least_share: float = 0.02
    """Share of ink in a pixel below which there is none."""


OVERLAY = OverlayConstants()
