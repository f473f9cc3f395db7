"""Copy sample photos for a first run from the installed scikit-image."""

from __future__ import annotations

import os
from importlib.util import find_spec
from pathlib import Path

from warpvec.checks import check_choice
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
"""Photos in the wheel of scikit-image; the others of its data module would be downloaded."""


def write_sample(name: str, path: str | os.PathLike[str]) -> None:
    """Copy the photo ``name``, one of ``SAMPLES``, to ``path``, completely or not at all.

    Raises:
        InputError: there is no such sample, scikit-image is not installed, or ``path`` cannot be written.
    """
    check_writable(path, "path")
    check_choice("name", name, SAMPLES)
    try:
        data = (_data_folder() / name).read_bytes()
    except OSError as error:
        rule = "must be a photo of the installed scikit-image"
        raise InputError("name", rule, repr(name), "pip install --upgrade 'warpvec[eval]'") from error
    write_atomic(path, data)


def _data_folder() -> Path:
    # find_spec does not import scikit-image, which would take longer than all the rest.
    spec = find_spec("skimage")
    if spec is None or not spec.submodule_search_locations:
        raise InputError("name", "needs scikit-image, which is not installed", remedy="pip install 'warpvec[eval]'")
    return Path(spec.submodule_search_locations[0]) / "data"
