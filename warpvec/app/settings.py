"""The settings that the page sends with a picture: checked, and turned into those of a run."""

from __future__ import annotations

from typing import Any

from warpvec.app.controls import OFFERS
from warpvec.config.fit_config import FitConfig
from warpvec.config.presets import make_config
from warpvec.errors import InputError
from warpvec.goals.goal import Goal, make_goal, with_curves
from warpvec.goals.registry import QUANTITIES


class FitSettings:
    """The settings of the page.

    Args:
        given: settings and goals that the page offers, by name; see `warpvec.app.controls.OFFERS`.

    Raises:
        InputError: it is no object, or has a setting that there is not, or one of the wrong type or out of range.
    """

    def __init__(self, given: object) -> None:
        if not isinstance(given, dict) or not given.keys() <= OFFERS.keys():
            raise InputError("settings", "must be an object of known settings", str(given)[:80], "reload the page")
        self.values = {name: offer.checked(given.get(name, offer.default)) for name, offer in OFFERS.items()}

    @property
    def mode(self) -> str:
        """The mode that is asked for: "auto", "photo", "flat" or "mono"."""
        return str(self.values["mode"])

    @property
    def goal(self) -> Goal:
        """The requirement on the file; false without one."""
        return make_goal(**{name: value for name, value in self.values.items() if name in QUANTITIES})

    def given(self, mode: str) -> dict[str, Any]:
        """Return the settings of a run in ``mode``, "photo", "flat" or "mono", that are not the usual ones."""
        used = {
            name: self.values[name]
            for name, offer in OFFERS.items()
            if name not in QUANTITIES and mode in offer.modes and self.values[name] != offer.default
        }
        curves = used.pop("curves", None)
        return with_curves({**used, "mode": mode}, None if self.goal else curves, self.goal)

    def config(self, mode: str) -> FitConfig:
        """Return all settings of a run in ``mode``."""
        return make_config(**self.given(mode))
