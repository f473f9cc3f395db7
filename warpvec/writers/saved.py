"""Make the file of a drawing's text, and say what it cannot show: for the page, and in the words of all summaries."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from warpvec.checks import counted
from warpvec.purposes.table import PURPOSES
from warpvec.writers.registry import encode, writer_of
from warpvec.writers.writer import DEFAULT_TARGET, Target


class Saved(NamedTuple):
    """The bytes of a file, and a sentence for each thing that it draws by other means or not at all."""

    data: bytes
    losses: list[str]


def saved(text: str, path: str, target: Target = DEFAULT_TARGET, purpose: str | None = None) -> Saved:
    """Return the file ``path`` of the SVG ``text`` for a ``purpose``, by default that of its kind.

    A drawing of another program stays as it is for print: CairoSVG knows more of it than warpvec does.

    Raises:
        InputError: the text cannot be read or written so, or a package is missing.
    """
    from warpvec.purposes.texts import text_for  # not above: they load Torch, which the help does without
    from warpvec.svg.read import read_svg

    writer = writer_of(path)
    name, words = purpose or writer.purpose, list[str]()
    if name == "web" and writer.draws_blur:
        return Saved(encode(text, path, target), [])
    loaded = read_svg(text) if "<feGaussianBlur" in text else None
    soft_count = 0 if loaded is None else loaded.scene.soft_count
    is_for_print = purpose is None and name == "print"
    if not is_for_print or (loaded is not None and soft_count and loaded.precision is not None):
        text, words = text_for(text, PURPOSES[name])
    return Saved(encode(text, path, target), losses(path, name, words, soft_count))


def losses(path: str, purpose: str, replaced: Sequence[str], soft_count: int) -> list[str]:
    """Return what the file ``path`` draws by other means, or cannot show, a sentence each.

    Args:
        path: the file; its suffix names its kind.
        purpose: what it is for.
        replaced: what was drawn by other means for that, in words.
        soft_count: number of soft paths of the drawing.
    """
    found = [f"for {purpose}: {'; '.join(replaced)}"] if replaced else []
    writer = writer_of(path)
    if soft_count and not writer.draws_blur:
        found.append(f"not kept in {writer.suffix}: the blur of {counted(soft_count, 'soft path')}")
    return found
