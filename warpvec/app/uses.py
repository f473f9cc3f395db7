"""Offer uses of a file on the page: each has a kind of file, and a purpose of the table."""

from __future__ import annotations

from html import escape
from typing import NamedTuple


class Use(NamedTuple):
    """A choice of the page.

    Attributes:
        label: what the file is for.
        kind: suffix of the file, without its dot.
        purpose: a key of `warpvec.purposes.table.PURPOSES`.
        help: what the file is, and what to do with it.
    """

    label: str
    kind: str
    purpose: str
    help: str


USES = (
    Use("Web, Inkscape, most programs", "svg", "web", "An SVG with all that the drawing has."),
    Use("My cutter or laser", "dxf", "web", "A DXF in millimetres: set its width at the right. Make, above, has more."),
    Use("Cricut", "svg", "cricut", "An SVG that Design Space opens at its size, with one colour for each shape."),
    Use("A pen plotter", "svg", "pen", "An SVG for vpype and plotters, with a layer for each pen."),
    Use("An Android app", "xml", "android", "A VectorDrawable: put it into res/drawable of the app."),
    Use("A web app in React", "jsx", "web", "A component, which takes size and colour from the page."),
    Use("A print shop", "pdf", "print", "A PDF, in which soft shapes are steps of colour."),
    Use("Office, games, PDF tools", "svg", "plain", "An SVG of plain shapes alone, which every program shows."),
    Use("A font", "svg", "font", "An SVG of one black shape, as a letter of a font."),
    Use("Old phones and devices", "svg", "tiny", "An SVG Tiny 1.2."),
)
"""The choices, the usual one first."""


def uses_markup() -> str:
    """Return the options of the list."""
    return "".join(
        f'<option value="{purpose}" data-kind="{kind}" data-help="{escape(words)}">{escape(label)}</option>'
        for label, kind, purpose, words in USES
    )
