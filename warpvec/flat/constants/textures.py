"""The numbers of flat art: which areas of a drawing are photos."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class TextureConstants:
    """When a part of a drawing is a photo. Levels are of 255."""

    # What is drawn (textures.py)

    still_change: int = 3
    jpeg_still_change: int = 8
    """Largest change in 3 x 3 pixels of a still place, and that in a JPEG of quality 60 and more."""

    rest_max: float = 0.75
    jpeg_rest_max: float = 2.0
    """Largest root mean square that a plane may leave of the levels of a still area for it to be drawn: rounding leaves
    0.3 of a gradient. The skies of Kodak's photos leave 1 to 2."""

    still_area: int = 64
    """Fewest pixels of a still area that is drawn. Smaller ones are found in photos, too."""

    drawn_min: float = 0.15
    """Smallest share of the picture that is drawn. Of Kodak's photos 0 to 0.13 are still by chance."""

    # Which of the other areas are photos

    thumbnail_side: int = 64
    """Longest side in pixels of a picture that has no photo in it: details of an icon of 64 px look like texture."""

    core_reach: int = 4
    """An area of texture is a square of twice these pixels and one at least. Edges and strokes of small text are
    thinner."""

    area_min: float = 0.02
    jpeg_area_min: float = 0.08
    side_min: int = 36
    """Smallest share of the picture of an area of texture, that in a JPEG, where shaded drawings of some size have
    texture, too, and the side in pixels of a square as large."""

    roundness_max: float = 1.8
    """Largest length of the outline over that of a circle of the same area. Photos in rectangles and ovals have 0.9 to
    1.6, traces of JPEG along outlines 1.6 to 4."""

    changing_change: int = 3
    changing_min: float = 0.75
    textured_change: int = 8
    textured_min: float = 0.25
    weak_min: float = 0.15
    """Changes in 3 x 3 pixels, and the smallest shares of the area with more of them; the last is that of changes
    between the second and those of strong edges. Kodak's photos in cards and ovals have 0.79 to 1, 0.38 to 1 and
    0.26 to 0.8; soft shading and gradients 0.1 to 0.2 of the first two, dots of a halftone and blurred outlines few
    weak changes or a long outline."""

    rough_change: float = 2.0
    rough_min: float = 0.2
    """Difference in levels of a pixel from the mean of its 3 x 3 pixels, and the smallest share of an area of texture
    with more. Kodak's photos in cards and ovals have 0.42 and more; shadows of our own making have 0."""

    off_share: float = 0.05
    off_min: float = 0.3
    """Difference of a pixel from both the dark and the light of an area, as a share of the difference of these two, and
    the smallest share of pixels with more. Kodak's photos in cards and ovals have 0.74 and more, as JPEG too; the
    stroke of a letter of logo_kotlin, as a JPEG that is not found, has 0.11."""

    flatness_max: float = 4.5
    """Flatness of the box around a part, by `warpvec.flat.mode_choice`, up to which the part may be a photo."""

    shading_min: float = 0.035
    """Share of shading of that box, from which on the part may be a photo however flat the box is. Of 28 photos in
    ovals, cards and small pictures, as they are and as JPEG of quality 40 and 80, the nearest are coins with 6.4 and
    0.04, 4.4 and 0.06, 3.5 and 0.03, and others with up to 2.8. Of 80 logos with gradients as JPEG of quality 30 to 50,
    14 copies were half photo; 13 of them have 5.6 to 11 and 0.01 to 0.03."""

    drawing_rest_max: float = 22.0
    drawing_root_max: float = 64.0
    drawing_product_max: float = 400.0
    """Levels that regions leave of a part, a root mean square, these times the root of the count of the regions, and
    times the count, up to all of which the part is a drawing and no photo: of texture, K regions leave about as much as
    the root of K is smaller. Of 440 logos with gradients, as they are and as JPEG of quality 30 to 80, 64 have such
    parts, of which 54 have up to 20 levels, 62 and 260. Of ovals and cards of Kodak's photos, as they are, as JPEG and
    as WebP, the nearest have 67 and 538, 71 and 468, 74 and 418."""

    judged_side: int = 288
    """Longest side in pixels of the middle of a part of which that is judged: of a photo, it takes up to 2 CPU s."""

    # What stands for it in the drawing (texture_outlines.py)

    whole_min: float = 0.99
    """Smallest share of a pixel that a photo covers where the pixel has its colour."""

    contrast_min: float = 48.0
    """Difference in levels of a photo and its surroundings from which the mix of a pixel tells how much of it the photo
    covers; with less, texture is as large."""

    # The outlines of photos (texture_forms.py)

    form_margin: int = 4
    """Pixels around a photo that its outline may reach."""

    form_error: float = 0.7
    """Largest distance in pixels, on average along its outline, of a photo from the form that it is taken for."""

    outline_blur: float = 1.5
    """Deviation in pixels of the Gaussian that smooths other outlines."""

    # How they are drawn (modes/mixed.py)

    margin: int = 2
    """Pixels of surroundings that the fit of a photo sees, so that paths reach below the soft edge of its window."""

    key_distance: float = 0.1
    """Largest difference in [0, 1] of a channel of a path that stands for a photo from the colour that it was given."""

    paths_min: float = 0.25
    """Smallest share of the paths that is left to the photos."""


TEXTURES = TextureConstants()
