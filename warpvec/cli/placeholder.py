"""``warpvec run --placeholder``: a drawing of few bytes for web pages to show while the image loads."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

from warpvec.checks import counted, in_one_line
from warpvec.cli.arguments import check_out, read_photo, write_drawing
from warpvec.cli.loading import quick_loading
from warpvec.cli.summary import finite
from warpvec.errors import InputError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from warpvec.placeholders.placeholder import Placeholder

_ALLOWED = ("source", "out", "placeholder", "max_bytes", "background", "as_json", "quiet", "verbose")
"""Parameters that change a placeholder. Other settings are of other fits."""


def run_placeholder(ctx: click.Context, source: str, out: str, options: dict[str, Any]) -> None:
    """Print the placeholder of the image ``source`` as a data URI, or write its SVG to the file ``out``.

    Raises:
        InputError: another option was given, ``out`` is neither "-" nor an .svg file, or the bytes are out of range.
    """
    _refuse_others(ctx)
    check_out(out)
    if out != "-" and Path(out).suffix.lower() != ".svg":
        raise InputError("OUT", "must end in .svg with --placeholder, or be - for a data URI", repr(out), "rename it")
    photo = _opaque(read_photo(source, options["background"], "IN"), options["quiet"])
    with quick_loading():
        from warpvec.placeholders.placeholder import BYTES_DEFAULT, check_bytes, fit_placeholder
    max_bytes = check_bytes(options["max_bytes"] or BYTES_DEFAULT, "--max-bytes with --placeholder")
    found = fit_placeholder(photo, max_bytes)
    write_drawing(found.uri + "\n" if out == "-" else found.svg, out)
    if options["as_json"] or not options["quiet"]:
        _summarize(found, photo, out, options["as_json"])


def _opaque(photo: NDArray[np.float32], quiet: bool) -> NDArray[np.float32]:
    """Return ``photo`` [h, w, 3 or 4] over white; unless ``quiet``, say so if it is transparent."""
    from warpvec.image.alpha import is_transparent, over

    if not is_transparent(photo):
        return photo
    if not quiet:
        text = "transparent parts are white in the placeholder; --background names another colour"
        click.echo(f"warpvec: {text}", err=True)
    return over(photo, 1.0)


def _refuse_others(ctx: click.Context) -> None:
    for option in ctx.command.params:
        source = None if option.name is None else ctx.get_parameter_source(option.name)
        if source is ParameterSource.COMMANDLINE and option.name not in _ALLOWED:
            rule = "must not be given with --placeholder, which --max-bytes alone can change"
            raise InputError(option.opts[-1], rule, remedy="leave one of them out")


def _summarize(found: Placeholder, photo: NDArray[np.float32], out: str, as_json: bool) -> None:
    """Print the figures of a placeholder, to stderr if the data URI went to stdout."""
    from warpvec.svg.measure import file_quality

    facts: dict[str, float] = {"uri_bytes": len(found.uri), "bytes": len(found.svg), "paths": found.shape_count}
    facts |= file_quality(found.svg, photo)
    start = "data URI of" if out == "-" else f"{in_one_line(out)}: {facts['bytes']:,} bytes,"
    size = f"{facts['uri_bytes']:,} bytes" if out == "-" else f"{facts['uri_bytes']:,} as a data URI"
    text = (
        f"{start} {size}, {counted(found.shape_count, 'path')}\n"
        f"PSNR {facts['psnr']:.2f} dB, SSIM {facts['ssim']:.3f} (drawn by resvg at the size of the image)"
    )
    click.echo(json.dumps(finite(facts)) if as_json else text, err=out == "-")
