"""Options of ``run`` and ``refine`` for machines that cut: a sheet for each colour, and what will go wrong.

And a file for each part of a drawing.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from warpvec.checks import counted, in_one_line
from warpvec.errors import InputError
from warpvec.files import check_writable, write_atomic
from warpvec.making.packages import check_packages
from warpvec.svg.units import parse_millimeters

if TYPE_CHECKING:
    from warpvec.making.parts import Sheet
    from warpvec.making.sheets import SheetOptions
    from warpvec.result import Result

_LENGTHS = ("bleed", "kerf", "min_width")
_SWITCHES = ("mirror", "marks", "weeding", "size_check")

SHEET_OPTIONS = (*_LENGTHS[:2], *_SWITCHES)
"""Options that are of use with --sheets alone."""

_ONCE_SUFFIXES = (".dxf", ".svg")

CUT_OPTIONS = ("sheets", "split", "cut_once", "check_cut", "embroidery_check", *_LENGTHS, *_SWITCHES)
"""Parameters that `cut_options` adds to a command."""


class _Length(click.ParamType):
    """A length with its unit, in millimetres."""

    name = "LENGTH"

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Return the millimetres of a text such as "0.2mm"."""
        if isinstance(value, float):
            return value
        name = "length" if param is None else param.opts[-1]
        return parse_millimeters(name, str(value))


def cut_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options to ``command``."""
    length: dict[str, Any] = {"type": _Length(), "metavar": "LENGTH"}
    options = (
        click.option("--sheets", metavar="FOLDER", help="Write a sheet for each colour, for cutters."),
        click.option("--split", metavar="FOLDER", help="Write an SVG for each part that lies apart, such as an icon."),
        click.option("--cut-once", metavar="FILE", help="Write the edges to this .dxf or .svg, each once, for lasers."),
        click.option("--check-cut", is_flag=True, help="Say what will go wrong when it is cut."),
        click.option("--embroidery-check", is_flag=True, help="List places too narrow or too close to be embroidered."),
        click.option("--bleed", **length, help="Sheets: let colours reach so far below those on top."),
        click.option("--kerf", **length, help="Sheets: make up for a cut of this width."),
        click.option("--min-width", **length, help="Sheets: remove narrower places. Check: name them. [0.5mm]"),
        click.option("--mirror", is_flag=True, help="Sheets: exchange left and right."),
        click.option("--marks", is_flag=True, help="Sheets: add marks to lay them on each other by."),
        click.option("--weeding", is_flag=True, help="Sheets: add a border around the drawing."),
        click.option("--size-check", is_flag=True, help="Sheets: add a square of 20 mm to be measured."),
    )
    for option in reversed(options):
        command = option(command)
    return command


def check_cutting(options: Mapping[str, Any]) -> None:
    """Check, before the work, the options of `cut_options`.

    Raises:
        InputError: one is given without --sheets, the folder or file cannot be used, or a package is missing.
    """
    if options["sheets"] is None:
        for name in SHEET_OPTIONS:
            if options[name]:
                raise InputError(f"--{name.replace('_', '-')}", "must come with --sheets", remedy="add a folder")
        if options["min_width"] and not options["check_cut"]:
            raise InputError("--min-width", "must come with --sheets or --check-cut", remedy="add one of them")
    for name in ("sheets", "split"):
        _check_folder(f"--{name}", options[name])
    _check_cut_once(options["cut_once"])
    if options["sheets"] is not None or options["check_cut"] or options["embroidery_check"]:
        check_packages("--sheets, --check-cut and --embroidery-check")


def _check_folder(option: str, folder: str | None) -> None:
    if folder is None:
        return
    if os.path.exists(folder) and not os.path.isdir(folder):
        raise InputError(option, "must be a folder", repr(folder), "choose another name")
    check_writable(os.path.join(folder, "sheet.svg") if os.path.isdir(folder) else Path(folder), option)


def _check_cut_once(path: str | None) -> None:
    if path is None:
        return
    if Path(path).suffix.lower() not in _ONCE_SUFFIXES:
        rule = f"must end in {' or '.join(_ONCE_SUFFIXES)}"
        raise InputError("--cut-once", rule, repr(path), "rename it")
    check_writable(path, "--cut-once")
    check_packages("--cut-once")


def cut(result: Result, out: str, options: Mapping[str, Any]) -> dict[str, Any]:
    """Write the sheets and print the warnings that ``options`` ask for; return both for the summary.

    Raises:
        OSError: a sheet cannot be written.
    """
    facts: dict[str, Any] = {}
    if options["cut_once"] is not None:
        facts["cut_once"] = _write_once(result, options)
    if options["split"] is not None:
        facts["split"] = _write_parts(result, out, options)
    if options["embroidery_check"]:
        facts["embroidery_warnings"] = _check_embroidery(result)
    if options["sheets"] is None and not options["check_cut"]:
        return facts
    from warpvec.making.checks import MIN_WIDTH_MM, cut_warnings
    from warpvec.making.parts import read_parts

    drawing, made = read_parts(result.drawing.text, result.target.per_inch), _sheet_options(result, options)
    if options["check_cut"]:
        found = facts["cut_warnings"] = cut_warnings(drawing, options["min_width"] or MIN_WIDTH_MM, made)
        _say_faults("cut", found)
    if options["sheets"] is not None:
        names = facts["sheets"] = _write_sheets(drawing, Path(options["sheets"]), out, made, result)
        if not options["quiet"]:
            folder = in_one_line(options["sheets"])
            click.echo(f"warpvec: {folder}: {counted(len(names), 'sheet')}: {', '.join(names)}", err=True)
    return facts


def _check_embroidery(result: Result) -> list[str]:
    """Print what will go wrong when the drawing is embroidered, and return it."""
    from warpvec.making.embroidery import embroidery_warnings
    from warpvec.making.parts import read_parts

    found = embroidery_warnings(read_parts(result.drawing.text, result.target.per_inch))
    _say_faults("embroidery", found)
    return found


def _say_faults(work: str, found: list[str]) -> None:
    """Print what will go wrong with the ``work``, or that nothing will."""
    for text in found or ["nothing that would go wrong was found"]:
        click.echo(f"warpvec: {work}: {text}", err=True)


def _write_parts(result: Result, out: str, options: Mapping[str, Any]) -> int:
    """Write a file for each part that lies apart, named after ``out``, and return their number."""
    from warpvec.drawing.split import split_texts

    folder, texts = Path(options["split"]), split_texts(result.drawing)
    folder.mkdir(exist_ok=True)
    stem, digits = "part" if out == "-" else Path(out).stem, len(str(len(texts)))
    for number, text in enumerate(texts, 1):
        write_atomic(folder / f"{stem}-{number:0{digits}}.svg", text.encode())
    if not options["quiet"]:
        click.echo(f"warpvec: {in_one_line(str(folder))}: {counted(len(texts), 'part')}", err=True)
    return len(texts)


def _write_once(result: Result, options: Mapping[str, Any]) -> int:
    """Write the edges once, and return the number of their lines."""
    from warpvec.flat.cutting.edges_once import edges_once
    from warpvec.making.sheets import outline_count

    path = options["cut_once"]
    sheet = edges_once(result.drawing.text, result.target.per_inch, keeps_lines=result.has_center_lines)
    count = outline_count(sheet)
    write_atomic(path, _encoded(sheet, path, result))
    if not options["quiet"]:
        click.echo(f"warpvec: {in_one_line(path)}: {counted(count, 'line')}, each edge once", err=True)
    return count


def _encoded(sheet: Sheet, path: str, result: Result) -> bytes:
    """Return the bytes of a sheet: DXF if ``path`` ends so, else SVG."""
    from warpvec.making.dxf import encode_sheet
    from warpvec.making.sheet_svg import sheet_text

    choices = result.encoding.options
    if Path(path).suffix.lower() == ".dxf":
        return encode_sheet(sheet, splines=choices.dxf_splines)
    return sheet_text(sheet, choices.per_inch).encode()


def _sheet_options(result: Result, options: Mapping[str, Any]) -> SheetOptions:
    from warpvec.making.sheets import SheetOptions

    lengths = {name: options[name] or 0.0 for name in _LENGTHS}
    if options["sheets"] is None:  # nothing is removed, so that it can be named
        lengths["min_width"] = 0.0
    return SheetOptions(
        **lengths, mirror=options["mirror"], registration=options["marks"], weeding=options["weeding"],
        size_check=options["size_check"], keeps_lines=result.has_center_lines,
    )  # fmt: skip


def _write_sheets(drawing: Sheet, folder: Path, out: str, made: SheetOptions, result: Result) -> list[str]:
    """Write the sheets, and return the names of their files."""
    from warpvec.making.sheets import sheets_of

    suffix = ".dxf" if Path(out).suffix.lower() == ".dxf" else ".svg"
    folder.mkdir(exist_ok=True)
    names = []
    for number, (color, sheet) in enumerate(sheets_of(drawing, made).items(), 1):
        names.append(f"{number:02}-{color[1:]}{suffix}")
        write_atomic(folder / names[-1], _encoded(sheet, names[-1], result))
    return names
