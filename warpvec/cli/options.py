"""The table of the options that set up a fit, and the settings and goal that they lead to."""

from __future__ import annotations

from dataclasses import fields
from typing import Any, NamedTuple

from warpvec.config.fit_config import FitConfig
from warpvec.config.presets import make_config, settings_of_mode
from warpvec.config.rules import require_scaffolding
from warpvec.vectorization.file_options import FileOptions
from warpvec.vectorization.goal import Goal, with_curves, with_given_segments


class Setting(NamedTuple):
    """The help of one option."""

    help: str
    daily: bool = False
    """True if --help shows the option; --help-all shows every option."""
    metavar: str | None = None
    """Placeholder of the value; None for that of its type."""


DAILY = True

SETTINGS: dict[str, dict[str, Setting]] = {
    "Kind of picture": {
        "mode": Setting("Kind: auto, photo, flat (logos, icons) or mono.", DAILY),
        "detail": Setting("Drawings: how far outlines may move, in pixels.", DAILY),
        "cutout": Setting("Drawings: no overlaps, for cutters and plotters.", DAILY),
        "threshold": Setting(
            "Mode mono: level below which a pixel is dark, 0 to 255, or auto (Otsu's).", metavar="auto|N"
        ),
    },
    "Goal": {
        "curves": Setting(
            "Number of paths; auto for as many as pay. With a goal, and in drawings: the most to use.", DAILY, "N|auto"
        ),
        "max_bytes": Setting("Largest file size (50000, 80k); the best that fits.", DAILY, "SIZE"),
        "target_psnr": Setting("Least that reaches this PSNR (25 rough, 35 close).", DAILY, "DB"),
        "gzip": Setting("Count --max-bytes after gzip (implied by .svgz).", DAILY),
    },
    "Result": {
        "colors": Setting("Most colours, 0 for any; makes paths opaque.", DAILY),
        "palette": Setting(
            "Use only these colours (red,#a0b1c2) or those in a file.",
            DAILY,
            "COLORS",
        ),
        "opacity": Setting("Opacity of the paths: free, common (the same for all), or opaque.", metavar="NAME"),
        "opaque": Setting("Make every path opaque (--opacity opaque).", DAILY),
        "gradients": Setting("Paths that get a gradient: 40, 0.5 (half), auto or 0.", DAILY, "X|auto"),
        "min_area": Setting("Leave out paths smaller than X square pixels.", DAILY),
        "lod": Setting("Let the lowest K layers alone make a good picture, for every K."),
        "size": Setting("Width such as 90mm, also in, cm, pt, px or %.", DAILY, "WIDTH"),
        "trim": Setting("Cut the paths off at the edges of the canvas.", DAILY),
        "no_metadata": Setting("Leave the settings (1 KB) out of the file."),
        "minify": Setting("Shortest file; on for --max-bytes unless --no-minify.", DAILY),
        "grid": Setting("Units per pixel of a minified file; 0 for as many as needed."),
        "precision": Setting("Decimals of the coordinates, 0 to 6."),
        "path_model": Setting("Shape of a path: segments (a loop of cubics) or sides (two curves, for splat)."),
        "segments": Setting("Cubics per path in the mean.", DAILY),
        "fixed_segments": Setting("Give each path exactly --segments cubics."),
        "closing_line": Setting("Close every path by a straight line, after its cubics."),
        "degree": Setting("Degree of the curves, 2 to 12, for --path-model sides."),
        "backdrop": Setting("Canvas colour: learned (fitted) or white."),
    },
    "Run": {
        "iterations": Setting("Optimization steps; more look better.", DAILY),
        "time_budget": Setting("Longest time for the optimization, S seconds.", DAILY, "S"),
        "fit_size": Setting("Longest side in pixels of the image that is fitted."),
        "device": Setting("Processor: auto, cpu, cuda or cuda:K.", DAILY),
        "threads": Setting("CPU threads; the result does not depend on them.", DAILY),
        "seed": Setting("Start of the random numbers; equal seeds give equal files."),
        "renderer": Setting("exact (areas, as SVG viewers draw them) or splat (the paper's Gaussians)."),
    },
    "Renderer splat": {
        "samples": Setting("Gaussians along each side and line of a path."),
        "lines": Setting("Lines of Gaussians between the two sides of a path."),
        "interior_gradient": Setting("Let the Gaussians inside a path move its control points."),
        "covariance_gradient": Setting("Let the sizes and directions of Gaussians move the control points."),
    },
    "Adding and removing paths": {
        "policy": Setting("scaffolding (Algorithm 1 of the paper) or replacement (Bezier Splatting's)."),
        "z_order": Setting("Paths on top: creation (the newest) or area (the smallest)."),
    },
    "Policy scaffolding: Algorithm 1 of the paper": {
        "initial_curves": Setting("Paths at the start, N0."),
        "growth": Setting("Growth of the population at an inflation, r_num: 1, or 1.01 and more."),
        "inflation_gap": Setting("Iterations between inflations, dT."),
        "shorten_gap": Setting("Shorten dT, and --replace-gap, if the run is too short for them."),
        "initial_radius": Setting("Radius of the first paths, in units of half the longer side."),
        "radius_decay": Setting("Radius of a generation divided by that of the one before, r_rad."),
        "prune_opacity": Setting("Largest opacity at which an inflation removes a path."),
        "compensate": Setting("Replace the paths that an inflation removed."),
        "flat": Setting("Start with all paths, in one generation."),
    },
    "Policy scaffolding: recycling of the paths that matter least": {
        "recycle_gap": Setting("Iterations between recyclings; 0 for none."),
        "recycle_share": Setting("Share of the paths that one recycling replaces."),
        "recycle_until": Setting("Last recycling, as a share of the iterations."),
    },
    "Policy replacement": {
        "replace_gap": Setting("Iterations from a removal to the addition of as many paths, and to the next removal."),
    },
    "Optimizer": {
        "lr_points": Setting("Learning rate of the control points, in units of half the longer side."),
        "lr_color": Setting("Learning rate of the colours."),
        "lr_opacity": Setting("Learning rate of the opacities."),
        "lr_scale": Setting("Factor for every learning rate."),
        "lr_decay": Setting("cosine, constant or steps (Bezier Splatting's)."),
        "lr_final": Setting("Last learning rate divided by the first, for cosine decay."),
        "color_parameter": Setting("Optimize colours directly (direct) or through a sigmoid (logit)."),
    },
    "Loss": {
        "opacity_weight": Setting("Weight of the term for opaque paths."),
        "ssim_weight": Setting("Weight of the structural similarity (SSIM); 0 for the squared error alone."),
        "xing_weight": Setting("Weight of the term against crossing handles."),
        "bezier_weight": Setting("Weight of the Bezier regularizer."),
    },
}
"""Section of the help -> option, a field of FitConfig unless it is in `GOALS` or `FLAGS` -> its help."""

OTHER_DEFAULTS = {
    "refine": {
        "curves": "those of the drawing",
        "precision": "that of the drawing",
        "segments": "that of the drawing",
        "iterations": "500",
        "recycle_gap": "0",
    },
}
"""Command -> option -> its default in the help, where the command decides it and not FitConfig."""

REFUSED = {"refine": ("mode", "detail", "cutout", "threshold")}
"""Command -> options that its help leaves out, because all of their values but the usual one are refused."""

GOALS = ("max_bytes", "gzip", "target_psnr")
"""Options that are fields of Goal."""

FILE_OPTIONS = ("trim", "no_metadata", "size")
"""Options that say how the file is written."""

FLAGS = ("gzip", "opaque", "trim", "no_metadata")
"""Options without a value that are not fields of FitConfig."""

RARE = ("save_frames", "every", "checkpoint", "resume", "write_config", "retries", "ray_address")
"""Options of single commands that only --help-all shows."""

_FIELDS = tuple(field.name for field in fields(FitConfig))

_OTHER_OPTIONS = ("preset", "background", "levels", "history", "video", "config", "write_config", "engine")

OPTION_NAMES = {name: "--" + name.replace("_", "-") for name in (*_OTHER_OPTIONS, *GOALS, "size", *_FIELDS)} | {
    "address": "--ray-address",
    "checkpoint": "--resume",
    "image": "IN",
    "name": "NAME",
    "photo": "--image",
}
"""Name of an argument in Python -> the option of the command line."""


def requested(preset: str, options: dict[str, Any]) -> tuple[FitConfig, Goal]:
    """Return the settings and the goal that the options of a `SettingsCommand` ask for; None means not given.

    Raises:
        InputError: a value is out of range, or two values do not go together.
    """
    known = (*_FIELDS, *GOALS)
    given = {name: value for name, value in options.items() if name in known and value is not None}
    curves = given.pop("curves", None)
    goals = {name: given.pop(name) for name in GOALS if name in given}
    goal = Goal(**goals, auto=curves == "auto")
    config = make_config(preset, **with_curves(given, curves, goal))
    goal = with_given_segments(goal, given, config)
    if goal:
        require_scaffolding(config.policy, "to meet a goal")
    return config, goal


def options_of_mode(preset: str, options: dict[str, Any]) -> list[str]:
    """Return the options that decide the mode without --mode; none if the picture decides it."""
    given = {name: value for name, value in options.items() if name in _FIELDS and value is not None}
    names = settings_of_mode(preset, **given)
    if not names and given.get("mode", "auto") == "auto":  # only the fit of a photo has a state
        names = [name for name in ("resume", "checkpoint") if options[name] is not None][:1]
    return ["--" + name.replace("_", "-") for name in names]


def file_options(options: dict[str, Any]) -> FileOptions:
    """Return how the options of a `SettingsCommand` want the file to be written."""
    return FileOptions(metadata=not options["no_metadata"], trim=bool(options["trim"]), size=options["size"])


def stated(preset: str, background: str | None, options: dict[str, Any], config: FitConfig) -> dict[str, Any]:
    """Return every setting, goal and input of a command by its name in a TOML file; what is not set is left out.

    Args:
        preset, background, options: what was given.
        config: the settings that this led to.
    """
    found = {"preset": preset, "background": background, **config.to_dict()}
    found |= {name: options[name] for name in GOALS} | {"curves": options["curves"] or config.curves}
    found |= {name: options[name] for name in FILE_OPTIONS if options[name]}
    if options["curves"] is None and any(options[name] for name in GOALS):
        del found["curves"]
    if options["max_bytes"] is not None and config.minify and options["segments"] is None:
        del found["segments"]  # they follow from the bytes
    return {name: value for name, value in found.items() if value is not None}
