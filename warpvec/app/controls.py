"""The controls of the page, from the tables of settings and goals: their elements, and what its scripts need."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from html import escape
from typing import Any

from warpvec.config.control import Control, Step
from warpvec.config.fit_config import GOAL, SETTINGS
from warpvec.config.kinds import Kind
from warpvec.config.setting import ANY_MODE
from warpvec.errors import InputError
from warpvec.goals.registry import QUANTITIES


@dataclass(frozen=True)
class Offer:
    """A setting or a goal that the page offers.

    Attributes:
        name: its name in requests.
        control: its control.
        kind: the kind of its values.
        default: its value unless it is given.
        modes: modes in which the page sends it.
    """

    name: str
    control: Control
    kind: Kind
    default: Any = None
    modes: tuple[str, ...] = ANY_MODE

    def checked(self, value: object) -> Any:
        """Return ``value`` in its normal form.

        Raises:
            InputError: it has the wrong type, is out of the range of the setting, above that of the page, or no number
                that the page does not offer.
        """
        if value is None and self.default is None:
            return None
        value = self.kind.check(self.name, value)
        steps: list[Any] = [step.value for step in self.control.steps]
        if self.control.form != "slider" or isinstance(value, str):
            if value not in steps:
                raise InputError(self.name, "must be a value that the page offers", str(value), "reload the page")
        elif value > (most := max(step for step in steps if step is not None)):
            raise InputError(self.name, f"must be at most {most} on the page", str(value), "move its slider")
        return value

    @property
    def start(self) -> int:
        """Place of the step at which the control stands at first."""
        values = [step.value for step in self.control.steps]
        return values.index(self.default) if self.default in values else 0


def _offers() -> dict[str, Offer]:
    """Return the offers by name, in the order of the help: goals follow the settings of their section."""
    sections = dict.fromkeys(each.section for each in SETTINGS.values())
    found: list[Offer] = []
    for section in sections:
        for each in SETTINGS.values():
            if each.page and each.section == section:
                modes = each.page.modes or each.modes
                found.append(Offer(each.name, each.page, each.kind, each.default, modes))
        if section == GOAL:
            found += [Offer(each.name, each.page, each.kind) for each in QUANTITIES.values() if each.page]
    return {offer.name: offer for offer in found}


OFFERS = _offers()
"""Every setting and goal that the page offers, by its name in requests."""


def controls_markup() -> str:
    """Return the elements of the controls: choices, sliders, and boxes to tick."""
    own = [offer for offer in OFFERS.values() if offer.control.moved_by is None]
    makers: dict[str, Callable[[Offer], str]] = {"choice": _choice, "slider": _slider, "tick": _tick}
    return "".join(make(offer) for form, make in makers.items() for offer in own if offer.control.form == form)


def controls_data() -> str:
    """Return JSON for the page's script `controls.js`: what each control sends and shows at each of its steps."""
    controls = [_control_data(offer) for offer in OFFERS.values() if offer.control.moved_by is None]
    return json.dumps(controls).replace("<", "\\u003c")


def _control_data(offer: Offer) -> dict[str, Any]:
    moved = [offer, *(other for other in OFFERS.values() if other.control.moved_by == offer.name)]
    return {
        "name": offer.name,
        "form": offer.control.form,
        "start": offer.start,
        "overrides": offer.control.overrides,
        "settings": [
            {
                "name": each.name,
                "modes": each.modes,
                "values": [step.value for step in each.control.steps],
                "texts": [step.text for step in each.control.steps],
            }
            for each in moved
        ],
    }


def _choice(offer: Offer) -> str:
    radios = "".join(_radio(offer, step, place == offer.start) for place, step in enumerate(offer.control.steps))
    name, label = f"set-{offer.name}", escape(offer.control.label)
    return f'<div id="{name}" class="choice across" role="radiogroup" aria-label="{label}">{radios}</div>\n'


def _radio(offer: Offer, step: Step, is_checked: bool) -> str:
    checked = " checked" if is_checked else ""
    button = f'<input type="radio" name="set-{offer.name}" value="{escape(str(step.value))}"{checked}>'
    return f'<label title="{escape(step.tooltip)}">{button}<span>{escape(step.text)}</span></label>'


def _slider(offer: Offer) -> str:
    name, control = f"set-{offer.name}", offer.control
    most = len(control.steps) - 1
    return f"""<div class="field">
<label for="{name}" title="{escape(control.tooltip)}">{escape(control.label)}</label>
<input id="{name}" type="range" min="0" max="{most}" step="1" value="{offer.start}">
<output id="{name}-text" for="{name}"></output>
</div>
"""


def _tick(offer: Offer) -> str:
    checked = " checked" if offer.start else ""
    box = f'<input id="set-{offer.name}" type="checkbox"{checked}>'
    label = f'<label title="{escape(offer.control.tooltip)}">{box} {escape(offer.control.label)}</label>'
    return f'<p class="tick">{label}</p>\n'
