"""Options that several commands share, and reading and writing the files they name."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from warpvec.cli.rescue import rescued
from warpvec.cli.streams import check_stdout, read_stdin, write_stdout
from warpvec.errors import InputError
from warpvec.files import check_writable, naming_errors, write_atomic
from warpvec.inputs import read_file
from warpvec.writers.registry import SVG_SUFFIXES, WRITERS, encode, listed, writer_of

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from warpvec.image.read import PictureFile
    from warpvec.result import Result

_preset_option = click.option("--preset", default="default", metavar="NAME", help="Named settings to start from.")
json_option = click.option("--json", "as_json", is_flag=True, help="Report as one JSON object (infinity as null).")
background_option = click.option("--background", metavar="COLOR", help="Fill transparent parts with this colour.")
quiet_option = click.option("-q", "--quiet", is_flag=True, help="Show no progress and no summary.")
_verbose_option = click.option("-v", "--verbose", is_flag=True, help="Add the PSNR inside the fit to the summary.")


def page_option(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add --page to ``command``."""
    return click.option(
        "--page", "page_number", type=click.IntRange(min=1), metavar="N",
        help="Page of a TIFF or PDF file. [the first]",
    )(command)  # fmt: skip


def start_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add what a fit begins with to ``command``: the preset and the background."""
    return _preset_option(background_option(command))


def report_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add what is shown of a fit to ``command``."""
    return json_option(_verbose_option(quiet_option(command)))


_OWN_METADATA = b'<metadata>{"generator": "warpvec '
"""Start of the metadata as ``warpvec/svg/write.py`` writes it. Editors and the page of ``view`` write it differently,
so a drawing that was edited by hand is not taken for one of warpvec's."""

_HEAD_BYTES = 4096
"""Number of bytes in which the metadata start. Only a title, which is a file name, comes before them."""


def default_out(source: str) -> str:
    """Return the path of the image ``source`` with the suffix .svg.

    Raises:
        InputError: ``source`` is stdin, an SVG, or not the name of a file; or another program wrote the SVG that is
            there.
    """
    if source == "-":
        raise InputError("OUT", "must be given when IN is stdin", remedy="add a file name, or - for stdout")
    path = Path(source)
    if path.suffix.lower() in (".svg", ".svgz"):
        remedy = "an SVG is a drawing already: see refine, or give OUT and --from-svg"
        raise InputError("IN", "must be an image such as a PNG or JPEG file", repr(source), remedy)
    if not path.name:
        raise InputError("IN", "must be an image such as a PNG or JPEG file", repr(source), "give one")
    out = str(path.with_suffix(".svg"))
    if os.path.isfile(out) and not _is_own_file(out):
        rule = f"must be given, because {out!r} exists and does not say that warpvec wrote it"
        raise InputError("OUT", rule, remedy="name a file")
    return out


def _is_own_file(path: str) -> bool:
    """Return whether the metadata in the first kilobytes of the file name warpvec; False if it cannot be read."""
    try:
        with open(path, "rb") as file:
            return _OWN_METADATA in file.read(_HEAD_BYTES)
    except OSError:
        return False


def check_out(out: str, name: str = "OUT", *, any_kind: bool = False) -> None:
    """Raise InputError unless ``out`` is "-" or an SVG file that can be written; ``name`` is for the message.

    With ``any_kind`` it may be any kind of file that a drawing can be saved as.
    """
    if out == "-":
        check_stdout(name)
        return
    suffixes = tuple(WRITERS) if any_kind else SVG_SUFFIXES
    _check_file(out, name, suffixes, f"must end in {listed(suffixes)}, or be - for stdout")
    writer_of(out).check(out, name)


def check_page(page: str) -> None:
    """Raise InputError unless ``page``, the value of --report, is an HTML file that can be written."""
    _check_file(page, "--report", (".html", ".htm"), "must end in .html or .htm")


def _check_file(path: str, name: str, suffixes: tuple[str, ...], rule: str) -> None:
    """Raise InputError unless ``path`` can be written and has one of the ``suffixes``, which ``rule`` states."""
    check_writable(path, name)
    special = Path(path).exists() and not Path(path).is_file()  # such as /dev/null
    if not special and Path(path).suffix.lower() not in suffixes:
        raise InputError(name, rule, repr(path), "rename it")


def check_background(background: str | None, image: str | None) -> None:
    """Raise InputError if a background is given without the image it belongs to."""
    if background is not None and image is None:
        raise InputError("background", "must come with --image", f"{background!r} alone", "add the image")


def check_one_stdin(inputs: Mapping[str, str | None]) -> None:
    """Raise InputError if two ``inputs``, by their names on the command line, are "-", the one stdin there is."""
    names = [name for name, path in inputs.items() if path == "-"]
    if len(names) > 1:
        rule = f"must be a file when {names[0]} is stdin"
        raise InputError(names[1], rule, "- for both", "save one of them as a file")


def read_source(source: str, name: str) -> str | bytes:
    """Return the bytes of stdin if ``source`` is "-", otherwise ``source``, the path of an image.

    Raises:
        InputError: stdin cannot be read or is too long; ``name`` is for the message.
    """
    from warpvec.image.read import MAX_IMAGE_BYTES  # not above: it loads NumPy and Pillow, which the help does without

    return read_stdin(MAX_IMAGE_BYTES, name) if source == "-" else source


def read_photo(image: str, background: str | None, name: str = "--image") -> NDArray[np.float32]:
    """Return the pixels of `read_photo_file`."""
    return read_photo_file(image, background, name).pixels


def read_photo_file(image: str, background: str | None, name: str = "--image", page: int | None = None) -> PictureFile:
    """Return the image that the argument ``name`` gives, as `read_picture` does.

    Raises:
        InputError: the image cannot be read or does not have the ``page``, or ``background`` is not a colour.
    """
    from warpvec.image.read import read_picture

    return read_picture(read_source(image, name), background, name=name, page=page)


def read_svg_bytes(path: str, name: str = "SVG") -> bytes:
    """Return the bytes of the SVG file ``path``, or of stdin if it is "-".

    Raises:
        InputError: the file cannot be read or is too large; ``name`` is for the message.
    """
    from warpvec.svg.document import MAX_SVG_BYTES

    return read_bytes(path, MAX_SVG_BYTES, name, "an SVG file")


def read_bytes(path: str, limit: int, name: str, kind: str = "a file") -> bytes:
    """Return at most ``limit`` bytes of the file ``path``, or of stdin if it is "-".

    Raises:
        InputError: the file cannot be read or is too large; ``name`` and ``kind`` are for the message.
    """
    return read_stdin(limit, name) if path == "-" else read_file(path, limit, name, kind)


def write_result(result: Result, out: str) -> None:
    """Write the drawing of a run to the file ``out``, whole or not at all; or its SVG to stdout for "-".

    If it cannot be written, its SVG is written elsewhere.

    Raises:
        click.ClickException: it was written elsewhere.
        OSError: it cannot be written anywhere; the error has the file's name.
        InputError: it cannot be encoded as such a file, and its SVG cannot be written anywhere.
    """
    if out == "-":
        write_drawing(result.svg(), out)
    else:
        _write_or_rescue(lambda: result.encoded(out), result.svg(), out)


def write_drawing(text: str, out: str) -> None:
    """Write the SVG ``text`` to the file ``out``, whole or not at all; or to stdout for "-".

    The suffix decides the kind of file. If it cannot be written, the text is written elsewhere.

    Raises:
        click.ClickException: it was written elsewhere.
        OSError: it cannot be written anywhere; the error has the file's name.
        InputError: as `warpvec.writers.registry.encode`, and the text cannot be written anywhere.
    """
    if out == "-":
        with naming_errors("stdout"):
            write_stdout(text.encode())
    else:
        _write_or_rescue(lambda: encode(text, out), text, out)


def _write_or_rescue(encoded: Callable[[], bytes], text: str, out: str) -> None:
    try:
        write_atomic(out, encoded())
    except (OSError, InputError) as error:
        raise rescued(text, out, error) or error from error
