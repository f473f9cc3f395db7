"""Read what an SVG says about itself: its title and warpvec's settings."""

from __future__ import annotations

import json
from typing import Any
from xml.etree import ElementTree

from warpvec.svg.document import local_name, parse_svg, read_text


def description_of(data: bytes) -> tuple[str | None, dict[str, Any] | None]:
    """Return the title and warpvec's metadata in an SVG that can be read; None for what it does not have."""
    builder = ElementTree.TreeBuilder()
    parse_svg(read_text(data), builder)
    texts = {local_name(child.tag): child.text or "" for child in builder.close()}
    return texts.get("title"), _settings_in(texts.get("metadata", ""))


def _settings_in(text: str) -> dict[str, Any] | None:
    try:
        found = json.loads(text)
    except (ValueError, RecursionError):
        return None
    is_own = isinstance(found, dict) and str(found.get("generator", "")).startswith("warpvec ")
    return found if is_own else None
