"""Take straight thin lines out of the picture of a request, so that they are drawn as lines and the rest as it is."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from warpvec.modes.request import Request
from warpvec.modes.restored import Restoration

if TYPE_CHECKING:  # SciPy, which a photo does not need
    from warpvec.condition.condition import Condition


def with_lines_apart(found: Restoration) -> Restoration:
    """Return ``found`` with the straight thin lines of its picture apart, if it has a set of equal ones.

    Thin lines look like the rims of a reduction, or like blur, so that a picture with them is taken as it is.
    """
    given, condition = found.given, found.condition
    if not _may_have_lines(given, condition):
        return found
    from warpvec.condition.blur import SHARP
    from warpvec.flat.thin_lines.thin_lines import find_thin_lines

    picture = given.picture
    lines = find_thin_lines(picture.reduced)
    if lines is None:
        return found
    encoding = replace(given.encoding, picture=replace(picture, reduced=lines.ground))
    clean = None if condition is None else replace(condition, edge_blur=SHARP, reduction=None)
    return Restoration(given, clean, replace(given, encoding=encoding, thin_lines=lines))


def _may_have_lines(request: Request, condition: Condition | None) -> bool:
    """Return whether a picture can have lines that its settings want as such, and is clean enough to tell them."""
    settings = request.settings
    is_free = settings.strokes == "auto" and not (settings.cutout or settings.colors or request.goal)
    is_free = is_free and settings.mode in ("auto", "flat") and settings.palette is None and settings.min_area == 0.0
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
