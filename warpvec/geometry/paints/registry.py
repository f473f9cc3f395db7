"""The table of the kinds of paint. To add one, write its file in this folder, and add it here."""

from __future__ import annotations

from collections.abc import Mapping

from warpvec.errors import InputError
from warpvec.geometry.paints.elliptic import Elliptic
from warpvec.geometry.paints.kind import GradientKind
from warpvec.geometry.paints.linear import Linear
from warpvec.geometry.paints.radial import Radial

FLAT, LINEAR, RADIAL, ELLIPTIC = range(4)
"""Numbers of the kinds of paint in `warpvec.geometry.gradients.Gradients.kind`. Files of checkpoints hold them."""

KINDS: Mapping[int, GradientKind] = {LINEAR: Linear(), RADIAL: Radial(), ELLIPTIC: Elliptic()}
"""Number -> kind of gradient. The kernels have functions of those that need no stops in ``kernels/gradients.py``."""


def kind_of(number: int) -> GradientKind:
    """Return the kind of gradient with a ``number``.

    Raises:
        InputError: there is none.
    """
    if number not in KINDS:
        raise unknown_kind(number)
    return KINDS[number]


def unknown_kind(number: int) -> InputError:
    """Return the error for a ``number`` that is no kind of paint."""
    known = ", ".join(f"{known} ({kind.name})" for known, kind in KINDS.items())
    return InputError("gradients.kind", f"must be {FLAT} (flat), {known}", str(number), "give one of these")
