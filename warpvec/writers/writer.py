"""A writer turns the text of an SVG into the bytes of a file."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

from warpvec.errors import InputError


class Canvas(NamedTuple):
    """The pixels that a drawing is drawn with, for writers of pictures.

    Attributes:
        width, height: size in pixels.
        transparent: whether the picture has alpha instead of white paper.
    """

    width: int
    height: int
    transparent: bool = False


class Target(NamedTuple):
    """What some writers need to know beside the drawing.

    Attributes:
        canvas: the pixels of a picture; None for the size of the drawing.
        splines: whether a file for cutters has splines in place of arcs that are near curves.
        center_lines: whether a file for cutters has strokes as their centre lines in place of both edges; None if the
            mode that the SVG states decides.
        name: name of the file without its suffix, from which a component gets its name.
        per_inch: pixels of a drawing without a size in real units that make an inch.
        world: numbers of a world file, which place the picture on a map; None for none.
    """

    canvas: Canvas | None = None
    splines: bool = False
    center_lines: bool | None = None
    name: str = "drawing"
    per_inch: float = 96.0
    world: tuple[float, ...] | None = None


DEFAULT_TARGET = Target()
"""A picture has the size of the drawing."""


@dataclass(frozen=True)
class Writer:
    """A kind of file.

    Attributes:
        suffix: suffix of the file's name, with its dot, in small letters.
        media_type: type of the file on the web.
        encode: returns the bytes of the file of an SVG text for a target.
        check: raises InputError if a package or library that the writer needs is missing. It gets the path of the file
            and its name in messages.
        draws_blur: whether the file shows the blur of soft paths. Others draw them sharp: a knife cuts no blur.
        purpose: what such a file is for, a key of `warpvec.purposes.table.PURPOSES`.
    """

    suffix: str
    media_type: str
    encode: Callable[[str, Target], bytes]
    check: Callable[[str, str], object] = lambda path, name: None
    draws_blur: bool = True
    purpose: str = "web"


def check_package(package: str, path: str, name: str) -> None:
    """Check that the ``package`` is there that makes the file ``path``; ``name`` is for the message.

    Raises:
        InputError: it is not.
    """
    if find_spec(package) is None:
        rule = f"must end in .svg unless {package} is installed, which writes {Path(path).suffix}"
        raise InputError(name, rule, repr(path), "pip install 'warpvec[cut]'")
