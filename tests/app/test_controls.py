"""The controls of the page come from the tables of settings and goals, as do the limits of what it sends."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import pytest

from warpvec.app import controls, settings
from warpvec.app.controls import OFFERS, Offer
from warpvec.app.page import page_text
from warpvec.app.settings import FitSettings
from warpvec.config.control import slider
from warpvec.config.fit_config import SETTINGS, FitConfig
from warpvec.errors import InputError
from warpvec.goals.registry import QUANTITIES
from warpvec.viewer.page import PAGE_PHOTO_SIDE
from warpvec.writers.png import SIDE_MAX


@pytest.mark.parametrize("offer", OFFERS.values(), ids=OFFERS)
def test_every_step_is_allowed_and_the_first_is_the_default(offer: Offer) -> None:
    values = [step.value for step in offer.control.steps]
    assert [offer.checked(value) for value in values] == values
    assert len(set(map(str, values))) == len(values) > 1
    # The gradients of a photo are none by default, which its slider shows as 0 %.
    assert values[offer.start] == (0.0 if offer.name == "gradients" else offer.default)


def test_sliders_that_move_together_have_as_many_steps() -> None:
    for offer in OFFERS.values():
        if offer.control.moved_by is not None:
            assert len(offer.control.steps) == len(OFFERS[offer.control.moved_by].control.steps)
        assert offer.control.overrides is None or offer.control.overrides in OFFERS


def test_a_setting_is_on_the_page_by_its_entry(monkeypatch: pytest.MonkeyPatch) -> None:
    control = slider("Decimals", "Decimals of <coordinates>", (0, 1, 2, 3), str)
    precision = replace(SETTINGS["precision"], page=control)
    monkeypatch.setattr(controls, "SETTINGS", {**SETTINGS, "precision": precision})
    offers = controls._offers()
    monkeypatch.setattr(controls, "OFFERS", offers)
    monkeypatch.setattr(settings, "OFFERS", offers)
    markup = controls.controls_markup()
    assert '<label for="set-precision" title="Decimals of &lt;coordinates&gt;">Decimals</label>' in markup
    assert '<input id="set-precision" type="range" min="0" max="3" step="1" value="2">' in markup
    (data,) = (each for each in json.loads(controls.controls_data()) if each["name"] == "precision")
    assert (data["start"], data["settings"][0]["values"]) == (2, [0, 1, 2, 3])
    assert FitSettings({"precision": 3}).config("photo").precision == 3


def test_settings_reach_only_the_modes_that_use_them() -> None:
    given = FitSettings({"curves": 64, "detail": 0.4, "colors": 6, "cutout": True, "opacity": "opaque"})
    assert given.given("photo") == {"mode": "photo", "curves": 64, "colors": 6, "opacity": "opaque"}
    assert given.given("flat") == {"mode": "flat", "detail": 0.4, "colors": 6, "cutout": True, "opacity": "opaque"}
    assert given.given("mono") == {"mode": "mono", "detail": 0.4, "opacity": "opaque"}
    assert FitSettings({}).config("photo") == FitConfig(mode="photo")
    assert FitSettings({"max_bytes": 2000}).given("photo").keys() == {"mode", "curves", "minify"}


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"curves": 4097}, "curves must be at most 4096 on the page"),
        ({"curves": True}, "curves must be a whole number"),
        ({"colors": 65}, "colors must be at most 64"),
        ({"max_bytes": 1_000_001}, "max_bytes must be at most 1000000"),
        ({"detail": 0}, "detail must be above 0"),
        ({"detail": None}, "detail"),
        ({"gradients": 1.5}, "gradients must be at most 1"),
        ({"gradients": "auto"}, "gradients must be a value that the page offers"),
        ({"opacity": "common"}, "opacity must be a value that the page offers"),
        ({"cutout": 1}, "cutout"),
        ({"threads": 1}, "settings must be an object of known settings"),
        ([], "settings must be an object of known settings"),
    ],
)
def test_values_that_the_page_does_not_offer_are_refused(values: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        FitSettings(values)


def test_limits_of_the_page_are_those_of_the_program() -> None:
    text, _ = page_text("")
    assert f'<input id="png-width" type="number" min="1" max="{SIDE_MAX}"' in text
    assert f'data-photo-side="{PAGE_PHOTO_SIDE}"' in text
    assert "<!--" not in text.partition('<script type="application/json"')[0]


def test_goals_with_a_control_are_goals_of_the_run() -> None:
    assert {name for name in OFFERS if name in QUANTITIES} == {"max_bytes"}
    assert FitSettings({"max_bytes": 5000}).goal.bounds == {"max_bytes": 5000}
    assert not FitSettings({}).goal
