"""Choices about how a file is written."""

from __future__ import annotations

from dataclasses import dataclass

from warpvec.checks import check_flag


@dataclass(frozen=True, kw_only=True)
class FileOptions:
    """Choices about the file alone. They do not change the fit, and the metadata does not state them.

    Raises:
        InputError: a field is neither True nor False.
    """

    metadata: bool = True
    """Store the settings of the fit in the file, about 1 KB."""
    trim: bool = False
    """Cut the paths off at the edges of the canvas."""

    def __post_init__(self) -> None:
        check_flag("metadata", self.metadata)
        check_flag("trim", self.trim)


DEFAULT_FILE_OPTIONS = FileOptions()
"""The settings are stored and the paths are not cut."""
