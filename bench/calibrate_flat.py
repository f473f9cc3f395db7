"""Sweep the numbers of a stage of flat art: how far each can move before a result of the pictures in FOLDER changes.

    python bench/calibrate_flat.py FOLDER --stage regions [--field ramp] [--size 96] [--limit 4] [--whole]

Each number (`warpvec/flat/constants`) is moved down and up by growing factors, alone, until the result of its stage
differs for some picture: the regions, the traced or simplified drawing in hundredths of a pixel, the parts of a cutout,
the mode. ``--whole`` compares files instead, and shows how the bytes and the PSNR change; it takes longer. A number
that can move far in both directions is not tuned on these pictures, and one that can hardly move decides something.
The factor 1 means that the first step changes a result, "any" that no step does.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import click
import numpy as np
import torch
from harness import machine_facts, machine_line, markdown_table
from numpy.typing import NDArray

from warpvec.config.fit_config import FitConfig
from warpvec.drawing.drawing import Drawing
from warpvec.flat.constants.curves import CURVES
from warpvec.flat.constants.cutting import CUTTING
from warpvec.flat.constants.drawing import DRAWING
from warpvec.flat.constants.layers import LAYERS
from warpvec.flat.constants.mode_choice import MODE_CHOICE
from warpvec.flat.constants.mono import MONO
from warpvec.flat.constants.regions import REGIONS
from warpvec.flat.constants.simplification import SIMPLIFICATION
from warpvec.flat.cutting.cutout import cut_out
from warpvec.flat.drawing import FlatDrawing
from warpvec.flat.mode_choice import choose_mode
from warpvec.flat.mono import mono_tracing
from warpvec.flat.regions.regions import find_regions
from warpvec.flat.scene_building import scene_of
from warpvec.geometry.scene import Scene
from warpvec.image.read import read_image
from warpvec.modes.choice import draw_picture
from warpvec.modes.request import Request

FACTORS = (1.02, 1.1, 1.25, 1.5, 2.0, 4.0)
"""Steps of a number, as factors or divisors of its value. Whole numbers move by one at least."""

SUFFIXES = (".png", ".jpg", ".gif", ".webp")
CONFIG = FitConfig(mode="flat", threads=1, device="cpu")


@dataclass(frozen=True)
class Subject:
    """A picture with what the stages before have made of it, so that a stage can be run alone."""

    name: str
    request: Request
    work: FlatDrawing
    regions: Any
    scene: Scene

    @staticmethod
    def of(path: Path, size: int) -> Subject:
        """Return the picture of a file, at most ``size`` pixels long."""
        request = Request.of(read_image(path), replace(CONFIG, fit_size=size))
        image = torch.from_numpy(request.picture.reduced)
        work = FlatDrawing(image, request.settings)
        return Subject(path.stem, request, work, find_regions(image.numpy()), work.draw(FitConfig.detail)[0])

    @property
    def pixels(self) -> NDArray[np.float32]:
        """The reduced picture [h, w, 3 or 4]."""
        return self.request.picture.reduced


def _regions(subject: Subject) -> list[Any]:
    found = find_regions(subject.pixels)
    paints = found.paints
    return [found.label, found.other, found.share.round(2), paints.color.round(3), paints.opacity.round(3), paints.kind]


def _traced(subject: Subject) -> list[Any]:
    return _values(scene_of(subject.regions, CURVES.tolerance))


def _simplified(subject: Subject) -> list[Any]:
    work = subject.work
    return _values(FlatDrawing(work.image, work.config, known=work.outlines).draw(FitConfig.detail)[0])


def _drawn(subject: Subject) -> list[Any]:
    return _values(FlatDrawing(subject.work.image, subject.work.config).draw(FitConfig.detail)[0])


def _parts(subject: Subject) -> list[Any]:
    height, width = subject.pixels.shape[:2]
    return _values(cut_out(subject.scene, width, height).scene)


def _values(scene: Scene) -> list[Any]:
    """Return what a file states of ``scene``, in hundredths of a pixel."""
    counts = scene.structure.loop_first_segment.numpy()
    return [scene.segments.numpy().round(2), counts, scene.color.numpy().round(3)]


STAGES: dict[str, tuple[Any, Callable[[Subject], list[Any]]]] = {
    "mode_choice": (MODE_CHOICE, lambda subject: [choose_mode(subject.pixels).mode]),
    "regions": (REGIONS, _regions),
    "layers": (LAYERS, _traced),
    "curves": (CURVES, _traced),
    "simplification": (SIMPLIFICATION, _simplified),
    "drawing": (DRAWING, _drawn),
    "cutting": (CUTTING, _parts),
    "mono": (MONO, lambda subject: _values(mono_tracing(subject.pixels).scene)),
}
"""The numbers of each stage, and the result that they decide."""


@dataclass(frozen=True)
class Reach:
    """How far a number can move: the last factor without a change, and what the next one changes.

    Attributes:
        factor: 1 if the first step changes a result; infinity if none does.
        change: what differs then: pictures, or bytes and decibels of a file.
    """

    factor: float
    change: str


def files_of(subject: Subject) -> Drawing:
    """Return the drawing of a file."""
    return draw_picture(subject.request)


def digest(values: list[Any]) -> str:
    """Return a digest of arrays and words."""
    found = hashlib.sha256()
    for value in values:
        found.update(value.tobytes() if isinstance(value, np.ndarray) else str(value).encode())
    return found.hexdigest()


@contextmanager
def changed(record: Any, name: str, value: Any) -> Iterator[None]:
    """Give the field ``name`` of a frozen record another value for a while, for all modules that hold the record."""
    before = getattr(record, name)
    object.__setattr__(record, name, value)
    try:
        yield
    finally:
        object.__setattr__(record, name, before)


def moved(value: Any, factor: float) -> Any:
    """Return a number, or each of a tuple of numbers, times ``factor``; whole numbers move by one at least."""
    if isinstance(value, tuple):
        return tuple(moved(each, factor) for each in value)
    if isinstance(value, int):
        return max(round(value * factor), value + 1) if factor > 1 else max(0, min(round(value * factor), value - 1))
    return value * factor


class Sweep:
    """The sweep of one stage over some pictures."""

    def __init__(self, stage: str, subjects: list[Subject], is_whole: bool) -> None:
        self.record, self._result = STAGES[stage]
        self._subjects, self._is_whole = subjects, is_whole
        self._before = [self._measured(subject) for subject in subjects]

    def reach(self, name: str, up: bool) -> Reach:
        """Return how far a number can move up or down. If the farthest step changes nothing, no other is tried."""
        if not self._change(name, FACTORS[-1] if up else 1 / FACTORS[-1]):
            return Reach(math.inf, "")
        last = 1.0
        for factor in FACTORS:
            found = self._change(name, factor if up else 1 / factor)
            if found:
                return Reach(last, found)
            last = factor
        return Reach(last, "")

    def _change(self, name: str, factor: float) -> str:
        """Return what differs in the first picture that differs; nothing if none does."""
        with changed(self.record, name, moved(getattr(self.record, name), factor)):
            for subject, before in zip(self._subjects, self._before, strict=True):
                try:
                    after = self._measured(subject)
                except (ValueError, IndexError, ArithmeticError, np.linalg.LinAlgError) as error:
                    return type(error).__name__
                if after[0] != before[0]:
                    bytes_, decibels = after[1] - before[1], after[2] - before[2]
                    return f"{subject.name} {bytes_:+d} B {decibels:+.2f} dB" if self._is_whole else subject.name
        return ""

    def _measured(self, subject: Subject) -> tuple[str, int, float]:
        """Return a digest of the result, and with files their bytes and PSNR."""
        if not self._is_whole:
            return digest(self._result(subject)), 0, 0.0
        drawing = files_of(subject)
        return digest([drawing.text]), len(drawing.text.encode()), drawing.psnr


def row(name: str, value: Any, down: Reach, up: Reach) -> list[str]:
    """Return the cells of a number."""
    shown = f"{value:.4g}" if isinstance(value, float) else str(value)
    cells = ["any" if math.isinf(each.factor) else f"{each.factor:g}" for each in (down, up)]
    return [name, shown, cells[0], cells[1], down.change, up.change]


@click.command(help=__doc__.split("\n\n", maxsplit=1)[0])
@click.argument("folder", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--stage", type=click.Choice(list(STAGES)), default="mode_choice", help="Stage whose numbers are moved.")
@click.option("--field", "part", default="", help="Only numbers whose name has this part.")
@click.option("--size", default=96, help="Longer side of the pictures in pixels.")
@click.option("--limit", default=4, help="Most pictures, the first by name.")
@click.option("--whole", is_flag=True, help="Compare whole files, with their bytes and PSNR.")
def main(folder: Path, stage: str, part: str, size: int, limit: int, whole: bool) -> None:
    """Print the table of a stage."""
    torch.set_grad_enabled(False)
    paths = [path for path in sorted(folder.iterdir()) if path.suffix.lower() in SUFFIXES][:limit]
    if not paths:
        raise click.UsageError(f"no pictures in {folder}")
    sweep = Sweep(stage, [Subject.of(path, size) for path in paths], whole)
    names = [field.name for field in fields(sweep.record) if part in field.name]
    rows = []
    for count, name in enumerate(names, 1):
        click.echo(f"{count} of {len(names)}: {name}", err=True)
        rows.append(row(name, getattr(sweep.record, name), sweep.reach(name, up=False), sweep.reach(name, up=True)))
    click.echo(f"{stage}, {len(paths)} pictures of {folder} at {size} px\n")
    click.echo(markdown_table(["number", "value", "down by", "up by", "change below", "change above"], rows))
    click.echo(machine_line(machine_facts()))


if __name__ == "__main__":
    main()
