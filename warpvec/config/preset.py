"""A preset is a named set of settings; the table is in `warpvec.config.presets`."""

from __future__ import annotations

from typing import Any, NamedTuple


class Preset(NamedTuple):
    """A set of settings with a purpose."""

    sentence: str
    """What the preset is for, as the help says it."""
    settings: dict[str, Any]
    """The fields that differ from the defaults of FitConfig."""
