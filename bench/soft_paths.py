"""Measure what the soft paths of a photo's drawing cost, and what they do to its rings.

Compared are the drawing and the same without its filters: a step of the fit, Chromium's time to draw the file at one
and two pixels per unit, and rings: how much steps of colour show where the photo is smooth. All are taken in turns.

    python bench/soft_paths.py DRAWING.svg PHOTO
"""

from __future__ import annotations

import os
import re
import shutil
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median
from typing import Any

import click
import imageio.v3 as iio
import numpy as np
import torch
from harness import machine_facts, machine_line, markdown_table
from numpy.typing import NDArray
from page_frames import NAMES
from scipy.ndimage import gaussian_filter, maximum_filter

from warpvec.config.fit_config import FitConfig
from warpvec.fit.loop import single_torch_thread
from warpvec.fit.target import Target
from warpvec.svg.measure import draw
from warpvec.svg.read import read_svg

LAPS = 12

NOISE_SIGMA, SMOOTH_MAX, SMOOTH_REACH = 2.0, 0.5, 9
"""A photo is smooth where its second difference, after a blur by so many pixels that takes its noise, is below so many
levels everywhere in a square of so many pixels."""

DRAW = """async ([text, scale, lap]) => {
    const image = new Image();
    image.src = URL.createObjectURL(new Blob([`${text}<!--${lap}-->`], { type: "image/svg+xml" }));
    await image.decode();
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [image.width * scale, image.height * scale];
    const context = canvas.getContext("2d", { willReadFrequently: true });
    const before = performance.now();
    context.drawImage(image, 0, 0, canvas.width, canvas.height);
    context.getImageData(0, 0, 1, 1);
    return performance.now() - before;
}"""

Image = NDArray[np.floating[Any]]


def second_difference(image: Image) -> Image:
    """Return the absolute second differences of the grey levels of ``image`` [h, w, 3], across and down [h, w]."""
    gray = np.pad(image.astype(np.float64).mean(2), 1, mode="edge")
    inner = 2.0 * gray[1:-1, 1:-1]
    across, down = gray[1:-1, :-2] - inner + gray[1:-1, 2:], gray[:-2, 1:-1] - inner + gray[2:, 1:-1]
    return (np.abs(across) + np.abs(down)) / 2.0


def smooth_parts(photo: Image) -> NDArray[np.bool_]:
    """Return the pixels [h, w] around which ``photo`` [h, w, 3] changes evenly, apart from its noise."""
    calm: Image = gaussian_filter(photo.astype(np.float64), (NOISE_SIGMA, NOISE_SIGMA, 0.0))
    found: NDArray[np.bool_] = maximum_filter(second_difference(calm), SMOOTH_REACH) < SMOOTH_MAX
    return found


def in_turns(actions: list[Callable[[int], float]]) -> list[float]:
    """Return the median of the times that each of the ``actions`` returns."""
    times = [[action(lap) for action in actions] for lap in range(LAPS)]
    return [median(each) for each in zip(*times, strict=True)]


def step_times(texts: list[str], photo: Image) -> list[float]:
    """Return the milliseconds of a step of a fit to ``photo`` for each drawing."""
    target = Target(torch.from_numpy(np.ascontiguousarray(photo, np.float32) / 255.0), FitConfig(threads=1), "cpu")

    def timed(text: str) -> Callable[[int], float]:
        scene = read_svg(text).scene

        def step(_: int) -> float:
            before = time.perf_counter()
            with single_torch_thread():  # as in a fit
                target.fit_step(scene, False)
            return 1000.0 * (time.perf_counter() - before)

        return step

    return in_turns([timed(text) for text in texts])


def browser_times(texts: list[str], scales: tuple[int, ...]) -> list[list[float]]:
    """Return the milliseconds that Chromium takes to draw each file at each of the ``scales``."""
    from playwright.sync_api import sync_playwright

    chromium = os.environ.get("WARPVEC_CHROMIUM") or next(filter(None, map(shutil.which, NAMES)), None)
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=chromium)
        page = browser.new_page()

        def drawn(text: str, scale: int) -> Callable[[int], float]:
            return lambda lap: float(page.evaluate(DRAW, [text, scale, lap]))

        found = [in_turns([drawn(text, scale) for text in texts]) for scale in scales]
        browser.close()
    return found


@click.command()
@click.argument("drawing", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.argument("photo", type=click.Path(exists=True, dir_okay=False, path_type=Path))
def main(drawing: Path, photo: Path) -> None:
    """Compare the soft DRAWING of PHOTO with the same without its filters."""
    soft, pixels = drawing.read_text(encoding="utf-8"), np.asarray(iio.imread(photo))[..., :3]
    sharp = re.sub(r' filter="url\(#[^)]*\)"', "", soft)
    height, width = pixels.shape[:2]
    rows = [["step, ms", *step_times([soft, sharp], pixels)]]
    scales = (1, 2)
    for scale, times in zip(scales, browser_times([soft, sharp], scales), strict=True):
        rows.append([f"Chromium at {scale} px per unit, ms", *times])
    smooth = smooth_parts(pixels)
    rings = [second_difference(draw(text, width, height)[..., :3])[smooth].mean() for text in (soft, sharp)]
    click.echo(machine_line(machine_facts()))
    count = soft.count(" filter=")
    click.echo(f"{count} of {soft.count('<path')} paths are soft; the photo is smooth on {100 * smooth.mean():.0f} %")
    lines = [[name, f"{a:.1f}", f"{b:.1f}", f"{a / b:.2f}"] for name, a, b in rows]
    lines.append(["rings, levels", *(f"{each:.3f}" for each in rings), f"{rings[0] / rings[1]:.2f}"])
    lines.append(["rings of the photo", f"{second_difference(pixels)[smooth].mean():.3f}", "", ""])
    click.echo(markdown_table(["", "soft", "without filters", "ratio"], lines))


if __name__ == "__main__":
    main()
