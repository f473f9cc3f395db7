"""Choices about how a file is written."""

from __future__ import annotations

from dataclasses import dataclass

from warpvec.checks import check_flag
from warpvec.svg.units import check_size


@dataclass(frozen=True, kw_only=True)
class FileOptions:
    """Choices about the file alone. They do not change the fit, and the metadata does not state them.

    Raises:
        InputError: a field has the wrong type, or the size is none.
    """

    metadata: bool = True
    """Store the settings of the fit in the file, about 1 KB."""
    trim: bool = False
    """Cut the paths off at the edges of the canvas."""
    size: str | None = None
    """Width of the drawing with its unit, such as "90mm"; see `warpvec.svg.units.check_size`. None for its pixels."""

    def __post_init__(self) -> None:
        check_flag("metadata", self.metadata)
        check_flag("trim", self.trim)
        if self.size is not None:
            object.__setattr__(self, "size", check_size(self.size))


DEFAULT_FILE_OPTIONS = FileOptions()
"""The settings are stored and the paths are not cut."""
