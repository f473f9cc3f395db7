"""Take straight thin lines and dots out of the picture of a request: they are drawn as such, the rest as it is."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from warpvec.image.picture import Picture, mean_image
from warpvec.modes.request import Request
from warpvec.modes.restored import Restoration

if TYPE_CHECKING:  # SciPy, which a photo does not need
    from warpvec.condition.condition import Condition

_ENLARGEMENT_MAX = 2.0
"""Width of a picture over that of its copy up to which lines are looked for in the picture itself: with more, a line of
a pixel has less than half of its ink in the copy, and the time is that of four copies."""


def with_lines_apart(found: Restoration) -> Restoration:
    """Return ``found`` with the straight thin lines of its picture apart, if it has a set of equal ones, and the dots.

    Thin lines and dots look like the rims of a reduction, or like blur. A picture with such lines is taken as it is,
    and one with dots if there are no rims without them.
    """
    given, condition = found.given, found.condition
    if not _may_have_lines(given, condition):
        return found
    from warpvec.flat.thin_lines.thin_lines import find_thin_lines

    picture, settings = given.picture, given.settings
    is_whole = settings.mode != "lines" and _is_reduced_little(picture)
    image = picture.pixels if is_whole else picture.reduced
    lines = find_thin_lines(image, settings.curves, has_lines=settings.mode != "lines")
    if lines is None:
        return found
    if is_whole:
        lines = lines.scaled(*picture.reduction, mean_image(lines.ground, settings.fit_size))
    encoding = replace(given.encoding, picture=replace(picture, reduced=lines.ground))
    apart = replace(given, encoding=encoding, thin_lines=lines)
    if condition is None:
        return Restoration(given, None, apart)
    from warpvec.condition.blur import SHARP
    from warpvec.condition.condition import measure_condition

    is_soft = condition.reduction is not None or condition.blur > 0.0
    if is_soft and not (len(lines.lines.scene) or len(lines.above.scene)):
        rest = measure_condition(lines.ground)
        if rest.reduction is not None or rest.blur > 0.0:
            return found
    return Restoration(given, replace(condition, edge_blur=SHARP, reduction=None), apart)


def _is_reduced_little(picture: Picture) -> bool:
    """Return whether the copy of a ``picture`` is smaller, so that its thin lines are blurred, but not by much.

    In larger pictures, lines that are thin in the copy are wide, and traced by their outlines.
    """
    return not picture.is_restored and 1.0 < max(picture.enlargement) <= _ENLARGEMENT_MAX


def _may_have_lines(request: Request, condition: Condition | None) -> bool:
    """Return whether a picture can have lines or dots that its settings want as such, and is clean enough for them."""
    settings = request.settings
    is_free = settings.strokes != "off" and not (settings.cutout or settings.colors or request.goal)
    is_free = (
        is_free and settings.mode in ("auto", "flat", "lines") and settings.palette is None and settings.min_area == 0.0
    )
    if not is_free or request.picture.is_transparent or request.watch.is_over():
        return False
    if condition is None:
        return True
    # Pixels of two levels have no lines between them: they are taken as they are, or smoothed.
    if condition.palette is not None and condition.palette.has_two_levels:
        return False
    return (
        condition.enlargement is None
        and condition.jpeg is None
        and condition.light is None
        and not any(condition.noise)
    )
