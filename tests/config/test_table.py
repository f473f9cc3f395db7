"""The table of settings: every setting is stated once, and reaches Python, the command line, files and the page."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from typing import Any

import click
import pytest
from click.testing import CliRunner
from commands import invoke, write_photo

import warpvec
from warpvec import api
from warpvec.cli.settings_command import SettingsOption
from warpvec.config import table
from warpvec.config.fit_config import SETTINGS, FitConfig
from warpvec.config.kinds import Choice, Flag, Kind, Positive, Real, Whole
from warpvec.config.presets import make_config
from warpvec.config.setting import ANY_MODE, Setting
from warpvec.modes import choice
from warpvec.modes.request import Request

NEEDS: dict[str, dict[str, Any]] = {
    "path_model": {"renderer": "splat"},
    "policy": {"renderer": "splat", "path_model": "sides"},
    "gradients": {"curves": 99},
}
"""Setting -> others that its value below needs."""

CUSTOM: dict[str, Any] = {
    "soft": "7", "threshold": "99", "line_width": "2.5", "blur": "1.5", "grid": "24",
    "curves": 77, "gradients": 0.25, "palette": "#112233", "device": "cpu", "time_budget": 7.5,
    "growth": 3.0,
}  # fmt: skip
"""Values of settings whose kind does not tell one."""


def _other(each: Setting) -> Any:
    """Return an allowed value that is not the default."""
    if each.name in CUSTOM:
        return CUSTOM[each.name]
    kind: Kind = each.kind
    if isinstance(kind, Flag):
        return not each.default
    if isinstance(kind, Choice):
        return next(name for name in reversed(kind.names) if name != each.default)
    if isinstance(kind, Whole):
        return kind.low + 1 if kind.low + 1 != each.default else kind.low + 2
    assert isinstance(kind, Real | Positive)
    return each.default / 2 if each.default else 0.125


class Seen(Exception):
    """Raised where the fit would start."""


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[FitConfig]:
    """Return the list of settings that runs ask for. No fit is made."""
    found: list[FitConfig] = []

    def record(request: Request, *_: Any) -> None:
        found.append(request.settings)
        raise Seen

    monkeypatch.setattr(choice, "draw_picture", record)
    monkeypatch.setattr(api, "draw_picture", record)
    return found


def test_the_page_of_the_table_is_up_to_date() -> None:
    page = Path(table.__file__).with_name("README.md").read_text(encoding="utf-8")
    assert page == table.settings_table(), "run python -m warpvec.config.table > warpvec/config/README.md"


def test_every_setting_is_a_field_with_a_help_and_modes() -> None:
    assert [each.name for each in fields(FitConfig)] == list(SETTINGS)
    for each in SETTINGS.values():
        assert each.help.endswith(".") and each.modes and {*each.modes} <= {*ANY_MODE}, each.name
        assert each.kind.check(each.name, each.default) == each.default


@pytest.mark.parametrize("name", SETTINGS)
def test_every_setting_is_reached_by_python_an_option_and_a_file(
    name: str, tmp_path: Path, asked: list[FitConfig]
) -> None:
    value, needs, photo = _other(SETTINGS[name]), NEEDS.get(name, {}), write_photo(tmp_path)
    with pytest.raises(Seen):
        warpvec.vectorize(photo, **needs, **{name: value})
    invoke("run", photo, tmp_path / "out.svg", *_options(needs), *_options({name: value}))
    settings = tmp_path / "settings.toml"
    settings.write_text(f"{name} = {str(value).lower() if isinstance(value, bool) else repr(value)}\n")
    invoke("run", photo, tmp_path / "out.svg", *_options(needs), "--config", settings)
    assert asked == [make_config(**needs, **{name: value})] * 3
    assert getattr(asked[0], name) == value != SETTINGS[name].default


def _options(values: dict[str, Any]) -> list[str]:
    words: list[str] = []
    for name, value in values.items():
        flag = name.replace("_", "-")
        words += [f"--{flag}" if value else f"--no-{flag}"] if isinstance(value, bool) else [f"--{flag}", str(value)]
    return words


# Former names

OLD = {each.old_name: name for name, each in SETTINGS.items() if each.old_name is not None}


def test_a_former_name_still_works_and_the_help_leaves_it_out(tmp_path: Path, asked: list[FitConfig]) -> None:
    photo, settings = write_photo(tmp_path), tmp_path / "settings.toml"
    assert OLD == {"flat": "one_generation"}
    settings.write_text("flat = true")
    with pytest.raises(Seen):
        warpvec.vectorize(photo, flat=True)
    invoke("run", photo, tmp_path / "out.svg", "--flat")
    invoke("run", photo, tmp_path / "out.svg", "--config", settings)
    assert [config.one_generation for config in asked] == [True] * 3
    text = invoke("run", "--help-all").stdout
    assert "--one-generation / --no-one-generation" in text and "--flat" not in text


@pytest.mark.parametrize("stated", ["flat", "one-generation"])
@pytest.mark.parametrize("given", ["flat", "one-generation"])
def test_either_name_on_the_command_line_overrides_either_name_in_a_file(
    stated: str, given: str, tmp_path: Path, asked: list[FitConfig]
) -> None:
    photo, settings = write_photo(tmp_path), tmp_path / "settings.toml"
    for value in (True, False):
        settings.write_text(f"{stated} = {str(not value).lower()}")
        option = f"--{given}" if value else f"--no-{given}"
        invoke("run", photo, tmp_path / "out.svg", "--config", settings, option)
    assert [config.one_generation for config in asked] == [True, False]


def test_an_option_of_any_kind_can_have_a_former_name() -> None:
    seen: list[dict[str, Any]] = []
    option = Setting("paths", Whole(1, 9), None, "Number of paths.", "Result", old_name="curves")
    command = click.Command("draw", params=[SettingsOption(option, 3)], callback=lambda **given: seen.append(given))
    for words in (["--curves", "5"], ["--paths", "6"], ["--curves", "5", "--paths", "7"], []):
        assert CliRunner().invoke(command, words).exit_code == 0
    assert seen == [{"paths": 5}, {"paths": 6}, {"paths": 7}, {"paths": None}]
    text = CliRunner().invoke(command, ["--help"]).stdout
    assert "--paths N" in text and "[3]" in text and "--curves" not in text
