"""Run the icon gate: trace icons, and compare colour and words of each file with its designer's.

    python bench/gate.py FOLDER [--size 512] [--over-white] [--damage web] [--methods auto,vtracer] [--json OUT.json]
    python bench/gate.py AFTER.json --compare BEFORE.json

FOLDER has a folder of SVGs for each family. Each SVG is drawn by resvg at 8 times the size and averaged, traced by a
child process, and the file is compared with the original at 1024 px over white.
"""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from statistics import fmean, median
from typing import Any

import click
import numpy as np
from flat_methods import OPTIONS, SkippedError, method_named
from flat_originals import Original, stretched
from gate_damage import DAMAGES
from gate_measures import color_difference, count_words, turning
from harness import comma_separated, machine_facts, machine_line, markdown_table
from PIL import Image

from warpvec.errors import InputError
from warpvec.svg.measure import draw

SAMPLES = 8
"""Times the size at which an original is drawn before it is averaged."""

JUDGED = 1024
"""Longest side in px of the drawings that are compared."""


@dataclass
class Row:
    """A tracing, measured; ratios are to the original.

    Attributes:
        family, name, method: the folder, the icon, and the tracer.
        de00: mean CIEDE2000 against the original, over white.
        parameters, elements: numbers that shape the outlines, and shapes, over the original's.
        parameter_count, element_count: those of the file.
        turning: absolute turning of the outlines a length, over the original's; None if either cannot be read.
        seconds: CPU seconds of the whole process, its children included.
    """

    family: str
    name: str
    method: str
    de00: float
    parameters: float
    elements: float
    parameter_count: int
    element_count: int
    turning: float | None
    seconds: float


# The pictures


def save_picture(original: Original, path: Path, size: int, over_white: bool) -> None:
    """Save the picture to trace: ``SAMPLES`` squared drawn pixels of premultiplied alpha are averaged to one."""
    drawn = original.drawn(size, SAMPLES, transparent=True)
    width, height = original.extent(size)
    straight = drawn.reshape(height, SAMPLES, width, SAMPLES, 4).astype(np.float32) / 255
    alpha = straight[..., 3:].mean((1, 3))
    premultiplied = (straight[..., :3] * straight[..., 3:]).mean((1, 3))
    if over_white:
        pixels = premultiplied + 1 - alpha
    else:
        pixels = np.concatenate([premultiplied / np.maximum(alpha, 1e-6), alpha], 2)
    Image.fromarray(np.round(255 * pixels.clip(0, 1)).astype(np.uint8)).save(path)


# The measures


def measure(family: str, original: Original, method: str, svg: str, seconds: float) -> Row:
    """Return the row of a tracing."""
    width, height = original.extent(JUDGED)
    drawn, truth = (draw(stretched(text, width, height), width, height) for text in (svg, original.text))
    ours, theirs = count_words(svg), count_words(original.text)
    return Row(
        family, original.name, method, color_difference(drawn, truth),
        ours.parameters / max(theirs.parameters, 1), ours.elements / max(theirs.elements, 1),
        ours.parameters, ours.elements, _turning(svg, original), seconds,
    )  # fmt: skip


def _turning(svg: str, original: Original) -> float | None:
    try:
        ours, theirs = (turning(text, *original.extent(JUDGED)) for text in (svg, original.text))
    except InputError:
        return None
    return ours / theirs if theirs else None


# The runs


@dataclass(frozen=True)
class Plan:
    """What is traced, and how."""

    icons: list[tuple[str, Original]]
    methods: list[str]
    options: list[str]
    size: int
    over_white: bool
    damage: str | None
    keep: Path | None

    def rows(self, folder: Path) -> Iterator[Row]:
        """Yield a row for each tracing; what fails is said on the error stream."""
        for family, original in self.icons:
            picture = folder / f"{family}-{original.name}.png"
            save_picture(original, picture, self.size, self.over_white or self.damage is not None)
            if self.damage is not None:
                Image.fromarray(DAMAGES[self.damage](np.asarray(Image.open(picture)))).save(picture)
            for method in self.methods:
                try:
                    yield self._row(method, family, original, picture)
                except (SkippedError, InputError) as error:
                    click.echo(f"{family}/{original.name}, {method}: {error}", err=True)

    def _row(self, method: str, family: str, original: Original, picture: Path) -> Row:
        out = (self.keep or picture.parent) / f"{picture.stem}-{method}.svg"
        start = _cpu_seconds()
        traced = method_named(method, {"auto": self.options})(original, picture, out)
        seconds = _cpu_seconds() - start
        assert traced.svg is not None
        return measure(family, original, method, traced.svg, seconds)


def _cpu_seconds() -> float:
    """Return the CPU seconds of this process and of its children that have ended."""
    return sum(os.times()[:4])


def find_icons(folder: Path, names: list[str]) -> list[tuple[str, Original]]:
    """Return family and drawing of the SVGs in the folders of ``folder``, or of those that ``names`` names.

    Raises:
        click.UsageError: there are none.
    """
    paths = [path for path in sorted(folder.glob("*/*.svg")) if not names or {path.stem, path.parent.name} & {*names}]
    if not paths:
        raise click.UsageError(f"FOLDER must hold folders with SVGs of these names, but {folder} holds none")
    return [(path.parent.name, Original(path.stem, path.read_text())) for path in paths]


# The tables

_COLUMNS = ("dE00", "worst", "parameters", "elements, median", "turning", "CPU s", "most")


def details_table(rows: Sequence[Row]) -> str:
    """Return a table with a row for every tracing."""
    lines = [[f"{row.family}/{row.name}", row.method, f"{row.de00:.4f}", f"{row.parameters:.2f}", row.parameter_count,
              f"{row.elements:.2f}", "-" if row.turning is None else f"{row.turning:.2f}", f"{row.seconds:.1f}"]
             for row in rows]  # fmt: skip
    return markdown_table(("icon", "method", "dE00", "parameters", "count", "elements", "turning", "CPU s"), lines)


def summary_table(rows: Sequence[Row]) -> str:
    """Return a table with a row for each family and method, and the means of the families' figures."""
    lines: list[list[object]] = []
    for method in dict.fromkeys(row.method for row in rows):
        of_method = [row for row in rows if row.method == method]
        families = dict.fromkeys(row.family for row in of_method)
        groups = {family: [row for row in of_method if row.family == family] for family in families}
        figures = [_figures(group) for group in groups.values()]
        names = [*groups, "macro mean"]
        counts = [*map(len, groups.values()), len(of_method)]
        macro = [fmean(column) for column in zip(*figures, strict=True)]
        lines += [[method, name, count, *_cells(row)] for name, count, row in
                  zip(names, counts, [*figures, macro], strict=True)]  # fmt: skip
    return markdown_table(("method", "family", "n", *_COLUMNS), lines)


def _figures(rows: Sequence[Row]) -> list[float]:
    turnings = [row.turning for row in rows if row.turning is not None]
    return [
        fmean(row.de00 for row in rows), max(row.de00 for row in rows), fmean(row.parameters for row in rows),
        median(row.elements for row in rows), fmean(turnings) if turnings else float("nan"),
        fmean(row.seconds for row in rows), max(row.seconds for row in rows),
    ]  # fmt: skip


def _cells(figures: Sequence[float]) -> list[str]:
    return [
        format(value, form) for value, form in zip(figures, (".4f", ".4f", *[".2f"] * 3, *[".1f"] * 2), strict=True)
    ]


def comparison_table(before: Sequence[Row], after: Sequence[Row]) -> str:
    """Return a table with the icons that both have, those whose parameters or colours changed most first."""
    known = {(row.family, row.name, row.method): row for row in before}
    pairs = [(known[key], row) for row in after if (key := (row.family, row.name, row.method)) in known]
    pairs.sort(key=lambda pair: -abs(pair[1].parameters - pair[0].parameters) - abs(pair[1].de00 - pair[0].de00))
    lines = [[f"{old.family}/{old.name}", old.method, f"{old.de00:.4f}", f"{new.de00:.4f}", f"{old.parameters:.2f}",
              f"{new.parameters:.2f}", f"{old.elements:.2f}", f"{new.elements:.2f}", f"{old.seconds:.1f}",
              f"{new.seconds:.1f}"] for old, new in pairs]  # fmt: skip
    header = ("icon", "method", "dE00", "now", "parameters", "now", "elements", "now", "CPU s", "now")
    return markdown_table(header, lines)


# The command


def _load(path: Path) -> list[Row]:
    return [Row(**row) for row in json.loads(path.read_text())["rows"]]


def _check_methods(methods: list[str]) -> None:
    if not {*methods} <= {"auto", "vtracer", "potrace"}:
        raise click.UsageError(f"--methods must be of auto, vtracer, potrace, got {','.join(methods)}")


def _rounded(value: object) -> Any:
    return round(value, 5) if isinstance(value, float) else value


_json_path = click.Path(exists=True, dir_okay=False, path_type=Path)


@click.command()
@click.argument("source", metavar="FOLDER|JSON", type=click.Path(exists=True, path_type=Path))
@click.option("--size", default=512, show_default=True, help="Longest side of the pictures in pixels.")
@click.option("--over-white", is_flag=True, help="Trace pictures over white instead of with alpha.")
@click.option("--damage", type=click.Choice([*DAMAGES]), help="Trace damaged pictures over white.")
@click.option("--methods", callback=comma_separated, default="auto", show_default=True, help="As in auto,vtracer.")
@click.option("--option", "options", multiple=True, help="An option of `warpvec run`, as in --option=--minify.")
@click.option("--names", default="", help="Only these icons or families, as in bell,openmoji.")
@click.option("--json", "out", type=click.Path(dir_okay=False, path_type=Path), help="Write the rows as JSON.")
@click.option("--compare", type=_json_path, help="Rows of an earlier run, to lay beside these.")
@click.option("--keep", type=click.Path(file_okay=False, path_type=Path), help="Keep the SVGs in this folder.")
@click.option("--details/--no-details", default=True, help="Print a row for each tracing.")
def main(
    source: Path,
    size: int,
    over_white: bool,
    damage: str | None,
    methods: list[str],
    options: tuple[str, ...],
    names: str,
    out: Path | None,
    compare: Path | None,
    keep: Path | None,
    details: bool,
) -> None:
    """Trace the icons in the folders of FOLDER, or show the rows of a JSON file that this command wrote."""
    _check_methods(methods)
    facts = machine_facts()
    if source.is_file():
        rows = _load(source)
    else:
        icons = find_icons(source, [name for name in names.split(",") if name])
        rows = _run(Plan(icons, methods, [*OPTIONS["auto"], *options], size, over_white, damage, keep))
    if out is not None:
        settings = {"size": size, "over_white": over_white, "damage": damage, "options": options}
        records = [{name: _rounded(value) for name, value in asdict(row).items()} for row in rows]
        out.write_text(json.dumps({"facts": facts, "settings": settings, "rows": records}, indent=1) + "\n")
    if compare is not None:
        earlier = _load(compare)
        click.echo(f"{comparison_table(earlier, rows)}\n\nbefore:\n\n{summary_table(earlier)}\n\nnow:\n")
    elif details:
        click.echo(details_table(rows) + "\n")
    click.echo(summary_table(rows) + "\n")
    click.echo(machine_line(facts))


def _run(plan: Plan) -> list[Row]:
    if plan.keep is not None:
        plan.keep.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        rows = list(plan.rows(Path(folder)))
    if not rows:
        raise click.ClickException("no icon could be traced")
    return rows


if __name__ == "__main__":
    main()
