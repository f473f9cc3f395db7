"""Every setting of a fit as an option of the command line, in sections."""

from __future__ import annotations

from dataclasses import Field, fields
from typing import Any

import click

from warpvec.config import FitConfig

SETTINGS = {
    "The result": {
        "curves": "Closed paths in the result.",
        "path_model": "A path is cubics in a loop (segments) or two curves with common ends (sides, with splat).",
        "segments": "Cubics per path of the model segments.",
        "degree": "Degree of the curves of the model sides, 2 to 12.",
        "precision": "Decimals of the coordinates, 0 to 6.",
        "opacity": "Of each path: free, or opaque for 1.",
        "colors": "Fills come from a palette of so many colours, which is fitted; 0 for any.",
        "palette": "Fills come from these colours, '#123,#a0b1c2', or from those named in a file.",
        "min_area": "No path of less than these square pixels.",
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

_TYPES: dict[str, type] = {"int": int, "float": float, "str": str}


class SettingsCommand(click.Command):
    """A command with an option for each field of FitConfig, in the sections of ``SETTINGS``."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        by_name = {field.name: field for field in fields(FitConfig)}
        for section in SETTINGS.values():
            self.params += [_setting_option(by_name[name], text) for name, text in section.items()]

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        settings = {name for section in SETTINGS.values() for name in section}
        options = {option.name: option for option in self.get_params(ctx) if isinstance(option, click.Option)}
        sections = {"Options": [name for name in options if name not in settings], **SETTINGS}
        for title, names in sections.items():
            with formatter.section(title):
                records = (options[name].get_help_record(ctx) for name in names)
                formatter.write_dl([record for record in records if record])


def _setting_option(field: Field[Any], text: str) -> click.Option:
    """The option of one setting. Its default is None, so that what is not given falls to the preset."""
    flag = field.name.replace("_", "-")
    shown = "" if field.default is None else f" [{field.default}]"
    if field.type == "bool":
        return click.Option([f"--{flag}/--no-{flag}"], default=None, help=text + shown)
    kind = _TYPES[str(field.type).removesuffix(" | None")]
    return click.Option([f"--{flag}"], type=kind, default=None, help=text + shown)
