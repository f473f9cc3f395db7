"""Damaged SVGs, bombs, and files that point at other files, through everything in warpvec that reads an SVG."""

from __future__ import annotations

import ctypes
import os
import struct
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from random import Random

import numpy as np
import torture_svg_files as files
from numpy.typing import NDArray
from torture_case import OK, Case, Wrong
from torture_changes import mutate

_IN_OPEN = 0x20
"""The event of inotify(7) that a file was opened."""


def case(chance: Random) -> Case:
    """Return the reading of one SVG by one reader."""
    make = chance.choices([_damaged, files.bomb, _link], [6, 3, 1])[0]
    name, data = make(chance)
    how = chance.choices(list(READERS), list(_CHANCES))[0]
    return Case(f"{name}, {how}", lambda folder: check(data, folder, how), data)


def check(data: bytes, folder: Path, how: str) -> str:
    """Read ``data`` with one of the `READERS`.

    Raises:
        Wrong: a file beside the drawing was opened.
    """
    _plant(folder)
    with _watched(folder):
        READERS[how](data, folder)
    return OK


def _damaged(chance: Random) -> tuple[str, bytes]:
    seeds = files.seeds()
    others = [*seeds, files.bomb(chance)[1][:1000]] if chance.random() < 0.1 else seeds
    return "damaged", mutate(chance.choice(seeds), chance, others)


def _link(chance: Random) -> tuple[str, bytes]:
    return "link", files.link(chance)


def _plant(folder: Path) -> None:
    """Write the file that nobody may open, also under the paths that begin like a fragment or a data URL."""
    for name in (files.PLANTED, "#" + files.PLANTED):
        (folder / name).write_bytes(_picture_file())
    for name in ("#", "data:", " data:", "DATA:"):
        (folder / name).mkdir()


@contextmanager
def _watched(folder: Path) -> Iterator[None]:
    """Raise `Wrong` if any process opens a file that was planted in ``folder``."""
    libc = ctypes.CDLL(None, use_errno=True)
    watch = libc.inotify_init1(os.O_NONBLOCK | os.O_CLOEXEC)
    try:
        if watch < 0 or libc.inotify_add_watch(watch, os.fsencode(folder), _IN_OPEN) < 0:
            raise OSError(ctypes.get_errno(), "inotify")
        yield
        if opened := [name for name in _opened(watch) if name.endswith(files.PLANTED)]:
            raise Wrong(f"the file {opened[0]} was opened")
    finally:
        os.close(watch)


def _opened(watch: int) -> Iterator[str]:
    """Yield the names of the files that were opened: each event has 16 bytes and a padded name."""
    while True:
        try:
            events = os.read(watch, 65536)
        except BlockingIOError:
            return
        while events:
            (length,) = struct.unpack_from("I", events, 12)
            yield events[16 : 16 + length].rstrip(b"\0").decode()
            events = events[16 + length :]


@cache
def _photo() -> NDArray[np.float32]:
    return np.random.default_rng(0).random((24, 32, 3), np.float32)


@cache
def _picture_file() -> bytes:
    from torture_image_files import seeds

    return seeds("png")[0]


def _read_and_write(data: bytes, folder: Path) -> None:
    from warpvec.svg.read import read_svg
    from warpvec.svg.write import write_svg

    drawing = read_svg(data)
    if not all(values.isfinite().all() for values in (drawing.scene.points, drawing.scene.color)):
        raise Wrong("a scene that is not finite")
    write_svg(drawing.scene, 64, 64)


def _facts(data: bytes, folder: Path) -> None:
    from warpvec.svg.measure import file_facts

    file_facts(data)


def _draw(data: bytes, folder: Path) -> None:
    from warpvec.svg.measure import draw

    draw(data)


def _evaluate(data: bytes, folder: Path) -> None:
    from warpvec.svg.measure import evaluate

    evaluate(data, _photo())


def _evaluate_large(data: bytes, folder: Path) -> None:
    from warpvec.svg.measure import evaluate

    evaluate(data, np.resize(_photo(), (768, 1024, 3)))


def _levels(data: bytes, folder: Path) -> None:
    from warpvec.svg.document import parse_svg
    from warpvec.svg.layers import prefixes, select_levels

    for number, (level, text) in enumerate(prefixes(data)):
        parse_svg(text)
        if number == 0:
            parse_svg(select_levels(data, {level}))
        if number == 3:  # a file of many levels has a text as long for each
            break


def _page(data: bytes, folder: Path) -> None:
    from warpvec.viewer.page import write_page

    write_page(folder / "page.html", data)
    if b"<script" not in (folder / "page.html").read_bytes():
        raise Wrong("a page without scripts")


def _page_with_photo(data: bytes, folder: Path) -> None:
    from warpvec.viewer.page import write_page

    write_page(folder / "page.html", data, photo=_photo())


def _refine(data: bytes, folder: Path) -> None:
    from warpvec import refine

    text = refine(_photo(), data, iterations=3, threads=1).svg()
    _facts(text.encode(), folder)


READERS: dict[str, Callable[[bytes, Path], None]] = {
    "read_svg and write_svg": _read_and_write,
    "file_facts": _facts,
    "draw": _draw,
    "evaluate": _evaluate,
    "evaluate at a large size": _evaluate_large,
    "levels": _levels,
    "page": _page,
    "page with photo": _page_with_photo,
    "refine": _refine,
}
"""Name of a reader -> what it does with the bytes of a file."""

_CHANCES = (8, 3, 3, 2, 1, 2, 2, 1, 2)
"""Share of the cases that each of the `READERS` has: drawing in a child process takes a tenth of a second and more."""
