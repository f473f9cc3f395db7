"""Compare what our drawings and the designers' own files take to say the same picture, in nats.

    python bench/price.py FOLDER [--size 512] [--limit 20]

FOLDER holds SVGs, or folders of them. A drawing costs the nats of its words (`warpvec.flat.price`) and of what it
leaves of the picture (`warpvec.flat.evidence`). Where the designer's file is cheaper, our search has failed; where
it is dearer, a price may be wrong.
"""

from __future__ import annotations

import re
from pathlib import Path

import click
import numpy as np
from flat_originals import Original
from gate_measures import count_words
from harness import machine_facts, machine_line, markdown_table

import warpvec
from warpvec.flat.evidence.evidence import Evidence
from warpvec.flat.price import Words
from warpvec.svg.measure import draw

_PAINT = re.compile(r"""\b(?:fill|stroke|stop-color)\s*[:=]\s*["']?\s*(#[0-9a-fA-F]+|rgb\([^)]*\)|[a-zA-Z]+)""")
_NO_PAINTS = {"none", "url", "inherit", "currentColor", "transparent"}


def nats_of(svg: str, evidence: Evidence) -> tuple[float, float]:
    """Return the nats of the words of ``svg``, and of what it leaves of the picture of ``evidence``."""
    height, width = evidence.levels.shape[:2]
    colors = [color for color in _PAINT.findall(svg) if color not in _NO_PAINTS]
    count = len(set(colors))
    words = Words(count_words(svg).parameters, count, len(colors) - count)
    return words.nats(max(width, height)), float(evidence.misfit(draw(svg, width, height).astype(np.float64)).sum())


@click.command()
@click.argument("folder", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--size", default=512, show_default=True, help="Longest side in px of the pictures.")
@click.option("--limit", default=0, help="Most files; 0 for all.")
def main(folder: Path, size: int, limit: int) -> None:
    """Print both costs of each SVG of FOLDER, and how often each is the lower one."""
    rows, cheaper = [], 0
    for path in sorted(folder.rglob("*.svg"))[: limit or None]:
        original = Original(path.stem, path.read_text())
        picture = original.drawn(size)
        evidence = Evidence.of((picture / 255.0).astype(np.float32))
        own = nats_of(warpvec.vectorize(picture).svg(), evidence)
        theirs = nats_of(original.text, evidence)
        cheaper += sum(theirs) < sum(own)
        rows.append([original.name, *(f"{each:,.0f}" for each in (*own, *theirs))])
    click.echo(markdown_table(["drawing", "our words", "our misfit", "the designer's words", "their misfit"], rows))
    click.echo(f"the designer's file is cheaper for {cheaper} of {len(rows)}")
    click.echo(machine_line(machine_facts("cpu")))


if __name__ == "__main__":
    main()
