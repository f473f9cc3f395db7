"""Commands that fit: their options, files of settings, and help on one screen."""

from __future__ import annotations

import inspect
from copy import copy
from typing import Any

import click
from click.core import ParameterSource

from warpvec.cli.arguments import check_one_stdin, default_out
from warpvec.cli.options import (
    OPTION_NAMES,
    OPTIONS,
    OTHER_DEFAULTS,
    RARE,
    REFUSED,
    SECTIONS,
    SIZE_GOAL,
    file_options,
    requested,
)  # fmt: skip
from warpvec.cli.paths import check_distinct_files
from warpvec.config.kinds import Flag, Kind
from warpvec.config.presets import PRESETS
from warpvec.config.setting import Setting
from warpvec.config.toml_file import read_settings
from warpvec.errors import InputError
from warpvec.files import check_writable
from warpvec.purposes.table import PURPOSES
from warpvec.writers.registry import WRITERS

_INPUTS = {"source": "IN", "drawing": "--from", "resume": "--resume", "config_file": "--config"}
_OUTPUTS = {
    "out": "OUT",
    "checkpoint": "--checkpoint",
    "save_frames": "--save-frames",
    "why": "--why",
    "video": "--video",
    "page": "--report",
    "write_config": "--write-config",
    "cut_once": "--cut-once",
}
"""Parameter of a command -> the file's name on the command line."""


def _picture_beside(params: dict[str, Any]) -> dict[str, str]:
    """Return the PNG that a purpose writes beside OUT, by a name for it."""
    purpose, out = PURPOSES.get(params.get("purpose") or ""), params.get("out")
    has_picture = purpose is not None and purpose.has_picture and out not in (None, "-")
    return {f"the PNG of --for {params['purpose']}": f"{out}.png"} if has_picture else {}


_FULL = "warpvec.full_help"
"""Key in the context of a command whose whole help is asked for."""


class SettingsCommand(click.Command):
    """A command with every option of `OPTIONS`, and with files that hold these options.

    --help shows the presets, the options of daily use and the first paragraph of the docstring, in which
    {suffixes} stands for the kinds of files; --help-all shows all.
    """

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self.help = (self.help or "").replace("{suffixes}", ", ".join(WRITERS))
        other_defaults = OTHER_DEFAULTS.get(self.name or "", {})
        for name, option in OPTIONS.items():
            added = SettingsOption(option, other_defaults.get(name, option.default))
            added.hidden = name in REFUSED.get(self.name or "", ())
            self.params.append(added)
        self.params += _general_options()

    def invoke(self, ctx: click.Context) -> Any:
        """Check the files and call the command, without the options that are dealt with here, --config and --opaque."""
        if "out" in ctx.params and ctx.params["out"] is None:
            ctx.params["out"] = "-" if ctx.params.get("placeholder") else _default_out(ctx.params)
        files = {label: ctx.params.get(name) for name, label in (_INPUTS | _OUTPUTS).items()}
        check_distinct_files(files | _picture_beside(ctx.params))
        check_one_stdin({label: ctx.params.get(name) for name, label in _INPUTS.items()})
        del ctx.params["config_file"]
        if ctx.params["write_config"] is not None:
            check_writable(ctx.params["write_config"], "--write-config")
        if ctx.params["gzip"] and ctx.params[SIZE_GOAL] is None:
            goal = OPTION_NAMES[SIZE_GOAL]
            raise InputError("--gzip", f"must come with {goal}", remedy=f"add {goal} or leave --gzip out")
        _apply_colors(ctx)
        _apply_opaque(ctx)
        return super().invoke(ctx)

    def format_help_text(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the description, or its first paragraph."""
        paragraphs = inspect.cleandoc(self.help or "").split("\n\n")
        formatter.write_paragraph()
        with formatter.indentation():
            formatter.write_text("\n\n".join(paragraphs if _FULL in ctx.meta else paragraphs[:1]))

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the presets and all options, or those of daily use."""
        options = {str(each.name): each for each in self.get_params(ctx) if isinstance(each, click.Option)}
        own = [name for name in options if name not in (*OPTIONS, "preset")]  # the presets have a section
        sections = {"Options": own} | SECTIONS
        if _FULL not in ctx.meta:
            daily = [name for section in SECTIONS.values() for name in section if OPTIONS[name].is_daily]
            sections = {"Settings": daily, "Options": [name for name in own if name not in RARE]}
        with formatter.section("Presets, for --preset NAME"):
            formatter.write_dl([(name, preset.sentence) for name, preset in PRESETS.items()])
        for title, names in sections.items():
            rows = [record for name in names if (record := options[name].get_help_record(ctx))]
            if _FULL not in ctx.meta:
                rows = [(flags.partition(" / ")[0], text) for flags, text in rows]
            if rows:
                with formatter.section(title):
                    formatter.write_dl(rows)


class ValueOf(click.ParamType):
    """A value of the option ``option``, of a `Kind`."""

    def __init__(self, option: str, kind: Kind) -> None:
        self.name, self._option, self._kind = kind.metavar, option, kind

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the value that a text stands for."""
        return self._kind.parse(self._option, value) if isinstance(value, str) else value


class SettingsOption(click.Option):
    """An option of the command line whose former name also works, on the command line and in files.

    Args:
        option: the option.
        default: its default for the help. The option itself defaults to None, so that the preset decides what is not
            given.
    """

    def __init__(self, option: Setting, default: Any) -> None:
        names = [option.flag or option.name, *filter(None, [option.old_name])]
        is_flag, is_switch = isinstance(option.kind, Flag), option.default is None
        value: dict[str, Any] = {"is_flag": True} if is_flag else {
            "type": ValueOf(option.name, option.kind), "metavar": option.metavar or option.kind.metavar
        }  # fmt: skip
        if option.bare is not None:
            value |= {"is_flag": False, "flag_value": option.bare}
        is_silent = default is None or default is False
        shown = option.help if is_silent else f"{option.help} [{'on' if default is True else default}]"
        flags = [_flags(name, is_pair=is_flag and not is_switch) for name in names]
        super().__init__([option.name, *flags], default=None, help=shown, **value)

    def get_help_record(self, ctx: click.Context) -> tuple[str, str] | None:
        """Return the option as the help shows it, under its present name."""
        shown = copy(self)
        shown.opts, shown.secondary_opts = self.opts[:1], self.secondary_opts[:1]
        return click.Option.get_help_record(shown, ctx)


def _flags(name: str, *, is_pair: bool) -> str:
    """Return the flag of the option ``name``; of a pair also the opposite flag."""
    word = name.replace("_", "-")
    return f"--{word}/--no-{word}" if is_pair else f"--{word}"


def _general_options() -> list[click.Option]:
    return [
        click.Option(
            ["--config", "config_file"], metavar="FILE", is_eager=True, callback=_take_file,
            help="Settings from a TOML file; options override them.",
        ),
        click.Option(["--write-config"], metavar="FILE", help="Write the settings of this run to a TOML file."),
        click.Option(
            ["--help-all"], is_flag=True, is_eager=True, expose_value=False, callback=_show_full_help,
            help="Show all options and exit.",
        ),
    ]  # fmt: skip


def _show_full_help(ctx: click.Context, _: click.Parameter, value: bool) -> None:
    if value and not ctx.resilient_parsing:
        ctx.meta[_FULL] = True
        click.echo(ctx.get_help())
        ctx.exit()


def _take_file(ctx: click.Context, _: click.Parameter, path: str | None) -> str | None:
    """Make the settings in the file ``path`` the defaults of the command."""
    if path is not None:
        names = _names(ctx.command)
        switches = {option.name for option in ctx.command.params if isinstance(option, click.Option) and option.is_flag}
        flags = {name for name, parameter in names.items() if parameter in switches}
        ctx.default_map = {names[name]: value for name, value in read_settings(path, names, flags).items()}
    return path


def _names(command: click.Command) -> dict[str, str]:
    """Return the options of ``command`` that a file may hold: name on the command line -> name of the parameter."""
    options = [option for option in command.params if isinstance(option, click.Option)]
    flags = {flag: str(option.name) for option in options for flag in option.opts if flag.startswith("--")}
    named = {flag[2:].replace("-", "_"): name for flag, name in flags.items()}
    return {flag: name for flag, name in named.items() if name not in ("config_file", "write_config", "help_all")}


def _default_out(options: dict[str, Any]) -> str:
    """Return the path of the drawing of a command without OUT.

    Raises:
        InputError: as `default_out`, but a wrong value among the ``options`` comes first: it would be named next.
    """
    try:
        return default_out(options["source"])
    except InputError:
        requested(options)
        file_options(options)
        raise


def _apply_colors(ctx: click.Context) -> None:
    """Drop the opacity of a file if --colors, which makes paths opaque, is on the command line.

    A file written by --write-config always states an opacity, which nobody may have asked for.
    """
    if ctx.params["colors"] and _overrides(ctx, "colors", "opacity"):
        ctx.params["opacity"] = None


def _apply_opaque(ctx: click.Context) -> None:
    """Replace --opaque by --opacity opaque.

    They may differ only if one is on the command line and the other in the file; the command line wins.
    """
    if not ctx.params.pop("opaque") or _overrides(ctx, "opacity", "opaque"):
        return
    opacity = ctx.params["opacity"]
    if opacity not in (None, "opaque") and not _overrides(ctx, "opaque", "opacity"):
        rule = f"must not be given with --opacity {opacity}"
        raise InputError("--opaque", rule, remedy="leave one of them out")
    ctx.params["opacity"] = "opaque"


def _overrides(ctx: click.Context, name: str, other: str) -> bool:
    """Return whether option ``name`` is on the command line and ``other`` only in the file."""
    return (
        ctx.get_parameter_source(name) is ParameterSource.COMMANDLINE
        and ctx.get_parameter_source(other) is ParameterSource.DEFAULT_MAP
    )
