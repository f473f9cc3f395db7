"""Find cliffs of flat art: neighbouring pictures of one drawing, of which one is drawn in another way.

    python bench/cliffs.py [FOLDER] [--sides 96:102,127:129] [--damage png,q70,n1] [--json OUT.json]

Drawings of our own, and the SVGs of FOLDER, are drawn at sides that lie next to each other, as PNG and with damage: a
JPEG of some quality (q70), noise of some levels (n1), gamma 1.02, mirrored, transposed, inverted. A jump is another
mode, or a count of paths or parameters that changes by more than 1.5 times between neighbours.
"""

from __future__ import annotations

import io
import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from itertools import pairwise
from pathlib import Path

import click
import numpy as np
from flat_originals import Original, Pixels
from gate_measures import count_words
from harness import comma_separated, machine_facts, machine_line
from PIL import Image

import warpvec

JUMP = 1.5
"""Factor between neighbours from which on a count has jumped."""

_HEAD = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 128 128" width="128" height="128">'
OWN = {
    "gradient": """<defs><linearGradient id="g" x2="1" y2="1"><stop stop-color="#ffb347"/><stop offset="1"
        stop-color="#d1345b"/></linearGradient></defs><rect width="128" height="128" fill="#f4f1ea"/>
        <rect x="20" y="24" width="88" height="80" rx="12" fill="url(#g)"/>""",
    "shadow": """<defs><filter id="f" x="-.3" y="-.3" width="1.6" height="1.6"><feGaussianBlur stdDeviation="2.5"/>
        </filter></defs><rect width="128" height="128" fill="#f4f1ea"/><rect x="27" y="30" width="72" height="60" rx="8"
        fill-opacity=".35" filter="url(#f)"/><rect x="24" y="24" width="72" height="60" rx="8" fill="#2a6f97"/>""",
    "stroke": """<rect width="128" height="128" fill="#fff"/><path d="M24 96V56a28 28 0 0 1 56 0v16M80 40h24v56"
        fill="none" stroke="#22223b" stroke-width="7" stroke-linecap="round" stroke-linejoin="round"/>""",
    "small part": """<rect width="128" height="128" fill="#386641"/><circle cx="64" cy="64" r="40" fill="#f2e8cf"/>
        <circle cx="50" cy="54" r="4"/><circle cx="78" cy="54" r="4"/><path d="M48 78q16 14 32 0l-4-4q-12 9-24 0z"/>""",
    "three shapes": """<rect width="128" height="128" fill="#fff"/><circle cx="50" cy="50" r="34" fill="#e63946"/>
        <path d="M40 108L76 44L112 108Z" fill="#457b9d"/><rect x="70" y="20" width="40" height="16" fill="#1d3557"/>""",
}
"""Name -> what is drawn in 128 x 128 units."""


@dataclass(frozen=True)
class Seen:
    """How one picture was drawn."""

    name: str
    side: int
    damage: str
    mode: str
    paths: int
    parameters: int

    def jumped(self, other: Seen) -> bool:
        """Return whether ``other``, of a neighbour, is another kind of drawing."""
        counts = ((self.paths, other.paths), (self.parameters, other.parameters))
        return self.mode != other.mode or any(max(pair) > JUMP * max(min(pair), 1) for pair in counts)


def damaged(pixels: Pixels, damage: str) -> Pixels:
    """Return ``pixels`` [h, w, 3] with a ``damage``: png, qN, nN, gamma, mirrored, transposed or inverted."""
    if damage.startswith("q"):
        file = io.BytesIO()
        Image.fromarray(pixels).save(file, "JPEG", quality=int(damage[1:]))
        return np.asarray(Image.open(file))
    if damage.startswith("n"):
        noise = np.random.default_rng(0).normal(0.0, float(damage[1:]), pixels.shape)
        return np.rint(pixels + noise).clip(0, 255).astype(np.uint8)
    changes = {
        "png": pixels,
        "gamma": np.rint(255.0 * (pixels / 255.0) ** 1.02).astype(np.uint8),
        "mirrored": pixels[:, ::-1].copy(),
        "transposed": pixels.transpose(1, 0, 2).copy(),
        "inverted": 255 - pixels,
    }
    if damage not in changes:
        raise click.UsageError(f"damage must be one of {', '.join(changes)}, qN or nN, got {damage!r}")
    return changes[damage]


def sides_of(text: str) -> list[list[int]]:
    """Return runs of neighbouring sides for a ``text`` such as 96:102,127:129."""
    runs = [each.split(":") for each in text.split(",")]
    return [list(range(int(run[0]), int(run[-1]) + 1)) for run in runs]


def seen(originals: list[Original], runs: list[list[int]], damages: list[str]) -> Iterator[list[Seen]]:
    """Yield the neighbours of each run: pictures of one drawing and one damage."""
    for original in originals:
        for damage in damages:
            for run in runs:
                found = []
                for side in run:
                    result = warpvec.vectorize(damaged(original.drawn(side), damage))
                    parameters = count_words(result.svg()).parameters
                    mode = result.metrics["mode"]
                    found.append(Seen(original.name, side, damage, mode, len(result.scene), parameters))
                yield found


@click.command()
@click.argument("folder", required=False, type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--sides", default="96:102,127:129", show_default=True, help="Runs of sides in px.")
@click.option(
    "--damage", default="png,q90,q70,n1", show_default=True, callback=comma_separated, help="Kinds of damage."
)
@click.option("--json", "out", type=click.Path(dir_okay=False, path_type=Path), help="Write what was seen here.")
def main(folder: Path | None, sides: str, damage: list[str], out: Path | None) -> None:
    """Print each jump, and how many of all pairs of neighbours jump."""
    originals = [Original(name, f"{_HEAD}{body}</svg>") for name, body in OWN.items()]
    originals += [Original(path.stem, path.read_text()) for path in sorted(folder.glob("*.svg"))] if folder else []
    everything: list[Seen] = []
    pair_count = jump_count = 0
    for run in seen(originals, sides_of(sides), damage):
        everything += run
        for one, other in pairwise(run):
            pair_count += 1
            if one.jumped(other):
                jump_count += 1
                click.echo(
                    f"{one.name} {one.damage} {one.side} -> {other.side}: "
                    + " -> ".join(
                        f"{each.mode}, {each.paths} paths, {each.parameters} parameters" for each in (one, other)
                    )
                )
    photo_count = sum(each.mode == "photo" for each in everything)
    click.echo(f"{jump_count} of {pair_count} pairs jump; {photo_count} of {len(everything)} are photos")
    click.echo(machine_line(machine_facts("cpu")))
    if out is not None:
        out.write_text(json.dumps([asdict(each) for each in everything]))


if __name__ == "__main__":
    main()
