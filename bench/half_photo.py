"""Measure which mode auto chooses for pictures that are half photo, for photos, and for drawings.

Each photo becomes an oval on white in three sizes and a picture on a card in three forms, as it is and as JPEG of
quality 80. Photos and drawings also stay as they are:

    python bench/half_photo.py ../shared/data/kodak ../shared/data/flat

A photo or an oval of one is wrong as flat art; a card should be mixed; a drawing should be neither mixed nor a photo.
Where auto is in doubt, it draws flat art first, and keeps it only if it explains the picture: "flat, in doubt".
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterator
from pathlib import Path

import click
import numpy as np
from flat_methods import over_white
from gate_damage import saved
from PIL import Image, ImageDraw
from PIL.Image import Resampling

from warpvec.config.presets import make_config
from warpvec.flat.mode_choice import ModeChoice
from warpvec.modes.choice import suited_mode
from warpvec.modes.request import Request
from warpvec.modes.restored import Restoration

SIDES = (128, 192, 256)
FORMS = ("rectangle", "round corners", "ellipse")
QUALITY = 80


def cropped(photo: Image.Image, size: tuple[int, int]) -> Image.Image:
    """Return the middle of ``photo``, reduced to ``size``."""
    scale = max(size[0] / photo.width, size[1] / photo.height)
    width, height = size[0] / scale, size[1] / scale
    left, top = (photo.width - width) / 2, (photo.height - height) / 2
    return photo.resize(size, Resampling.LANCZOS, (left, top, left + width, top + height))


def stencil(form: str, size: tuple[int, int]) -> Image.Image:
    """Return how much of each pixel a ``form`` of this ``size`` covers."""
    large = Image.new("L", (4 * size[0], 4 * size[1]))
    pen, box = ImageDraw.Draw(large), (0, 0, 4 * size[0] - 1, 4 * size[1] - 1)
    draw = {"rectangle": pen.rectangle, "ellipse": pen.ellipse}
    if form in draw:
        draw[form](box, fill=255)
    else:
        pen.rounded_rectangle(box, 64, fill=255)
    return large.resize(size, Resampling.BOX)


def oval(photo: Image.Image, side: int) -> Image.Image:
    """Return an oval of ``photo`` on white."""
    size = (round(0.94 * side), round(0.7 * side))
    page = Image.new("RGB", (side, side), "white")
    page.paste(cropped(photo, size), ((side - size[0]) // 2, (side - size[1]) // 2), stencil("ellipse", size))
    return page


def card(photo: Image.Image, drawing: Image.Image, form: str, ground: str) -> Image.Image:
    """Return a card with ``photo``, a ``drawing``, lines of text and a button."""
    page = Image.new("RGB", (512, 400), ground)
    small = drawing.convert("RGBA").resize((120, 120), Resampling.LANCZOS)
    page.paste(small, (20, 20), small)
    pen = ImageDraw.Draw(page)
    for row, words in enumerate(("Ferry terminal", "Open daily 9 to 17", "Tickets from 12.50")):
        pen.text((20, 170 + 30 * row), words, fill="white" if ground == "#203050" else "#222222")
    pen.rounded_rectangle((20, 330, 180, 370), 8, fill="#e0433a")
    size = (280, 200)
    page.paste(cropped(photo, size), (220, 40), stencil(form, size))
    return page


def copies(photos: list[Path], drawings: list[Path]) -> Iterator[tuple[str, str, Image.Image]]:
    """Yield the kind, the name and the picture of each copy."""
    grounds = ("white", "#f4f4f8", "#203050", "#fff4e0")
    for number, path in enumerate(photos):
        photo = Image.open(path).convert("RGB")
        yield "photo", path.stem, photo
        for side in SIDES:
            yield "oval", f"{path.stem} {side} px", oval(photo, side)
        drawing, form = Image.open(drawings[number % len(drawings)]), FORMS[number % len(FORMS)]
        yield "card", f"{path.stem} {form}", card(photo, drawing, form, grounds[number % len(grounds)])
    for path in drawings:
        yield "drawing", path.stem, over_white(path)


def choice_of(image: Image.Image) -> tuple[Request, Restoration, ModeChoice]:
    """Return a request for ``image``, what was done to it, and the mode that auto chooses before it draws."""
    request = Request.of(np.asarray(image, np.float32) / 255.0, make_config())
    found = Restoration.of(request)
    return request, found, suited_mode(found.request, found.condition)[0]


def chosen(image: Image.Image) -> str:
    """Return the mode that auto chooses for ``image``."""
    choice = choice_of(image)[2]
    return choice.mode + (", in doubt" if choice.is_doubtful else "")


def is_right(kind: str, mode: str) -> bool:
    """Return whether ``mode`` suits a picture of this ``kind``; in doubt, flat art is refused where it does not."""
    wanted = {
        "photo": ("photo", "flat, in doubt"), "oval": ("mixed", "photo", "flat, in doubt"), "card": ("mixed",),
        "drawing": ("flat", "flat, in doubt", "mono", "pixel"),
    }  # fmt: skip
    return mode in wanted[kind]


_FOLDER = click.Path(exists=True, file_okay=False, path_type=Path)


@click.command()
@click.argument("photos", metavar="PHOTOS", type=_FOLDER)
@click.argument("drawings", metavar="DRAWINGS", type=_FOLDER)
def main(photos: Path, drawings: Path) -> None:
    """Print the modes of all copies that are wrong, and how often each mode was chosen."""
    counts: dict[str, Counter[str]] = defaultdict(Counter)
    wrong: Counter[str] = Counter()
    for kind, name, image in copies(sorted(photos.glob("*.png")), sorted(drawings.glob("*.png"))):
        for suffix, shown in (("", image), (" as JPEG", saved(image, "JPEG", quality=QUALITY))):
            mode = chosen(shown)
            counts[kind + suffix][mode] += 1
            if not is_right(kind, mode):
                wrong[kind + suffix] += 1
                click.echo(f"{kind + suffix} {name}: {mode}")
    for kind, found in counts.items():
        modes = ", ".join(f"{count} {mode}" for mode, count in found.most_common())
        click.echo(f"{kind}: {wrong[kind]} of {found.total()} wrong ({modes})")


if __name__ == "__main__":
    main()
