"""Writing files: completely or not at all, and checked beforehand."""

from __future__ import annotations

import errno
import gzip
import os
import stat

import pytest

from warpvec import files
from warpvec.errors import InputError
from warpvec.files import check_writable, gzip_bytes, write_atomic
from warpvec.writers.registry import encode


def entries(folder):
    return sorted(path.name for path in folder.iterdir())


def refusal(path, name="OUT"):
    with pytest.raises(InputError) as caught:
        check_writable(path, name)
    message = str(caught.value)
    assert message.startswith("OUT must ")
    assert "\n" not in message
    return message


def test_write_atomic_writes_and_replaces(tmp_path):
    target = tmp_path / "out.svg"
    write_atomic(target, b"first")
    write_atomic(str(target), b"second, longer")
    assert target.read_bytes() == b"second, longer"
    assert entries(tmp_path) == ["out.svg"]


@pytest.mark.parametrize("umask", [0o022, 0o077])
def test_the_mode_follows_the_umask(tmp_path, umask):
    before = os.umask(umask)
    try:
        write_atomic(tmp_path / "out.svg", b"x")
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "out.svg").stat().st_mode) == 0o666 & ~umask


@pytest.mark.parametrize("error", [OSError("disk full"), KeyboardInterrupt()])
@pytest.mark.parametrize("call", ["fsync", "replace"])
def test_a_failed_write_leaves_the_old_file_and_nothing_else(tmp_path, monkeypatch, call, error):
    def fail(*_):
        raise error

    target = tmp_path / "out.svg"
    target.write_bytes(b"old")
    monkeypatch.setattr(files.os, call, fail)
    with pytest.raises(type(error)):
        write_atomic(target, b"new")
    assert target.read_bytes() == b"old"
    assert entries(tmp_path) == ["out.svg"]


def test_the_target_never_holds_a_part(tmp_path, monkeypatch):
    target = tmp_path / "out.svg"
    seen = []

    def replace(source, destination):
        seen.append((target.exists(), source.read_bytes(), source.parent))
        os.rename(source, destination)

    monkeypatch.setattr(files.os, "replace", replace)
    write_atomic(target, b"whole")
    assert seen == [(False, b"whole", tmp_path)]
    assert target.read_bytes() == b"whole"


def test_a_symbolic_link_stays_a_link(tmp_path):
    (tmp_path / "real").mkdir()
    link = tmp_path / "link.svg"
    link.symlink_to(tmp_path / "real" / "out.svg")
    check_writable(link, "OUT")
    write_atomic(link, b"x")
    assert link.is_symlink()
    assert (tmp_path / "real" / "out.svg").read_bytes() == b"x"


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs named pipes")
def test_a_pipe_is_written_into_not_replaced(tmp_path):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    try:
        check_writable(pipe, "OUT")
        write_atomic(pipe, b"through")
        assert os.read(reader, 100) == b"through"
    finally:
        os.close(reader)
    assert stat.S_ISFIFO(pipe.stat().st_mode)


def test_long_names_that_the_system_allows_can_be_written(tmp_path):
    target = tmp_path / ("n" * 251 + ".svg")
    check_writable(target, "OUT")
    write_atomic(target, b"x")
    assert target.read_bytes() == b"x"


def test_check_writable_accepts_new_and_existing_files_and_leaves_no_trace(tmp_path, monkeypatch):
    (tmp_path / "old.svg").write_bytes(b"old")
    monkeypatch.chdir(tmp_path)
    for path in (tmp_path / "new.svg", tmp_path / "old.svg", "new.svg", "./old.svg"):
        check_writable(path, "OUT")
    assert entries(tmp_path) == ["old.svg"]
    assert (tmp_path / "old.svg").read_bytes() == b"old"


def test_check_writable_refuses_what_cannot_be_a_file(tmp_path):
    (tmp_path / "file").write_bytes(b"")
    assert "got the folder" in refusal(tmp_path)
    assert "got the folder" in refusal(f"{tmp_path}/new/")
    assert "got the folder ''" in refusal("")
    assert "create" in refusal(tmp_path / "missing" / "out.svg")
    assert "is a file" in refusal(tmp_path / "file" / "out.svg")
    assert "File name too long" in refusal(tmp_path / ("n" * 300))
    assert "null" in refusal(f"{tmp_path}/a\0b")
    assert entries(tmp_path) == ["file"]


def test_check_writable_refuses_a_link_into_a_missing_folder(tmp_path):
    link = tmp_path / "link.svg"
    link.symlink_to(tmp_path / "missing" / "out.svg")
    assert "create" in refusal(link)


@pytest.mark.parametrize("protected", ["file", "folder"])
def test_check_writable_refuses_what_permissions_forbid(tmp_path, monkeypatch, protected):
    # Root may write anywhere, so the system's answer is faked.
    target = tmp_path / "out.svg"
    forbidden = target if protected == "file" else tmp_path
    if protected == "file":
        target.write_bytes(b"")
    monkeypatch.setattr(files.os, "access", lambda path, _: str(path) != str(forbidden))
    assert ("write-protected" if protected == "file" else "folder you may write to") in refusal(target)


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="permissions do not bind root")
def test_check_writable_asks_the_system(tmp_path):
    tmp_path.chmod(0o500)
    assert "folder you may write to" in refusal(tmp_path / "out.svg")


def test_svgz_is_gzipped_and_reproducible(monkeypatch):
    text = "<svg>\u00e9</svg>" * 50
    packed = encode(text, "dir.svg/out.SVGZ")
    monkeypatch.setattr("time.time", lambda: 1e9)
    assert encode(text, "out.svgz") == packed == gzip_bytes(text.encode())
    assert gzip.decompress(packed) == text.encode()
    assert encode(text, "out.svg") == encode(text, "-") == encode(text, "svgz") == text.encode()


@pytest.mark.skipif(not os.path.isdir("/proc/self"), reason="needs /proc, which only Linux has")
def test_a_folder_that_makes_no_files_is_refused_before_the_work():
    assert "where files can be made, got '/proc/out.svg' (No such file or directory)" in refusal("/proc/out.svg")


def test_a_disk_that_is_full_before_the_work_is_not_refused(tmp_path, monkeypatch):
    def fail(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(files, "temporary_file", fail)
    check_writable(tmp_path / "out.svg", "OUT")
