"""Every setting of a fit, and what is asked of its file, as options of the command line, in sections."""

from __future__ import annotations

import re
from dataclasses import Field, fields
from pathlib import Path
from typing import Any

import click
from click.core import ParameterSource

from warpvec.cli.paths import check_places
from warpvec.config.fit_config import FitConfig
from warpvec.config.presets import PRESET_SENTENCES, make_config
from warpvec.config.toml_file import read_settings
from warpvec.errors import InputError
from warpvec.files import check_writable
from warpvec.vectorization.goal import Goal, parse_size, with_curves

GOALS = {
    "max_bytes": "At most these bytes, 50000 or 80k: as many paths as they hold.",
    "gzip": "Count them after gzip; so it is for .svgz.",
    "target_psnr": "As many paths as these decibels take, measured on the file.",
}
"""What can be asked of the file -> its line in the help."""

SETTINGS = {
    "The result": {
        "curves": "Closed paths in the result, or auto; with a goal, the most it may take.",
        "path_model": "A path is cubics in a loop (segments) or two curves with common ends (sides, with splat).",
        "segments": "Cubics per path of the model segments.",
        "degree": "Degree of the curves of the model sides, 2 to 12.",
        "precision": "Decimals of the coordinates, 0 to 6.",
        "opacity": "Of each path: free, or opaque for 1.",
        "colors": "Fills come from a palette of so many colours, which is fitted; 0 for any.",
        "palette": "Fills come from these colours, '#123,#a0b1c2', or from those named in a file.",
        "min_area": "No path of less than these square pixels.",
        "lod": "Each level of detail, with those below it, is fitted as a picture of its own.",
        "backdrop": "Canvas colour: fitted (learned) or white.",
        "fit_size": "Longest side in pixels that the fit works on; the SVG keeps the photo's units.",
    },
    "The run": {
        "iterations": "Optimization steps.",
        "coarse_until": "Share of the iterations in which the fit sees the photo at half size.",
        "time_budget": "At most these seconds for the optimization; the schedule is shortened to fit.",
        "seed": "Start of the random numbers; equal seeds give equal files.",
        "renderer": "exact (areas, as SVG viewers draw them) or splat (the paper's Gaussians).",
        "device": "auto, cpu, cuda or cuda:K.",
        "threads": "CPU threads; the result does not depend on them.",
    },
    "Renderer splat": {
        "samples": "Gaussians along each side and line of a path.",
        "lines": "Lines of Gaussians between the sides of a path.",
        "interior_gradient": "Gaussians inside move the control points too.",
        "covariance_gradient": "So do their sizes and directions.",
    },
    "Population": {
        "policy": "When paths come and go: scaffolding (Algorithm 1 of the paper) or replacement (Bezier Splatting's).",
        "z_order": "What is on top: creation (the newest) or area (the smallest).",
    },
    "Policy scaffolding: Algorithm 1 of the paper": {
        "initial_curves": "Paths at the start, N0.",
        "growth": "Factor of the population at an inflation, r_num, at least 1.01.",
        "inflation_gap": "Iterations between inflations, dT.",
        "shorten_gap": "Shorten dT, and the replacement's gap, in runs that are short for it.",
        "initial_radius": "First radius in units of half the longer side.",
        "radius_decay": "Radius of a generation over that of the one before, r_rad.",
        "prune_opacity": "Paths of at most this opacity are removed at an inflation.",
        "compensate": "Replace what was pruned.",
        "flat": "All paths at once, no generations.",
    },
    "Policy scaffolding: recycling of the least important paths": {
        "recycle_gap": "Iterations between recyclings; 0 for none.",
        "recycle_share": "Share of the paths that one recycling replaces.",
        "recycle_until": "Last recycling, as a share of the iterations.",
    },
    "Policy replacement": {
        "replace_gap": "Iterations from a removal to the addition of as many paths, and to the next removal.",
    },
    "Optimizer": {
        "lr_points": "Learning rate of control points, in units of half the longer side.",
        "lr_color": "Learning rate of colours.",
        "lr_opacity": "Learning rate of opacities.",
        "lr_scale": "Multiplies every learning rate.",
        "lr_decay": "cosine, constant or steps (Bezier Splatting's).",
        "lr_final": "Last learning rate over the first under cosine decay.",
        "color_parameter": "Colours are optimized as such (direct) or through a sigmoid (logit).",
    },
    "Loss": {
        "opacity_weight": "Weight of the term that wants opaque paths.",
        "xing_weight": "Weight of the term that keeps a segment's handles from crossing.",
        "bezier_weight": "Weight of the Bezier regularizer.",
    },
}
"""Section of the help -> field of FitConfig -> its line there."""

_PLACES = {
    "source": "IN",
    "drawing": "--from",
    "resume": "--resume",
    "config_file": "--config",
    "out": "OUT",
    "checkpoint": "--checkpoint",
    "video": "--video",
    "page": "--report",
    "write_config": "--write-config",
}
"""Parameter of a command -> what the user calls the file; those that are read come first."""

OPTION_NAMES = {
    name: "--" + name.replace("_", "-")
    for name in ("preset", "background", *GOALS, *(field.name for field in fields(FitConfig)), "levels", "history")
} | {"checkpoint": "--resume", "photo": "--image"}
"""Name of an argument in Python -> the option of the command line."""

_TYPES: dict[str, type] = {"int": int, "float": float, "str": str}
_HEX_COLOR = re.compile(r"#(?:[0-9a-fA-F]{6}|[0-9a-fA-F]{3})\b")


class SettingsCommand(click.Command):
    """A command with an option for each field of FitConfig and Goal, in sections, and files that hold them."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        by_name = {field.name: field for field in fields(FitConfig)}
        for section in SETTINGS.values():
            self.params += [_setting_option(by_name[name], text) for name, text in section.items()]
        self.params += [*_goal_options(), *_file_options()]

    def invoke(self, ctx: click.Context) -> Any:
        """Calls the command with its parameters but for the two that are settled here, --config and --opaque."""
        check_places({label: ctx.params.get(name) for name, label in _PLACES.items()})
        del ctx.params["config_file"]
        if ctx.params["write_config"] is not None:
            check_writable(ctx.params["write_config"], "--write-config")
        if ctx.params["gzip"] and ctx.params["max_bytes"] is None:
            raise InputError("--gzip must come with --max-bytes, which counts the bytes; add it or leave --gzip out")
        _settle_opacity(ctx)
        return super().invoke(ctx)

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        sections = {"The goal": list(GOALS), **SETTINGS}
        placed = {name for section in sections.values() for name in section}
        options = {option.name: option for option in self.get_params(ctx) if isinstance(option, click.Option)}
        for title, names in {"Options": [name for name in options if name not in placed], **sections}.items():
            with formatter.section(title):
                records = (options[name].get_help_record(ctx) for name in names)
                formatter.write_dl([record for record in records if record])
        with formatter.section("Presets"):
            formatter.write_dl(list(PRESET_SENTENCES.items()))


def requested(preset: str, options: dict[str, Any]) -> tuple[FitConfig, Goal]:
    """The settings and the goal that the options of a `SettingsCommand` say; None is what was not given.

    Raises:
        InputError: a value is out of its range, or two do not go together.
    """
    given = {name: value for name, value in options.items() if value is not None}
    curves = given.pop("curves", None)
    goal = Goal(**{name: given.pop(name) for name in GOALS if name in given}, auto=curves == "auto")
    config = make_config(preset, **with_curves(given, curves, goal))
    if goal and config.policy != "scaffolding":
        raise InputError(f"policy must be scaffolding to meet a goal, got {config.policy!r}; give scaffolding")
    return config, goal


def stated(preset: str, background: str | None, options: dict[str, Any], config: FitConfig) -> dict[str, Any]:
    """Every setting, goal and input of a command by name, those of the preset too, without what is not set.

    Args:
        preset, background, options: as they were given.
        config: what they led to.
    """
    found = {"preset": preset, "background": background, **config.to_dict()}
    found |= {name: options[name] for name in GOALS} | {"curves": options["curves"] or config.curves}
    if options["curves"] is None and any(options[name] for name in GOALS):
        del found["curves"]
    return {name: value for name, value in found.items() if value is not None}


def _setting_option(field: Field[Any], text: str) -> click.Option:
    """The option of one setting. Its default is None, so that what is not given falls to the preset."""
    flag = field.name.replace("_", "-")
    shown = "" if field.default is None else f" [{field.default}]"
    if field.type == "bool":
        return click.Option([f"--{flag}/--no-{flag}"], default=None, help=text + shown)
    special = {"curves": _Curves(), "palette": _Palette()}
    kind = special.get(field.name) or _TYPES[str(field.type).removesuffix(" | None")]
    return click.Option([f"--{flag}"], type=kind, default=None, help=text + shown)


def _goal_options() -> list[click.Option]:
    return [
        click.Option(["--max-bytes"], type=_Size(), help=GOALS["max_bytes"]),
        click.Option(["--gzip"], is_flag=True, default=None, help=GOALS["gzip"]),
        click.Option(["--target-psnr"], type=float, help=GOALS["target_psnr"]),
    ]


def _file_options() -> list[click.Option]:
    return [
        click.Option(["--opaque"], is_flag=True, help="Short for --opacity opaque."),
        click.Option(
            ["--config", "config_file"], metavar="FILE", is_eager=True, callback=_take_file,
            help="TOML file of options by name; the command line goes before it.",
        ),
        click.Option(["--write-config"], metavar="FILE", help="Write all settings of this command to a TOML file."),
    ]  # fmt: skip


def _take_file(ctx: click.Context, _: click.Parameter, path: str | None) -> str | None:
    if path is not None:
        found = read_settings(path, _names(ctx.command))
        ctx.default_map = {_names(ctx.command)[name]: value for name, value in found.items()}
    return path


def _names(command: click.Command) -> dict[str, str]:
    """The options of ``command`` that a file may hold: each by the name it has on the command line."""
    options = [option for option in command.params if isinstance(option, click.Option)]
    flags = {flag: str(option.name) for option in options for flag in option.opts if flag.startswith("--")}
    named = {flag[2:].replace("-", "_"): name for flag, name in flags.items()}
    return {flag: name for flag, name in named.items() if name not in ("config_file", "write_config")}


def _settle_opacity(ctx: click.Context) -> None:
    """--opaque becomes an opacity, or gives way to one on the command line where itself is in the file."""
    if not ctx.params.pop("opaque") or _goes_before(ctx, "opacity", "opaque"):
        return
    if ctx.params["opacity"] not in (None, "opaque") and not _goes_before(ctx, "opaque", "opacity"):
        rule = f"--opaque must stand without --opacity {ctx.params['opacity']}"
        raise InputError(f"{rule}; leave one of them out")
    ctx.params["opacity"] = "opaque"


def _goes_before(ctx: click.Context, name: str, other: str) -> bool:
    """Whether option ``name`` stands on the command line, and ``other`` only in the file."""
    return (
        ctx.get_parameter_source(name) is ParameterSource.COMMANDLINE
        and ctx.get_parameter_source(other) is ParameterSource.DEFAULT_MAP
    )


class _Curves(click.ParamType):
    name = "integer|auto"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if value == "auto":
            return value
        try:
            return int(value)
        except ValueError:
            self.fail(f"{value!r} is not a valid integer, nor auto", param, ctx)


class _Size(click.ParamType):
    name = "size"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        return parse_size(value) if isinstance(value, str) else value


class _Palette(click.ParamType):
    name = "colors|file"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        return value if value.startswith("#") else ",".join(_colors_in(value))


def _colors_in(path: str) -> list[str]:
    """Every "#123" or "#a0b1c2" in a text file."""
    try:
        found = _HEX_COLOR.findall(Path(path).read_text(encoding="utf-8", errors="replace"))
    except (OSError, ValueError) as error:
        raise InputError(f"palette must be colours or a file of them, got {path!r} ({error}); check it") from error
    if not found:
        raise InputError(f"palette must name colours such as #a0b1c2, got {path!r} without any; add some")
    return found
