"""Make and keep the fits behind the paper's tables and figures, with their scenes and files.

Every fit is measured twice. "soft" is the scene drawn by the fit's own renderer, which the paper measures. "file" is
the SVG as resvg draws it, which a user gets. Both images have 8 bits and the size of the fitted photo.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

import click
import numpy as np
from bench_scenes import load_scene, save_scene
from fits import InProcess, ResultFile, Row, find_images, fit_key, results_of, warm_up
from harness import source_digest
from looks import NAMES, measures
from numpy.typing import NDArray
from PIL import Image

from warpvec.batch.engines.base import Engine, Report, WorkerShare
from warpvec.config.fit_config import FitConfig
from warpvec.config.presets import make_config
from warpvec.geometry.scene import Scene
from warpvec.image.metrics import psnr, ssim
from warpvec.image.read import read_image
from warpvec.image.write import to_8_bits, write_png
from warpvec.modes.choice import draw_picture
from warpvec.modes.request import Request
from warpvec.rendering.draw import draw_pixels
from warpvec.result import Result
from warpvec.svg.measure import draw
from warpvec.watch.progress import Progress
from warpvec.watch.watch import Watch

Pixels = NDArray[np.uint8]

_MEASURES = tuple(f"{image}_{name}" for image in ("soft", "file") for name in ("psnr", "ssim", *NAMES))

FIELDS = (
    "key", "image", "width", "height", "preset", "curves", "paths", "settings", *_MEASURES,
    "bytes", "iterations", "seconds", "device", "source",
)  # fmt: skip
"""Columns of the CSV. ``paths`` are those of the fitted scene, which may be fewer than ``curves``. ``settings`` are
those that differ from the preset, without the curves; ``seconds`` are those of the fit only."""

# Settings that determine which kernels a fit runs.
_KERNEL_SETTINGS = (
    "renderer", "policy", "device", "path_model", "samples", "lines", "interior_gradient", "covariance_gradient",
    "color_falloff", "side_opacities",
)  # fmt: skip

# Photos are reduced by --scale only.
_WHOLE_PHOTO = {"fit_size": 1_000_000}


@dataclass(frozen=True)
class Photo:
    """A photo of a folder, reduced by the factor ``scale``."""

    path: Path
    scale: float = 1.0

    @property
    def name(self) -> str:
        """File name without its suffix."""
        return self.path.stem

    @property
    def pixels(self) -> Pixels:
        """Pixels [h, w, 3], sRGB-encoded, with 8 bits; reduced with Lanczos-3."""
        return _read_pixels(self.path, self.scale)


@lru_cache(maxsize=4)  # A command uses each photo several times, but a whole folder may not fit in memory.
def _read_pixels(path: Path, scale: float) -> Pixels:
    pixels = to_8_bits(read_image(path))
    if scale == 1.0:
        return pixels
    height, width = (max(1, round(side * scale)) for side in pixels.shape[:2])
    return np.asarray(Image.fromarray(pixels).resize((width, height), Image.Resampling.LANCZOS))


def choose_photos(folder: Path, names: Iterable[str] | None, scale: float) -> list[Photo]:
    """Return the photos of ``folder`` called ``names``, in that order, or all photos if None.

    Raises:
        click.UsageError: there are no photos, or none of that name.
    """
    found = {path.stem: path for path in find_images(folder)}
    for name in names or ():
        if name not in found:
            raise click.UsageError(f"--images must name photos of FOLDER, got {name!r}; choose from {_list(found)}")
    return [Photo(found[name], scale) for name in (found if names is None else names)]


def _list(names: Iterable[str]) -> str:
    """List at most a dozen of ``names``."""
    first = list(names)
    return ", ".join(first[:12]) + (", ..." if len(first) > 12 else "")


@dataclass(frozen=True)
class Case:
    """A fit to be measured; if ``every`` is not 0, a frame of its scene is kept at each such number of iterations."""

    photo: Photo
    preset: str
    settings: Mapping[str, Any]
    every: int = 0

    @cached_property
    def config(self) -> FitConfig:
        """All settings of the fit."""
        return make_config(self.preset, **{**_WHOLE_PHOTO, **self.settings})

    @cached_property
    def key(self) -> str:
        """Key of the result; it covers everything that the result depends on."""
        return fit_key(self.photo.path.read_bytes(), self.config, self.photo.scale, self.every)


class Fits:
    """The fits in the CSV file ``out``, with their scenes and files in the folder of that name beside it."""

    def __init__(self, out: Path, engine: Engine | None = None) -> None:
        self._engine = engine or InProcess()
        self._results, self._folder = ResultFile(out, FIELDS), out.with_suffix(".fits")
        self._done = self._results.read()
        self._warm: set[object] = set()

    def row(self, case: Case) -> Row:
        """Return the row of ``case`` from the CSV. If the CSV has none, measure the row and add it.

        Raises:
            click.Abort: Ctrl-C ended the fit, so its result is not that of the settings.
        """
        key = case.key
        if self._is_missing(case):
            self.fill([case])
        elif any(not self._done[key][f"file_{name}"] for name in measures()):  # its needs have come since
            self._add({**self._done[key], **_looks(case, self._images(case))})
        return self._done[key]

    def fill(self, cases: Iterable[Case]) -> None:
        """Measure the ``cases`` without a row, as many at a time as the engine runs."""
        missing = {case.key: case for case in cases if self._is_missing(case)}
        for row in results_of(self._engine, list(missing.values()), self._measure):
            self._add(row)

    def _is_missing(self, case: Case) -> bool:
        return case.key not in self._done or not self._path(case, ".npz").exists()

    def scene(self, case: Case) -> Scene:
        """Return the fitted scene of a case that has a row, in pixels of its photo."""
        return load_scene(self._path(case, ".npz"))

    def soft(self, case: Case) -> Pixels:
        """Return the soft image of a case that has a row."""
        return soft_image(self.scene(case), case)

    def file(self, case: Case) -> Pixels:
        """Return the file of a case that has a row, as resvg draws it."""
        return draw(self._path(case, ".svg").read_text(), *case.photo.pixels.shape[1::-1])

    def history(self, case: Case) -> list[dict[str, float]]:
        """Return the history of the fit: iteration, curves, psnr (soft, dB), seconds."""
        history: list[dict[str, float]] = json.loads(self._path(case, ".json").read_text())
        return history

    def frames(self, case: Case) -> dict[int, Pixels]:
        """Return the soft images by iteration of a case that has frames and a row."""
        paths = sorted(self._path(case, "").glob("*.png"))
        return {int(path.stem): np.asarray(Image.open(path).convert("RGB")) for path in paths}

    def _path(self, case: Case, suffix: str) -> Path:
        return self._folder / f"{case.key}{suffix}"

    def _add(self, row: Mapping[str, Any]) -> None:
        self._results.append(row)
        self._done[row["key"]] = {name: str(value) for name, value in row.items()}

    def _measure(self, case: Case, share: WorkerShare, report: Report) -> dict[str, Any]:
        del share, report
        self._warm_up(case)
        frames: dict[int, Scene] = {}
        keep = _scene_keeper(frames, case.every) if case.every else None
        watch = Watch(keep, case.config.time_budget)
        pixels = case.photo.pixels / np.float32(255.0)
        request = Request.of(pixels, case.config, title=case.photo.name, watch=watch)
        result = Result(draw_picture(request), watch.facts())
        if result.interrupted:
            raise click.Abort
        self._keep(case, result, frames)
        images = self._images(case)
        row = {**_facts(case, result), **_qualities(case, images), **_looks(case, images)}
        click.echo(
            f"{case.photo.name} {case.preset} {case.config.curves} {row['settings']}: soft {row['soft_psnr']:.2f} dB, "
            f"file {row['file_psnr']:.2f} dB, {row['seconds']:.1f} s",
            err=True,
        )
        return row

    def _warm_up(self, case: Case) -> None:
        settings = case.config.to_dict()
        kernels = tuple(settings.get(name) for name in _KERNEL_SETTINGS)
        if kernels not in self._warm:
            warm_up(case.preset, {**case.settings, "time_budget": None})
            self._warm.add(kernels)

    def _keep(self, case: Case, result: Result, frames: Mapping[int, Scene]) -> None:
        """Write the scene, the file, the history and the frames of a fit."""
        save_scene(_on_photo(result.drawing.fitted, result), self._path(case, ".npz"))
        self._path(case, ".svg").write_text(result.svg())
        self._path(case, ".json").write_text(json.dumps(result.history))
        for iteration, scene in frames.items():
            self._path(case, "").mkdir(exist_ok=True)
            pixels = soft_image(_on_photo(scene, result), case)
            write_png(self._path(case, "") / f"{iteration:06}.png", pixels / np.float32(255.0))

    def _images(self, case: Case) -> dict[str, Pixels]:
        return {"soft": self.soft(case), "file": self.file(case)}


def _qualities(case: Case, images: Mapping[str, Pixels]) -> dict[str, float]:
    photo = case.photo.pixels
    psnrs = {f"{name}_psnr": psnr(image, photo) for name, image in images.items()}
    return {**psnrs, **{f"{name}_ssim": ssim(image, photo) for name, image in images.items()}}


def _looks(case: Case, images: Mapping[str, Pixels]) -> dict[str, Any]:
    """Return how alike the images and the photo look, with nothing for measures that cannot be taken here."""
    known, photo = measures(), case.photo.pixels
    return {
        f"{name}_{measure}": known[measure](image, photo) if measure in known else ""
        for name, image in images.items()
        for measure in NAMES
    }


def soft_image(scene: Scene, case: Case) -> Pixels:
    """Draw ``scene``, in pixels of the photo, with the renderer of ``case``; return [h, w, 3] with 8 bits."""
    image = draw_pixels(scene, *case.photo.pixels.shape[:2], **case.config.render_settings)
    return to_8_bits(image)


def _on_photo(scene: Scene, result: Result) -> Scene:
    """Scale ``scene`` to pixels of the photo."""
    return scene.scaled(*result.picture.enlargement)


def _facts(case: Case, result: Result) -> dict[str, Any]:
    height, width = case.photo.pixels.shape[:2]
    settings = {name: value for name, value in case.settings.items() if name != "curves"}
    return {
        "key": case.key,
        "image": case.photo.name,
        "width": width,
        "height": height,
        "preset": case.preset,
        "curves": case.config.curves,
        "paths": len(result.drawing.fitted),
        "settings": json.dumps(settings),
        "bytes": len(result.svg().encode()),
        "iterations": result.run.iterations,
        "seconds": result.run.seconds,
        "device": result.drawing.device,
        "source": source_digest(),
    }


def _scene_keeper(frames: dict[int, Scene], every: int) -> Callable[[Progress], None]:
    """Return a callback that stores the scenes of the first, the last and every ``every``-th iteration in ``frames``.

    They are drawn after the fit, because the time of the fit is measured.
    """

    def keep(progress: Progress) -> None:
        if progress.iteration % every == 0 or progress.iteration in (1, progress.iteration_count):
            frames[progress.iteration] = progress.scene().cpu()

    return keep
