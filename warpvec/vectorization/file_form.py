"""Keep properties of the drawing's own file, such as its size and title, in the file of the refined drawing."""

from __future__ import annotations

import json
from typing import Any, NamedTuple
from xml.etree import ElementTree

from warpvec.config.fit_config import MACHINE_SETTINGS, FitConfig
from warpvec.config.modes import FLAT_MODES, FLAT_SETTINGS
from warpvec.svg.document import local_name, parse_svg, read_text


class FileForm(NamedTuple):
    """The form of a file.

    Attributes:
        size: height and width in the file's units.
        precision: decimals of the coordinates in these units.
        title: the title, None for none.
        metadata: the settings that the file states, None for none.
        sides: width and height with their units, None for the size in pixels.
        layer_names: names of the layers by generation, None for numbers.
        minified: whether the file is the one of `warpvec.svg.minify.write_minified`.
        keeps_layers: whether such a file has a group for each level of detail.
    """

    size: tuple[int, int]
    precision: int
    title: str | None = None
    metadata: dict[str, Any] | None = None
    sides: tuple[str, str] | None = None
    layer_names: dict[int, str] | None = None
    minified: bool = False
    keeps_layers: bool = False


FORM_SETTINGS = ("minify", "grid")
"""Settings of files without metadata, which other files need not state."""


def stated_settings(config: FitConfig) -> dict[str, Any]:
    """Return the settings that a file states.

    The file of a photo is silent about flat art, and about gradients and closing lines without any, which saves bytes.
    That of flat art is small, and states what differs from the defaults.
    """
    settings, plain = config.to_dict(), FitConfig().to_dict()
    if config.mode in FLAT_MODES:
        named = {name: value for name, value in settings.items() if name not in MACHINE_SETTINGS}
        return {name: value for name, value in named.items() if value != plain[name]}
    unused = [name for name in ("gradients", "closing_line") if not settings[name]]
    left_out = (*MACHINE_SETTINGS, "mode", *FLAT_SETTINGS, *FORM_SETTINGS, *unused)
    return {name: value for name, value in settings.items() if name not in left_out}


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
