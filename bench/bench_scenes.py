"""Scenes for benchmarks: short fits of real photos, each made once and kept in a folder."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any, NamedTuple

import click
import numpy as np
import torch
from PIL import Image, ImageOps

from warpvec.config.fit_config import FitConfig
from warpvec.config.presets import make_config
from warpvec.fit.loop import fit
from warpvec.geometry.scene import Scene
from warpvec.image.picture import reduce_image
from warpvec.image.read import read_image
from warpvec.image.samples import write_sample


class NamedScene(NamedTuple):
    """A scene with a name.

    Attributes:
        photo: file name in the Kodak set, or in scikit-image if ``is_sample``.
        width, height: size in pixels to which the photo is resampled before the fit.
        curves, iterations: settings of the fit; the others are those of the default preset.
    """

    photo: str
    width: int
    height: int
    curves: int
    iterations: int
    is_sample: bool = False


SCENES = {
    "kodim07-256": NamedScene("kodim07.png", 768, 512, 256, 300),
    "kodim07-1024": NamedScene("kodim07.png", 768, 512, 1024, 300),
    "photo-2040x1344-2048": NamedScene("kodim07.png", 2040, 1344, 2048, 300),
    "wide-4096x4096-4096": NamedScene("astronaut.png", 4096, 4096, 4096, 200, is_sample=True),
}
"""The scenes by name.

No package has photos of the two larger sizes, so smaller photos are enlarged, 2.7 and 8 times by the side. They lack
finer detail, but the scenes could not show it: they have one path for each 36 x 36 and 64 x 64 pixels, and kodim07-256
has one for each 39 x 39.
"""


class Subject(NamedTuple):
    """The input of a benchmark: the target [h, w, 3], the settings of its fit, and the file of its scene."""

    target: torch.Tensor
    config: FitConfig
    path: Path


def named_subject(name: str, photos: Path, cache: Path, settings: dict[str, Any]) -> Subject:
    """Return the subject called ``name`` in ``SCENES``; fit its scene if ``cache`` does not hold it.

    Args:
        name: a key of ``SCENES``.
        photos: folder with the Kodak set.
        cache: folder of the scenes and resampled photos.
        settings: fields of ``FitConfig`` that replace those of the scene.

    Raises:
        click.UsageError: the photo does not exist.
        InputError: a setting is wrong.
    """
    scene = SCENES[name]
    photo = resampled_photo(_find_photo(scene, photos, cache), scene.width, scene.height, cache)
    size = {"curves": scene.curves, "iterations": scene.iterations, "fit_size": max(scene.width, scene.height)}
    return photo_subject(photo, make_config(**{**size, **settings}), cache)


def photo_subject(photo: Path, config: FitConfig, cache: Path, scene: Path | None = None) -> Subject:
    """Return the photo, reduced as in a fit, with the file ``scene`` or else the scene of a fit with ``config``."""
    target = torch.from_numpy(reduce_image(read_image(photo), config.fit_size))
    return Subject(target, config, scene or fitted_scene(photo, target, config, cache))


def scene_file(path: str | None) -> Path | None:
    """Return the scene file that the user gave as ``path``, or None if none was given.

    Raises:
        click.UsageError: ``path`` is not a file.
    """
    if path is None or Path(path).is_file():
        return path and Path(path)
    raise click.UsageError(f"--scene must be a file or one of {', '.join(SCENES)}, got {path!r}")


def fitted_scene(photo: Path, target: torch.Tensor, config: FitConfig, cache: Path) -> Path:
    """Fit a scene once and keep it in ``cache``, so that all versions of warpvec measure it; return its file."""
    settings = {**config.to_dict(), "threads": None}  # does not change the result
    digest = hashlib.sha256(photo.read_bytes() + json.dumps(settings, sort_keys=True).encode()).hexdigest()[:12]
    path = cache / f"{photo.stem}-{config.curves}-{digest}.npz"
    if not (path.exists() and _is_current(path)):
        click.echo(f"fitting {photo.name}; the scene is kept in {path}", err=True)
        save_scene(fit(target, config).scene, path)
    return path


def save_scene(scene: Scene, path: Path) -> None:
    """Write `Scene.to_dict` as the arrays of an .npz file, without what is None.

    Raises:
        ValueError: the scene has gradients, which no fit for a benchmark makes.
    """
    if scene.gradients is not None:
        raise ValueError("the scenes of benchmarks have flat colours")
    path.parent.mkdir(parents=True, exist_ok=True)
    np.savez(path, **{name: np.asarray(value) for name, value in scene.to_dict().items() if value is not None})


def load_scene(path: Path) -> Scene:
    """Read a scene that :func:`save_scene` wrote.

    Raises:
        click.UsageError: the file is of an older version, which had a field "points".
    """
    if not _is_current(path):
        raise click.UsageError(f"{path} is a scene of an older version of warpvec; delete it, and fit the scene again")
    with np.load(path) as arrays:
        values = {name: torch.from_numpy(array) if array.ndim else array.item() for name, array in arrays.items()}
    return Scene.from_dict({"is_line": None, "uniform_count": None, "gradients": None, **values})


def _is_current(path: Path) -> bool:
    with np.load(path) as arrays:
        return "segments" in arrays


def sample_photo(cache: Path, name: str = "coffee.png") -> Path:
    """Return the path of a sample photo of scikit-image; coffee.png has 600 x 400 pixels."""
    path = cache / name
    if not path.exists():
        cache.mkdir(parents=True, exist_ok=True)
        write_sample(name, path)
    return path


def resampled_photo(photo: Path, width: int, height: int, cache: Path) -> Path:
    """Resample ``photo`` by Lanczos-3, cropped on both sides to the new proportions; return a PNG in ``cache``."""
    with Image.open(photo) as image:
        if image.size == (width, height):
            return photo
        digest = hashlib.sha256(photo.read_bytes()).hexdigest()[:6]
        path = cache / f"{photo.stem}-{digest}-{width}x{height}.png"
        if not path.exists():
            cache.mkdir(parents=True, exist_ok=True)
            resampled = ImageOps.fit(image.convert("RGB"), (width, height), Image.Resampling.LANCZOS)
            resampled.save(path, compress_level=1)
        return path


def _find_photo(scene: NamedScene, photos: Path, cache: Path) -> Path:
    if scene.is_sample:
        return sample_photo(cache, scene.photo)
    path = photos / scene.photo
    if not path.is_file():
        raise click.UsageError(f"--photos must be a folder with {scene.photo} of the Kodak set, got {photos}")
    return path
