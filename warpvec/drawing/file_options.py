"""Choices about how a file is written."""

from __future__ import annotations

from dataclasses import dataclass

from warpvec.config.fit_config import RESULT
from warpvec.config.kinds import Custom, Flag, parse_text
from warpvec.config.setting import setting, settings_of
from warpvec.svg.units import check_size


def _check_size(name: str, value: object) -> str | None:
    del name
    return None if value is None else check_size(value)


@dataclass(frozen=True, kw_only=True)
class FileOptions:
    """Choices about the file alone. They do not change the fit, and the metadata does not state them.

    Raises:
        InputError: a field has the wrong type, or the size is none.
    """

    size: str | None = setting(
        None, Custom(_check_size, parse_text, "WIDTH", "90mm, 3in, 50%", "str"),
        "Width, such as 90mm; also in, cm, pt, px or %.", RESULT, is_daily=True,
    )  # fmt: skip
    """Width of the drawing with its unit, such as "90mm"; see `warpvec.svg.units.check_size`. None for its pixels."""
    trim: bool = setting(False, Flag(), "Cut the paths off at the edges of the canvas.", RESULT, is_daily=True)
    """Cut the paths off at the edges of the canvas."""
    plain_paths: bool = setting(False, Flag(), "Write paths only, no circles, ellipses or rectangles.", RESULT)
    """Write paths in place of forms, for programs that read nothing else."""
    no_metadata: bool = setting(False, Flag(), "Leave the settings (1 KB) out of the file.", RESULT)
    """Leave the settings of the fit, about 1 KB, out of the file."""

    dxf_splines: bool = setting(False, Flag(), "DXF: write curves as splines, not as short lines.", RESULT)
    """Write outlines with curves as splines in DXF files, in place of chords within 0.01 mm."""

    def __post_init__(self) -> None:
        for name, each in settings_of(FileOptions).items():
            object.__setattr__(self, name, each.kind.check(name, getattr(self, name)))


DEFAULT_FILE_OPTIONS = FileOptions()
"""The file states the settings, and the paths are not cut."""
