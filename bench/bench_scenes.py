"""The scenes that benches measure: fits of real photos, made once and kept in a folder."""

from __future__ import annotations

import hashlib
import json
from dataclasses import fields
from pathlib import Path

import click
import numpy as np
import torch

from warpvec.config import FitConfig
from warpvec.fit import fit
from warpvec.samples import write_sample
from warpvec.scene import Scene


def fitted_scene(photo: Path, target: torch.Tensor, config: FitConfig, cache: Path) -> Path:
    """The file of a fit's scene in ``cache``: made once, so that changes to warpvec meet the same scene."""
    settings = {**config.to_dict(), "threads": None}  # of no influence on the result
    digest = hashlib.sha256(photo.read_bytes() + json.dumps(settings, sort_keys=True).encode()).hexdigest()[:12]
    path = cache / f"{photo.stem}-{config.curves}-{digest}.npz"
    if not path.exists():
        click.echo(f"fitting {photo.name} once, for {path}", err=True)
        save_scene(fit(target, config).scene, path)
    return path


def save_scene(scene: Scene, path: Path) -> None:
    """Write the fields of ``scene`` as arrays of an .npz file."""
    path.parent.mkdir(parents=True, exist_ok=True)
    np.savez(path, **{field.name: np.asarray(getattr(scene, field.name)) for field in fields(Scene)})


def load_scene(path: Path) -> Scene:
    """The scene that :func:`save_scene` wrote."""
    with np.load(path) as arrays:
        tensors = {name: torch.from_numpy(arrays[name]) for name in arrays.files if name != "degree"}
        return Scene(**tensors, degree=int(arrays["degree"]))


def sample_photo(cache: Path) -> Path:
    """A photo that scikit-image carries, 600 x 400."""
    path = cache / "coffee.png"
    if not path.exists():
        cache.mkdir(parents=True, exist_ok=True)
        write_sample("coffee.png", path)
    return path
