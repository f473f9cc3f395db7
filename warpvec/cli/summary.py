"""Print the summary of a file that a command wrote or measured, as text or as JSON."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import click

from warpvec.checks import counted, in_one_line
from warpvec.config.fit_config import AUTO, SETTINGS
from warpvec.config.modes import MODES
from warpvec.config.presets import PRESETS
from warpvec.goals.goal import describe
from warpvec.goals.registry import QUANTITIES
from warpvec.writers.registry import SVG_SUFFIXES, writer_of
from warpvec.writers.saved import losses

if TYPE_CHECKING:
    from warpvec.result import Result


def print_summary(metrics: dict[str, Any], out: str, as_json: bool, *, verbose: bool = False) -> None:
    """Print the ``metrics`` of the file ``out``: to stdout, or to stderr if ``out`` is "-" because stdout has the SVG.

    ``verbose`` adds the PSNR inside the fit to the text. JSON always contains it, and so does the text for renderers
    whose soft image differs from the file.
    """
    text = json.dumps(finite(metrics), allow_nan=False) if as_json else _text(metrics, out, verbose)
    click.echo(text, err=out == "-")


_BECAUSE = "because of "
"""Beginning of the reason for a mode that options have decided."""


def end_fit(
    ctx: click.Context,
    result: Result,
    out: str,
    options: dict[str, Any],
    deciding: Sequence[str] = (),
    more: Mapping[str, Any] | None = None,
) -> None:
    """Print the summary of a fit as ``options`` ask for it, and exit with 130 if Ctrl-C ended the fit.

    ``deciding`` are the options that have decided the mode, as there is no --mode. JSON also has ``more``.
    """
    if options["as_json"] or not options["quiet"]:
        metrics = {**result.metrics, "history": result.history, **(more or {})}
        if deciding and metrics["mode_reason"] is None:
            metrics["mode_reason"] = _BECAUSE + ", ".join(deciding)
        reason = _why_on_cpu(result.config.device, metrics["device"], options["verbose"])
        if reason is not None and options["as_json"]:
            metrics["device_reason"] = reason
        elif reason is not None:
            metrics["device"] += f" ({reason})"
        metrics |= {"soft_reason": why} if (why := _why_none_is_soft(result)) else {}
        if metrics["strokes"] and writer_of(out).suffix == ".dxf":
            metrics["dxf_strokes"] = "center" if result.has_center_lines else "edges"
        metrics |= {"unused_preset": name} if (name := _unused_preset(options, metrics["mode"])) else {}
        print_summary(metrics, out, options["as_json"], verbose=options["verbose"])
    if result.interrupted:
        ctx.exit(130)  # 128 + SIGINT, as shells have it


def _why_on_cpu(wanted: str, device: str, verbose: bool) -> str | None:
    """Return why "auto" chose the CPU; None if it did not, or if the machine has no GPU, except if ``verbose``."""
    from warpvec.rendering.devices import NO_HARDWARE, why_no_gpu

    reason = why_no_gpu() if (wanted, device) == ("auto", "cpu") else None
    return None if reason == NO_HARDWARE and not verbose else reason


def _why_none_is_soft(result: Result) -> str | None:
    """Return why a photo has no soft path although their number is given; None if it has some, or none is wanted."""
    from warpvec.polish.finishing import planned_iterations

    config, goal = result.config, result.goal_facts or {}
    if config.mode != "photo" or config.soft in (AUTO, "0") or result.metrics["soft"]:
        return None
    if any(goal.get(name) is not None for name, each in QUANTITIES.items() if not each.is_of_text):
        return "a fit to a quality has none"
    if not planned_iterations(config):
        return "short fits, and those with --lod, a palette, --colors or another renderer, have none"
    if result.interrupted or result.run.iterations < config.iterations:
        return "the fit ended before they are tried"
    return "none brings the drawing closer to the picture"


def _unused_preset(options: dict[str, Any], mode: str) -> str | None:
    """Return the name of the preset if ``mode`` uses none of its settings; None if it uses some, or if it has none."""
    name = options.get("preset", "default")
    changed = set(PRESETS[name].settings)
    if not changed or mode in ("photo", "mixed"):
        return None
    changed.discard("iterations")  # drawings need fewer than any preset has
    return None if any(mode in SETTINGS[setting].modes for setting in changed) else name


_WIDTHS_SHOWN = 4
"""Widths of lines that the summary lists."""

_PEN_SHARE = 0.15
"""Widest line of a drawing of lines, as a share of the picture's shorter side. Bold icons have an eighth; wider lines
are the insides of filled shapes."""


_REMOVED = {"node": "needless node", "path": "needless path", "loop": "needless loop", "speck": "speck"}
"""Name of what a drawing leaves out -> the same in the summary."""


_STROKES = {
    "edges": "both edges, for cutters; --dxf-strokes center gives the lines that pens follow",
    "center": "the lines that pens follow; --dxf-strokes edges gives both edges, for cutters",
}
"""What strokes are in a DXF file -> the same in the summary."""


def finite(value: object) -> Any:
    """Return ``value`` with None in place of each infinite number."""
    if isinstance(value, dict):
        return {name: finite(item) for name, item in value.items()}
    if isinstance(value, list):
        return [finite(item) for item in value]
    return None if value in (math.inf, -math.inf) else value


def _text(metrics: dict[str, Any], out: str, verbose: bool) -> str:
    backdrops = ", over black and over white" if metrics["transparent"] else ""
    special = {"with a gradient": metrics["gradients"], "soft": metrics.get("soft")}
    some = ", ".join(f"{count} {words}" for words, count in special.items() if count)
    counts = f"{counted(metrics['curves'], 'path')}{f' ({some})' if some else ''}"
    counts += f", {counted(metrics['segments'], 'segment')}"
    size = "" if metrics["millimeters"] is None else "; {:.4g} x {:.4g} mm".format(*metrics["millimeters"])
    as_svg = "" if writer_of(out).suffix in SVG_SUFFIXES else " as SVG"
    lines = [
        f"{{out}}: {counts}, {{bytes:,}} bytes{as_svg}, {{gzip_bytes:,}} gzipped{size}",
        f"PSNR {{psnr:.2f}} dB, SSIM {{ssim:.3f}} (file drawn by resvg{backdrops})",
    ]
    kinds = [words for kind, words in metrics["kinds"].items() if kind != "path"]
    if kinds:
        lines.insert(1, f"of these {', '.join(kinds)}; {counted(metrics['parameters'], 'parameter')}")
    if metrics.get("colors"):
        lines.insert(1, f"{counted(len(metrics['colors']), 'colour')}: {', '.join(metrics['colors'])}")
    if metrics.get("psnr_as_fitted") is not None:
        blur = metrics["blur_undone"]
        fitted = f"picture, if the file is blurred by {blur:.1f} px as well" if blur else "restored picture"
        lines.append(f"PSNR {{psnr_as_fitted:.2f}} dB against the {fitted}")
    if "lines" in metrics:
        lines.insert(1, _lines_of(metrics))
    is_refined = metrics.get("start_psnr") is not None
    if is_refined:
        lines[-1] += ", before {start_psnr:.2f} dB (the given file)"
    if metrics.get("grid"):
        share = f"{100.0 * metrics['grid_share']:.0f} % of its numbers are on half units"
        hint = "" if is_refined else "; --grid off gives pixels"
        lines.append(f"drawn on a grid of {metrics['grid']}: {share}{hint}")
    if metrics.get("unchanged"):
        lines.append("the fit found nothing better than the given drawing, which is written unchanged")
    if "internal_psnr" in metrics:
        if verbose or metrics["renderer"] != "exact":
            is_exact = metrics["renderer"] == "exact"
            image = "as the exact renderer draws it" if is_exact else "of the {renderer} renderer's soft image"
            lines.append(f"PSNR {{internal_psnr:.2f}} dB inside the fit ({image})")
        if metrics["degree"] != 3:
            lines.append("sides of degree {degree} written as cubics within {conversion_px:.3f} px")
        stopped = ", interrupted: the best result so far" if metrics["interrupted"] else ""
        threads = f", {counted(metrics['threads'], 'thread')}" if metrics["threads"] else ""
        lines.append(f"{{iterations}} iterations in {{seconds:.1f}} s on {{device}}{threads}{stopped}")
    if metrics.get("mode_reason"):
        mode = MODES[metrics["mode"]]
        is_decided = metrics["mode_reason"].startswith(_BECAUSE)
        hint = "else the picture decides" if is_decided else f"--mode {mode.likeliest_other} overrides"
        lines.append(f"mode: {mode.title} ({{mode_reason}}); {hint}")
    if metrics.get("unused_preset"):
        lines.append("the preset {unused_preset} is for photos and changes nothing here")
    if metrics.get("condition_words"):
        lines.append("the picture: {condition_words}")
    if metrics.get("size_words"):
        lines.append("{size_words}")
    if metrics.get("not_kept"):
        lines.append(f"not kept: {'; '.join(metrics['not_kept'].values())}")
    purpose, replaced = metrics.get("purpose", "web"), metrics.get("replaced") or []
    lines += losses(out, purpose, replaced, metrics.get("soft") or 0)
    if "dxf_strokes" in metrics:
        lines.append(f"{counted(metrics['strokes'], 'stroke')} as {_STROKES[metrics['dxf_strokes']]}")
    if metrics.get("thin_strokes"):
        thin, are = counted(metrics["thin_strokes"], "stroke"), "is" if metrics["thin_strokes"] == 1 else "are"
        lines.append(f"{thin} {are} thinner than --line-width-min, down to {{thinnest_stroke:g}} px, and easily lost")
    if metrics.get("soft_reason"):
        lines.append("no path is soft: {soft_reason}")
    removed = [counted(count, _REMOVED.get(name, name)) for name, count in metrics.get("left_out", {}).items() if count]
    if removed:
        lines.append(f"{', '.join(removed)} removed")
    if metrics.get("levels"):
        parts = (f"{counted(level['curves'], 'path')} {level['psnr']:.2f} dB" for level in metrics["levels"])
        lines.append("up to each level: " + ", ".join(parts))
    if metrics.get("goal"):
        lines.append(describe(metrics["goal"]))
    return "\n".join(lines).format(out="SVG" if out == "-" else in_one_line(out), **metrics)


def _lines_of(metrics: dict[str, Any]) -> str:
    """Return what the summary says of a drawing in the mode lines."""
    widths = metrics["line_widths"]
    listed = ", ".join(f"{width:g}" for width in widths[:_WIDTHS_SHOWN])
    more = f" and {len(widths) - _WIDTHS_SHOWN} more" if len(widths) > _WIDTHS_SHOWN else ""
    areas = f"; {counted(metrics['wide_areas'], 'wide area')} drawn as outlines" if metrics["wide_areas"] else ""
    is_filled = max(widths) > _PEN_SHARE * min(metrics["width"], metrics["height"])
    hint = "; for filled shapes give --mode mono or flat" if is_filled else ""
    pen = f"pen up for {metrics['pen_up']:.0f} px"
    return f"{counted(metrics['lines'], 'line')}, {listed}{more} px wide; {pen}{areas}{hint}"
