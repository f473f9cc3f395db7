"""Few settings that the page sends with a picture: checked, and turned into those of a run."""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields
from typing import Any

from warpvec.checks import as_float, check_choice, check_count, check_flag
from warpvec.config.fit_config import FitConfig
from warpvec.config.modes import DETAIL_MAX, MODES
from warpvec.config.presets import make_config
from warpvec.errors import InputError
from warpvec.vectorization.goal import Goal, with_curves

CURVES_MAX = 4096
"""Most paths of a photo that the page offers: as many as it draws smoothly while they are edited."""

BYTES_MIN, BYTES_MAX = 1_000, 10_000_000
"""Smallest and largest limit of the file."""

COLORS_MAX = 64
"""Largest palette that the page offers."""


@dataclass(frozen=True, kw_only=True)
class FitSettings:
    """The settings of the page.

    Raises:
        InputError: a field has the wrong type or is out of range.
    """

    mode: str = "auto"
    """"auto", "photo", "flat" or "mono"."""
    curves: int = 512
    """Number of paths of a photo."""
    detail: float = 0.1
    """Root mean square in pixels by which outlines of flat art may move."""
    max_bytes: int | None = None
    """Largest size of the SVG; it decides the number of paths, or the detail."""
    colors: int = 0
    """Largest number of colours; 0 for any."""
    gradients: float = 0.0
    """Share of the paths of a photo that get a gradient."""
    opaque: bool = False
    """Whether every path is opaque."""
    cutout: bool = False
    """Whether paths of flat art are cut out of those below."""

    def __post_init__(self) -> None:
        check_choice("mode", self.mode, MODES)
        check_count("curves", self.curves, 1, CURVES_MAX)
        check_count("colors", self.colors, 0, COLORS_MAX)
        if self.max_bytes is not None:
            check_count("max_bytes", self.max_bytes, BYTES_MIN, BYTES_MAX)
        for name, most in (("detail", DETAIL_MAX), ("gradients", 1.0)):
            if not 0.0 <= as_float(getattr(self, name)) <= most:
                raise InputError(name, f"must be from 0 to {most:g}", str(getattr(self, name)), "move its slider")
        for name in ("opaque", "cutout"):
            check_flag(name, getattr(self, name))

    @staticmethod
    def read(values: object) -> FitSettings:
        """Return the settings in the JSON object ``values`` of a request.

        Raises:
            InputError: it is no object, or has an unknown name or a wrong value.
        """
        known = {field.name for field in fields(FitSettings)}
        if not isinstance(values, dict) or not values.keys() <= known:
            raise InputError("settings", "must be an object of known settings", str(values)[:80], "reload the page")
        return FitSettings(**values)

    def to_dict(self) -> dict[str, Any]:
        """Return the settings as plain values."""
        return asdict(self)

    @property
    def goal(self) -> Goal:
        """The requirement on the file; false without one."""
        return Goal(max_bytes=self.max_bytes)

    def values(self, mode: str) -> dict[str, Any]:
        """Return the settings of a run in ``mode``, "photo", "flat" or "mono", without those that it does not use."""
        values: dict[str, Any] = {"mode": mode}
        if self.opaque:
            values["opacity"] = "opaque"
        if mode != "mono" and self.colors:
            values["colors"] = self.colors
        if mode == "photo":
            values |= {"gradients": self.gradients}
        else:
            values |= {"detail": max(self.detail, DETAIL_MIN), "cutout": self.cutout and mode == "flat"}
        curves = self.curves if mode == "photo" and not self.goal else None
        return with_curves(values, curves, self.goal)

    def config(self, mode: str) -> FitConfig:
        """Return all settings of a run in ``mode``."""
        return make_config(**self.values(mode))


DETAIL_MIN = 0.01
"""Smallest tolerance in pixels: less keeps the noise of the outlines."""
