"""Real photos for a first run, taken from the scikit-image that is installed."""

from __future__ import annotations

import os
from importlib.util import find_spec
from pathlib import Path

from warpvec.errors import InputError
from warpvec.files import check_writable, write_atomic

SAMPLES = (
    "coffee.png",
    "astronaut.png",
    "chelsea.png",
    "rocket.jpg",
    "retina.jpg",
    "hubble_deep_field.jpg",
    "motorcycle_left.png",
    "camera.png",
    "moon.png",
)
"""Photos that scikit-image's wheel carries; the others of its data module would be downloaded."""


def write_sample(name: str, path: str | os.PathLike[str]) -> None:
    """Copy the photo ``name``, one of ``SAMPLES``, to ``path``, whole or not at all.

    Raises:
        InputError: no such sample, scikit-image is not installed, or ``path`` cannot be written.
    """
    check_writable(path, "OUT")
    if name not in SAMPLES:
        raise InputError(f"NAME must be one of {', '.join(SAMPLES)}, got {name!r}; choose one of these")
    try:
        data = (_data_folder() / name).read_bytes()
    except OSError as error:
        remedy = "pip install --upgrade 'warpvec[eval]'"
        raise InputError(f"NAME must be a photo that scikit-image carries, {name!r} is not there; {remedy}") from error
    write_atomic(path, data)


def _data_folder() -> Path:
    # find_spec looks without importing: scikit-image takes longer to import than this takes to run.
    spec = find_spec("skimage")
    if spec is None or not spec.submodule_search_locations:
        raise InputError("sample needs scikit-image, which is not installed; pip install 'warpvec[eval]'")
    return Path(spec.submodule_search_locations[0]) / "data"
