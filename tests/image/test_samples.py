"""Sample photos, and the message for each reason why one cannot be copied."""

from __future__ import annotations

import pytest

from warpvec.errors import InputError
from warpvec.image import samples
from warpvec.image.read import read_image
from warpvec.image.samples import SAMPLES, write_sample

pytest.importorskip("skimage", reason="scikit-image carries the photos")


@pytest.mark.parametrize("name", SAMPLES)
def test_sample_is_a_photo_of_some_size(tmp_path, name):
    write_sample(name, tmp_path / name)
    pixels = read_image(tmp_path / name)
    assert min(pixels.shape[:2]) >= 256
    assert pixels.std() > 0.05
    assert [path.name for path in tmp_path.iterdir()] == [name]


@pytest.mark.parametrize("name", SAMPLES)
def test_sample_comes_with_the_wheel(name):
    """The file belongs to the wheel; it was not downloaded next to it by an earlier use of skimage.data."""
    from importlib.metadata import files

    assert f"skimage/data/{name}" in {str(path) for path in files("scikit-image") or ()}


def test_unknown_name_lists_the_names(tmp_path):
    with pytest.raises(InputError, match=r"^name .*coffee\.png.*'\.\./coffee\.png'"):
        write_sample("../coffee.png", tmp_path / "out.png")
    assert not any(tmp_path.iterdir())


def test_missing_scikit_image(tmp_path, monkeypatch):
    monkeypatch.setattr(samples, "find_spec", lambda name: None)
    with pytest.raises(InputError, match=r"not installed; pip install 'warpvec\[eval\]'$"):
        write_sample("coffee.png", tmp_path / "out.png")
    assert not any(tmp_path.iterdir())


def test_scikit_image_without_the_photo(tmp_path, monkeypatch):
    monkeypatch.setattr(samples, "_data_folder", lambda: tmp_path)
    with pytest.raises(InputError, match=r"coffee\.png.*pip install --upgrade"):
        write_sample("coffee.png", tmp_path / "out.png")


@pytest.mark.parametrize("target", ["no/out.png", ""])
def test_path_that_cannot_be_written(tmp_path, target):
    with pytest.raises(InputError, match=r"^path "):
        write_sample("coffee.png", tmp_path / target)
    assert not any(tmp_path.iterdir())
