"""The table of forms. To add one, write its file in this folder, and add it here.

Lines, polylines and polygons need no entry: their rows are all lines, and the writer knows them by that.
"""

from __future__ import annotations

from collections.abc import Mapping

from warpvec.errors import InputError
from warpvec.geometry.forms.circle import Circle
from warpvec.geometry.forms.ellipse import Ellipse
from warpvec.geometry.forms.form import Form
from warpvec.geometry.forms.rect import Rect, RoundRect

OUTLINE, CIRCLE, ELLIPSE, RECT, ROUND_RECT = range(5)
"""Numbers of the forms in `warpvec.geometry.path_forms.Forms.kind`. Saved scenes hold them."""

FORMS: Mapping[int, Form] = {CIRCLE: Circle(), ELLIPSE: Ellipse(), RECT: Rect(), ROUND_RECT: RoundRect()}
"""Number -> form."""


def form_of(number: int) -> Form:
    """Return the form with a ``number``.

    Raises:
        InputError: there is none.
    """
    if number not in FORMS:
        known = ", ".join(f"{known} ({form.name})" for known, form in FORMS.items())
        raise InputError("forms.kind", f"must be {OUTLINE} (outline), {known}", str(number), "give one of these")
    return FORMS[number]
