"""Count the modes that auto ends with for copies of drawings and photos: in sizes, formats and damage of all kinds.

    python bench/strangers.py DRAWINGS PHOTOS

The folders hold PNG files, or folders of them. Each picture becomes ten copies; a photo three ovals on white, too. Flat
art is drawn in full, as auto may refuse it afterwards. A drawing is wrong as a photo or mixed; a photo is wrong
as anything else than a photo or mixed; an oval is wrong as flat art.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import click
import numpy as np
from flat_methods import over_white
from gate_damage import blur, noise, saved
from half_photo import SIDES, choice_of, oval
from PIL import Image
from PIL.Image import Resampling

from warpvec.drawing.drawing import Drawing
from warpvec.modes.choice import draw_picture
from warpvec.modes.photo import Photo
from warpvec.modes.request import Request


class PhotoChosen(Exception):
    """Auto has chosen the mode photo."""


@dataclass(frozen=True)
class UndrawnPhoto(Photo):
    """The mode photo, without its fit."""

    def draw(self, request: Request) -> Drawing:
        """Tell that this mode was chosen."""
        raise PhotoChosen


def reduced(image: Image.Image, side: int) -> Image.Image:
    """Return ``image`` with a longest side of at most ``side`` px."""
    small = image.copy()
    small.thumbnail((side, side), Resampling.LANCZOS)
    return small


def changed(image: Image.Image, damage: Callable[..., np.ndarray]) -> Image.Image:
    """Return ``image`` after ``damage`` of its levels."""
    return Image.fromarray(damage(np.asarray(image)))


COPIES: dict[str, Callable[[Image.Image], Image.Image]] = {
    "64 px": lambda image: reduced(image, 64),
    "128 px": lambda image: reduced(image, 128),
    "256 px": lambda image: reduced(image, 256),
    "JPEG 80": lambda image: saved(reduced(image, 300), "JPEG", quality=80),
    "JPEG 50": lambda image: saved(reduced(image, 200), "JPEG", quality=50),
    "GIF": lambda image: saved(reduced(image, 200), "GIF"),
    "gray": lambda image: reduced(image, 200).convert("L").convert("RGB"),
    "blurred": lambda image: changed(reduced(image, 256), blur),
    "noisy": lambda image: changed(reduced(image, 256), noise),
    "enlarged": lambda image: reduced(image, 100).resize((300, round(300 * image.height / image.width))),
}


def mode_of(image: Image.Image) -> str:
    """Return the mode that auto ends with for ``image``."""
    request, found, choice = choice_of(image)
    if choice.mode == "mixed":  # whose photos would be fitted
        return choice.mode
    try:
        return draw_picture(request, UndrawnPhoto(), known=found).encoding.settings.mode
    except PhotoChosen:
        return "photo"


def copies(kind: str, paths: list[Path]) -> Iterator[tuple[str, str, Image.Image]]:
    """Yield the kind, the name and the picture of each copy of the pictures of one kind."""
    for path in paths:
        image = over_white(path)
        for name, copy in COPIES.items():
            yield kind, f"{path.stem} {name}", copy(image)
        for side in SIDES if kind == "photo" else ():
            yield "oval", f"{path.stem} {side} px", oval(image, side)


RIGHT = {
    "drawing": ("flat", "mono", "pixel", "lines"),
    "photo": ("photo", "mixed"),
    "oval": ("photo", "mixed"),
}

_FOLDER = click.Path(exists=True, file_okay=False, path_type=Path)


@click.command()
@click.argument("drawings", metavar="DRAWINGS", type=_FOLDER)
@click.argument("photos", metavar="PHOTOS", type=_FOLDER)
def main(drawings: Path, photos: Path) -> None:
    """Print the mode of each copy for which it is wrong, and how many there are of each kind."""
    counts: Counter[str] = Counter()
    wrong: Counter[str] = Counter()
    for kind, folder in (("photo", photos), ("drawing", drawings)):
        for kind_of_copy, name, image in copies(kind, sorted(folder.rglob("*.png"))):
            mode = mode_of(image)
            counts[kind_of_copy] += 1
            if mode not in RIGHT[kind_of_copy]:
                wrong[kind_of_copy] += 1
                click.echo(f"{kind_of_copy} {name}: {mode}")
    for kind, count in counts.items():
        click.echo(f"{kind}: {wrong[kind]} of {count} wrong")


if __name__ == "__main__":
    main()
