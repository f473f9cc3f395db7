"""Folders of a batch: local ones and those of fsspec have the same names, bytes and refusals."""

from __future__ import annotations

import os
import pickle
import sys
import uuid
from pathlib import Path

import pytest

from warpvec.batch.folders import Folder, LocalFolder, RemoteFolder, open_folder
from warpvec.errors import InputError
from warpvec.temporary_files import temporary_file

FILES = {"a.png": b"1", "b/c.png": b"22", "b/d/e.jpg": b""}
HIDDEN = {".hidden.png": b"3", ".folder/f.png": b"4", "b/.g.png": b"5", "b/.h/i.png": b"6"}


@pytest.fixture(params=["path", "file://", "memory://"])
def folder(request: pytest.FixtureRequest, tmp_path: Path) -> Folder:
    """Return a folder with some files, opened by a path or by an address."""
    if request.param != "path":
        pytest.importorskip("fsspec", reason="the extra cluster is not installed")
    addresses = {"path": tmp_path, "file://": f"file://{tmp_path}", "memory://": f"memory://{uuid.uuid4().hex}/photos/"}
    found = open_folder(str(addresses[request.param]), "IN_DIR")
    for name, data in {**FILES, **HIDDEN}.items():
        found.write(name, data)
    return found


def test_names_are_sorted_and_without_hidden_ones(folder: Folder) -> None:
    assert folder.names(recursive=False) == ["a.png"]
    assert folder.names(recursive=True) == ["a.png", "b/c.png", "b/d/e.jpg"]


def test_what_is_written_is_read(folder: Folder) -> None:
    assert {name: folder.read(name) for name in FILES} == FILES
    folder.write("a.png", b"another")
    assert folder.read("a.png") == b"another"
    assert (folder.exists("b/c.png"), folder.exists("b/x.png"), folder.exists("b")) == (True, False, False)


def test_a_missing_file_is_an_input_error(folder: Folder) -> None:
    with pytest.raises(InputError, match="b/x.png must be a file you may read"):
        folder.read("b/x.png")


def test_a_file_is_read_up_to_the_limit(folder: Folder) -> None:
    assert folder.read("b/c.png", 2) == b"22"
    with pytest.raises(InputError, match="^b/c.png must have at most 1 bytes"):
        folder.read("b/c.png", 1)


@pytest.mark.skipif(os.name == "nt", reason="needs links and pipes of POSIX")
def test_what_no_further_attempt_can_read_is_an_input_error(tmp_path: Path) -> None:
    folder = LocalFolder(tmp_path)
    (tmp_path / "a.png").symlink_to("b.png")
    (tmp_path / "b.png").symlink_to("a.png")
    (tmp_path / "endless.png").symlink_to("/dev/zero")
    os.mkfifo(tmp_path / "pipe.png")
    names = folder.names(recursive=False)
    assert names == ["a.png", "b.png", "endless.png", "pipe.png"]
    for name in (*names, "a.png/c.png", 300 * "x"):
        with pytest.raises(InputError, match=f"^{name} must be a file you may read"):
            folder.read(name)


def test_a_pickled_folder_is_the_same(folder: Folder) -> None:
    assert pickle.loads(pickle.dumps(folder)).read("b/c.png") == b"22"


@pytest.mark.parametrize("address", ["{}/none", "file://{}/none", "{}/file"])
def test_no_folder_is_an_input_error(tmp_path: Path, address: str) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match="IN_DIR must be a folder, got "):
        open_folder(address.format(tmp_path), "IN_DIR").names(recursive=True)


@pytest.mark.parametrize(("address", "words"), [("", "got ''"), ("nonsense://a/b", "Protocol not known: nonsense")])
def test_no_address_is_an_input_error(address: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        open_folder(address, "IN_DIR")


def test_an_address_without_fsspec_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "fsspec.core", None)
    with pytest.raises(InputError, match="warpvec\\[cluster\\]"):
        RemoteFolder("s3://bucket/photos")


def test_a_relative_path_means_the_same_elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    folder = LocalFolder("photos")
    monkeypatch.chdir("/")
    folder.write("a.txt", b"1")
    assert (tmp_path / "photos" / "a.txt").read_bytes() == b"1"


def test_lines_are_added_to_a_file(tmp_path: Path) -> None:
    folder = LocalFolder(tmp_path)
    for line in (b"1\n", b"2\n"):
        folder.append("lines", line)
    assert folder.read("lines") == b"1\n2\n"


def test_a_folder_has_one_owner_at_a_time(tmp_path: Path) -> None:
    path = tmp_path / "new" / "out"
    with LocalFolder(path, "OUT_DIR").lock():
        assert path.is_dir()
        with (
            pytest.raises(InputError, match="OUT_DIR must be written by one batch at a time"),
            LocalFolder(path, "OUT_DIR").lock(),
        ):
            pytest.fail("two owners")
    with LocalFolder(path, "OUT_DIR").lock():
        assert os.listdir(path) == []


@pytest.mark.skipif(os.name == "nt", reason="needs locks of files")
def test_unlocking_removes_what_a_killed_worker_left(tmp_path: Path) -> None:
    with temporary_file(tmp_path / "a.svg") as path:
        pass
    with LocalFolder(tmp_path, "OUT_DIR").lock():
        path.touch()  # not locked, as after the end of its writer
    assert os.listdir(tmp_path) == []


def test_a_file_cannot_be_locked(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    for name in ("file", "file/below"):
        with (
            pytest.raises(InputError, match="OUT_DIR must be a folder or a name for one"),
            LocalFolder(tmp_path / name, "OUT_DIR").lock(),
        ):
            pytest.fail("locked")


def test_a_folder_in_place_of_the_records_is_refused(tmp_path: Path) -> None:
    (tmp_path / "batch.csv").mkdir()
    folder = open_folder(str(tmp_path), "OUT_DIR")
    for put in (folder.append, folder.write):
        with pytest.raises(InputError, match="a folder named 'batch.csv'; move it away"):
            put("batch.csv", b"a line")


@pytest.mark.skipif(os.name == "nt", reason="Windows has other limits")
def test_a_name_that_is_too_long_is_no_file_and_cannot_be_written(tmp_path: Path) -> None:
    """The SVG of a photo may have a longer name than the photo; no further attempt would help."""
    folder, name = LocalFolder(tmp_path, "OUT_DIR"), 251 * "x" + ".svgz"
    assert not folder.exists(name)
    with pytest.raises(InputError, match="^x+.svgz must be a file you may write, got File name too long"):
        folder.write(name, b"an SVG")
