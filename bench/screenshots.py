"""Count what is falsely found in screenshots of browsers: reductions, enlargements, noise, JPEG and blur.

    python bench/screenshots.py

The 16 pages of `bench/browser_pages.py` are shown by Chromium and Firefox (Debian's packages chromium and firefox-esr)
at the zooms 1 and 1.25. Nothing has happened to these 64 pictures. A browser that is not there is left out.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from pathlib import Path

import click
import numpy as np
from browser_pages import PAGES
from harness import markdown_table
from PIL import Image

from warpvec.condition.condition import measure_condition

ZOOMS = (1.0, 1.25)
_FAULTS = ("reduced", "enlarged", "noise", "JPEG", "blur")
_SECONDS = 60
_SIZE = (1000, 700)

_COMMANDS = {
    "Chromium": (
        "chromium --headless --no-sandbox --disable-gpu --hide-scrollbars --user-data-dir={profile} "
        "--window-size={w},{h} --screenshot={out} file://{page}"
    ),
    "Firefox": (
        "firefox-esr --no-remote --headless --profile {profile} --window-size={w},{h} --screenshot {out} file://{page}"
    ),
}
_IN_CONTAINERS = {f"MOZ_DISABLE_{each}_SANDBOX": "1" for each in ("CONTENT", "GMP", "RDD", "SOCKET_PROCESS")}
"""Firefox hangs without these where it may not make namespaces."""


def screenshot(browser: str, text: str, folder: Path) -> Image.Image:
    """Return the picture of a page's ``text``."""
    page, out, profile = folder / "page.html", folder / "page.png", folder / browser
    page.write_text(text)
    profile.mkdir(exist_ok=True)
    out.unlink(missing_ok=True)
    values = {"page": page, "out": out, "profile": profile, "w": _SIZE[0], "h": _SIZE[1]}
    words = [word.format(**values) for word in _COMMANDS[browser].split()]
    subprocess.run(words, check=True, capture_output=True, timeout=_SECONDS, env={**os.environ, **_IN_CONTAINERS})
    with Image.open(out) as image:
        return image.convert("RGB")


@click.command()
def main() -> None:
    """Print what is found in each picture, and a table of counts."""
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for browser, command in _COMMANDS.items():
            if shutil.which(command.split()[0]) is None:
                click.echo(f"{browser} is not installed", err=True)
                continue
            counts = dict.fromkeys(_FAULTS, 0)
            for name, make in PAGES.items():
                for zoom in ZOOMS:
                    image = screenshot(browser, make().replace("ZOOM", f"{zoom:g}"), Path(folder))
                    found = measure_condition(np.asarray(image, np.float32) / np.float32(255.0))
                    click.echo(f"{browser} {zoom:g} {name}: {found.words}", err=True)
                    for fault in counts:
                        counts[fault] += fault in (found.words or "")
            rows.append([browser, str(len(ZOOMS) * len(PAGES)), *map(str, counts.values())])
    click.echo(markdown_table(["browser", "pictures", *_FAULTS], rows))


if __name__ == "__main__":
    main()
