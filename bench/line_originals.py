"""Originals of drawings of lines: icons whose files are strokes, and the letters of Hershey."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from flat_originals import Original

SIDE = 512
"""Width and height of letters in pixels."""

MARGIN = 48
"""Least distance of a letter from the edge."""

WIDTH = 14
"""Width of the lines of letters in pixels."""

_FIRST = 32
"""Character of the first glyph of a file of Hershey's."""

_ORIGIN = ord("R")
"""Character that stands for the coordinate 0."""

Glyph = list[list[tuple[int, int]]]


def spread(folder: Path, count: int) -> list[Original]:
    """Return ``count`` SVGs of ``folder``, spread evenly over their names."""
    paths = sorted(folder.glob("*.svg"))
    chosen = paths[:: max(len(paths) // count, 1)][:count]
    return [Original(path.stem, path.read_text()) for path in chosen]


def letters(font: Path, characters: str) -> list[Original]:
    """Return drawings of ``characters`` in a ``font`` of Hershey's."""
    glyphs = list(read_glyphs(font.read_text()))
    return [Original(f"{font.stem}-{ord(c):03d}", _drawn(glyphs[ord(c) - _FIRST])) for c in characters]


def read_glyphs(text: str) -> Iterator[Glyph]:
    """Yield the lines of each glyph of a file in the format jhf."""
    lines = iter(text.splitlines())
    for line in lines:
        if not line.strip():
            continue
        count = int(line[5:8])
        data = line[8:]
        while len(data) < 2 * count:
            data += next(lines)
        pairs = [data[k : k + 2] for k in range(2, 2 * count, 2)]
        glyph: Glyph = [[]]
        for pair in pairs:
            if pair == " R":
                glyph.append([])
            else:
                glyph[-1].append((ord(pair[0]) - _ORIGIN, ord(pair[1]) - _ORIGIN))
        yield [stroke for stroke in glyph if stroke]


def _drawn(glyph: Glyph) -> str:
    xs, ys = [x for stroke in glyph for x, _ in stroke], [y for stroke in glyph for _, y in stroke]
    scale = (SIDE - 2 * MARGIN) / max(max(xs) - min(xs), max(ys) - min(ys), 1)
    left, top = (SIDE / 2 - scale * (max(values) + min(values)) / 2 for values in (xs, ys))
    data = "".join("M" + "L".join(f"{left + scale * x:.2f},{top + scale * y:.2f}" for x, y in s) for s in glyph)
    head = f'<svg xmlns="http://www.w3.org/2000/svg" width="{SIDE}" height="{SIDE}" viewBox="0 0 {SIDE} {SIDE}">'
    look = f'fill="none" stroke="#000" stroke-width="{WIDTH}" stroke-linecap="round" stroke-linejoin="round"'
    return f'{head}<path d="{data}" {look}/></svg>'
