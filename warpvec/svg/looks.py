"""How elements of an SVG are filled and stroked, as they state it or as groups around them do."""

from __future__ import annotations

import re
from typing import NamedTuple


class Look(NamedTuple):
    """What an element states or inherits of its paint.

    Attributes:
        fill, stroke: as stated, such as "none" or "#000".
        width: width of its stroke in user units, as stated.
        cap, join: ends and corners of its stroke.
    """

    fill: str = "black"
    stroke: str = "none"
    width: str = "1"
    cap: str = "butt"
    join: str = "miter"

    @property
    def is_stroked(self) -> bool:
        """Whether it has a stroke."""
        return self.stroke != "none"

    def of(self, attributes: dict[str, str]) -> Look:
        """Return the look of an element with ``attributes`` inside of an element with this one."""
        style = _stated(attributes["style"]) if "style" in attributes else {}
        found = {field: style.get(name, attributes.get(name)) for field, name in _PROPERTIES.items()}
        changed = {field: text for field, text in found.items() if text not in (None, "inherit")}
        return self._replace(**changed) if changed else self


_PROPERTIES = {
    "fill": "fill", "stroke": "stroke", "width": "stroke-width", "cap": "stroke-linecap", "join": "stroke-linejoin",
}  # fmt: skip
"""Field of `Look` -> its name in SVG."""

_DECLARATION = re.compile(r"\s*([\w-]+)\s*:\s*([^;]*[^;\s])\s*")


def _stated(style: str) -> dict[str, str]:
    found = (_DECLARATION.fullmatch(part) for part in style.split(";"))
    return {match[1]: match[2] for match in found if match}
