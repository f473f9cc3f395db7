"""Choices about how a file is written."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class FileOptions:
    """Choices about the file alone. They do not change the fit, and the metadata does not state them."""

    metadata: bool = True
    """Store the settings of the fit in the file, about 1 KB."""
    trim: bool = False
    """Cut the paths off at the edges of the canvas."""


DEFAULT_FILE_OPTIONS = FileOptions()
"""The settings are stored and the paths are not cut."""
