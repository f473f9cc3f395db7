"""Presets, and settings that replace theirs."""

from __future__ import annotations

import pytest

from warpvec.config.fit_config import FitConfig
from warpvec.config.presets import PRESETS, Preset, make_config
from warpvec.errors import InputError


@pytest.mark.parametrize("preset", PRESETS)
def test_presets_are_valid_and_have_a_sentence(preset: str) -> None:
    make_config(preset)
    sentence = PRESETS[preset].sentence
    assert sentence.endswith(".") and sentence[0].isupper()


def test_a_number_of_colors_makes_paths_opaque_unless_opacity_is_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(PRESETS, "soft", Preset("Translucent.", {"opacity": "free"}))
    for preset in ("default", "paper", "soft"):
        assert make_config(preset, colors=3).opacity == "opaque"
        assert make_config(preset, colors=3, opacity="free").opacity == "free"
        assert make_config(preset, colors=0).opacity == "free"
    with pytest.raises(InputError, match="^colors must be"):
        make_config(colors="3")


def test_settings_override_the_preset() -> None:
    config = make_config("draft", iterations=7, curves=3)
    assert (config.iterations, config.curves) == (7, 3)
    assert config.inflation_gap != FitConfig().inflation_gap


def test_unknown_names_are_refused() -> None:
    with pytest.raises(InputError, match="preset must be one of .*default.*, got 'fast'"):
        make_config("fast")
    with pytest.raises(InputError, match="preset must be one of .*, got \\[\\]"):
        make_config([])  # type: ignore[arg-type]
    with pytest.raises(InputError, match="curvse is not a setting"):
        make_config(curvse=3)
