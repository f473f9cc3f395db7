"""Checkpoint files: they hold all values, and a damaged or foreign file is refused in one line."""

from __future__ import annotations

import errno
import io
import json
import os
import random
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from warpvec import files
from warpvec.config.fit_config import FitConfig
from warpvec.errors import InputError
from warpvec.fit import checkpoint
from warpvec.fit.checkpoint import Checkpoint, read_checkpoint, write_checkpoint
from warpvec.fit.state import digest

BOMB_BYTES = 2**24


def _checkpoint(**state: Any) -> Checkpoint:
    return Checkpoint(FitConfig(curves=7, palette="#123"), "d1935f", state)


def test_a_file_holds_what_was_written(tmp_path: Path) -> None:
    values: dict[str, Any] = {
        "floats": torch.rand(3, 4), "bytes": torch.arange(5, dtype=torch.uint8),
        "long": torch.tensor(2**62), "none": None, "text": "ä\n", "number": 0.1, "infinite": float("inf"),
        "list": [{"a": 1}, {"a": 2.5}], "nested": {"tensor": torch.zeros(0, 2)}, "strided": torch.rand(4, 4)[::2, 1],
    }  # fmt: skip
    write_checkpoint(tmp_path / "a", _checkpoint(**values))
    found = read_checkpoint(tmp_path / "a")
    assert (found.config, found.target_digest) == (FitConfig(curves=7, palette="#112233"), "d1935f")
    assert list(found.state) == list(values)
    for name, value in values.items():
        if isinstance(value, torch.Tensor):
            assert found.state[name].dtype == value.dtype
            assert torch.equal(found.state[name], value)
        elif name != "nested":
            assert found.state[name] == value
    assert found.state["nested"]["tensor"].shape == (0, 2)
    assert found.state["nested"]["tensor"].stride() == torch.zeros(0, 2).stride()  # Warp takes no others
    found.state["floats"].add_(1.0)  # it has memory of its own


def test_a_digest_tells_pixels_and_shapes_apart() -> None:
    target = torch.rand(4, 6, 3)
    digests = {digest(target), digest(target + 1e-7), digest(target.reshape(6, 4, 3)), digest(target.flip(1))}
    assert len(digests) == 4
    assert digest(target.transpose(0, 1).contiguous().transpose(0, 1)) == digest(target)


@pytest.mark.parametrize("limit", ["MAX_BYTES", "MAX_HEADER"])
def test_what_could_not_be_read_is_not_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, limit: str) -> None:
    path, state = tmp_path / "fit", {"noise": torch.rand(3000), "list": list(range(3000))}
    monkeypatch.setattr(checkpoint, limit, 12_000)
    with pytest.raises(OSError, match="too many for a checkpoint") as caught:
        write_checkpoint(path, _checkpoint(**state))
    assert caught.value.errno == errno.EFBIG
    assert not path.exists()
    monkeypatch.setattr(checkpoint, limit, 40_000)
    write_checkpoint(path, _checkpoint(**state))
    assert read_checkpoint(path).state["list"] == state["list"]


def test_a_crash_while_a_file_is_written_leaves_the_older_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "fit"
    write_checkpoint(path, _checkpoint(step=1))

    def fail(*_: object) -> None:
        raise OSError(28, "No space left on device")

    for call in ("fsync", "replace"):
        with monkeypatch.context() as broken:
            broken.setattr(files.os, call, fail)
            with pytest.raises(OSError, match="No space left"):
                write_checkpoint(path, _checkpoint(step=2))
        assert read_checkpoint(path).state == {"step": 1}
        assert os.listdir(tmp_path) == ["fit"]


# files that are refused


def _members(data: bytes) -> dict[str, bytes]:
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def _archive(members: dict[str, bytes], compression: int = zipfile.ZIP_DEFLATED) -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", compression) as archive:
        for name, data in members.items():
            archive.writestr(name, data)
    return stream.getvalue()


def _saved(array: Any) -> bytes:
    stream = io.BytesIO()
    np.save(stream, array)
    return stream.getvalue()


def _with_header(data: bytes, change: Callable[[dict[str, Any]], Any]) -> bytes:
    members = _members(data)
    header = json.loads(np.load(io.BytesIO(members["header.npy"])).tobytes())
    changed = change(header) or header
    return _archive({**members, "header.npy": _saved(np.frombuffer(json.dumps(changed).encode(), np.uint8))})


def _with_array(data: bytes, header: bytes) -> bytes:
    """Replace the header of an array and keep its data."""
    members = _members(data)
    old = members["array_0.npy"]
    length = int.from_bytes(old[8:10], "little")
    members["array_0.npy"] = old[:10] + header.ljust(length - 1) + b"\n" + old[10 + length :]
    return _archive(members)


def _bomb(data: bytes) -> bytes:
    """Add an array to a checkpoint that is small in the file but large in memory."""
    return _archive({**_members(data), "array_9.npy": _saved(np.zeros(BOMB_BYTES, np.uint8))})


def _with_first(data: bytes, array: Any) -> bytes:
    """Replace the first array of a checkpoint."""
    return _archive({**_members(data), "array_0.npy": _saved(array)})


def _with_state(data: bytes, change: Callable[[dict[str, Any]], Any]) -> bytes:
    def changed(header: dict[str, Any]) -> None:
        change(header["state"])

    return _with_header(data, changed)


def _twice(data: bytes) -> bytes:
    """Add a member that has the name of another one."""
    stream = io.BytesIO(data)
    with zipfile.ZipFile(stream, "a") as archive, pytest.warns(UserWarning, match="Duplicate name"):
        archive.writestr("array_0.npy", _members(data)["array_0.npy"])
    return stream.getvalue()


def _understated(data: bytes) -> bytes:
    """Add a large array, and let the directory say that it is small."""
    bomb = bytearray(_bomb(data))
    entry = bomb.index(b"PK\x01\x02", bomb.rindex(b"array_9.npy") - 46)
    bomb[entry + 24 : entry + 28] = (1000).to_bytes(4, "little")
    return bytes(bomb)


_IMMENSE = b"{'descr': '<f4', 'fortran_order': False, 'shape': (1000000000000000,)}"

DAMAGES: dict[str, Callable[[bytes], bytes]] = {
    "empty": lambda _: b"",
    "truncated": lambda data: data[: len(data) // 2],
    "text": lambda _: b"a checkpoint",
    "array": lambda data: _members(data)["array_0.npy"],
    "archive of something": lambda _: _archive({"a.txt": b"a"}),
    "no arrays": lambda data: _archive({"header.npy": _members(data)["header.npy"]}),
    "no header": lambda data: _archive({k: v for k, v in _members(data).items() if k != "header.npy"}),
    "other format": lambda data: _with_header(data, lambda header: {**header, "format": "x"}),
    "no version": lambda data: _with_header(data, lambda header: header.pop("version") and None),
    "a list": lambda data: _with_header(data, lambda header: [header]),
    "no settings": lambda data: _with_header(data, lambda header: header.pop("config") and None),
    "unknown setting": lambda data: _with_header(data, lambda header: header["config"].update(tempo=1)),
    "wrong setting": lambda data: _with_header(data, lambda header: header["config"].update(curves="x")),
    "no such array": lambda data: _with_header(data, lambda header: {**header, "state": {"a": {"__tensor__": 9}}}),
    "an immense array": lambda data: _with_array(data, _IMMENSE),
    "an array of objects": lambda data: _with_array(data, b"{'descr': '|O', 'fortran_order': False, 'shape': (5,)}"),
    "an array of code": lambda data: _with_array(data, b"{'descr': __import__('os').system('x')}"),
    "bomb": _bomb,
    "a bomb that says it is small": _understated,
    "two arrays of one name": _twice,
    "a compression without limits": lambda data: _archive(_members(data), zipfile.ZIP_BZIP2),
    "too many members": lambda data: _archive({**_members(data), **{f"array_{k}.npy": b"" for k in range(2000)}}),
    "numbers in the other order of bytes": lambda data: _with_first(data, np.zeros(500, ">f4")),
    "numbers of 16 bits": lambda data: _with_first(data, np.zeros(500, np.float16)),
    "an array of texts": lambda data: _with_first(data, np.zeros(500, "U1")),
    "too little data": lambda data: _with_array(data, b"{'descr': '<f4', 'fortran_order': False, 'shape': (501,), }"),
    "too much data": lambda data: _with_array(data, b"{'descr': '<f4', 'fortran_order': False, 'shape': (499,), }"),
    "an array no one needs": lambda data: _archive({**_members(data), "array_9.npy": _saved(np.zeros(3, np.float32))}),
    "one array for two values": lambda data: _with_state(data, lambda state: state.update(c=state["a"])),
    "an array by its text": lambda data: _with_state(data, lambda state: state.update(a={"__tensor__": "0"})),
    "a digest that is a number": lambda data: _with_header(data, lambda header: header.update(target_digest=1)),
    "settings in a list": lambda data: _with_header(data, lambda header: header.update(config=[])),
    "a preset in the settings": lambda data: _with_header(data, lambda header: header["config"].update(preset="best")),
    "a state that is a number": lambda data: _with_header(data, lambda header: header.update(state=1)),
    "more than a checkpoint has": lambda data: _with_header(data, lambda header: header.update(more=1)),
}  # fmt: skip


@pytest.fixture
def whole(tmp_path: Path) -> Path:
    path = tmp_path / "fit"
    write_checkpoint(path, _checkpoint(a=torch.rand(500), b={"c": torch.arange(5)}))
    return path


def test_an_array_may_lie_in_memory_in_any_order(whole: Path) -> None:
    whole.write_bytes(_with_first(whole.read_bytes(), np.arange(6, dtype=np.int64).reshape(3, 2, order="F")))
    found = read_checkpoint(whole).state["a"]
    assert torch.equal(found, torch.tensor([[0, 3], [1, 4], [2, 5]]))
    assert found.is_contiguous()


def test_an_immense_file_is_not_read(tmp_path: Path) -> None:
    with open(tmp_path / "fit", "wb") as file:
        file.truncate(2**40)
    with pytest.raises(InputError, match="^checkpoint must be a checkpoint of warpvec"):
        read_checkpoint(tmp_path / "fit")


def test_an_array_is_not_allocated_for_what_its_file_only_claims(whole: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    largest = []
    empty = np.empty
    monkeypatch.setattr(checkpoint.np, "empty", lambda shape, dtype: largest.append(shape) or empty(shape, dtype))
    whole.write_bytes(_with_array(whole.read_bytes(), _IMMENSE[:-1] + b", }"))
    with pytest.raises(InputError):
        read_checkpoint(whole)
    assert all(shape[0] < 10**6 for shape in largest)


@pytest.mark.parametrize("damage", DAMAGES)
def test_a_damaged_file_is_refused_in_one_line(damage: str, whole: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(checkpoint, "MAX_BYTES", BOMB_BYTES - 1)
    whole.write_bytes(DAMAGES[damage](whole.read_bytes()))
    with pytest.raises(InputError, match="^checkpoint must .*; .*start again without it$") as caught:
        read_checkpoint(whole)
    assert "\n" not in str(caught.value)


def test_a_flipped_bit_is_found_or_changes_nothing(whole: Path) -> None:
    data, expected, generator = whole.read_bytes(), read_checkpoint(whole), random.Random(0)
    found = 0
    # Most of them are at the end, in the description of the archive.
    places = generator.sample(range(8 * (len(data) - 300), 8 * len(data)), 500)
    places += generator.sample(range(8 * len(data)), 200)
    for place in places:
        flipped = bytearray(data)
        flipped[place // 8] ^= 1 << place % 8
        whole.write_bytes(flipped)
        try:
            state = read_checkpoint(whole)
        except InputError:
            found += 1
            continue
        assert torch.equal(state.state["a"], expected.state["a"]), place
        assert torch.equal(state.state["b"]["c"], expected.state["b"]["c"]), place
    assert found > 0.5 * len(places)


@pytest.mark.parametrize("version", [1, 2, 3])
def test_a_file_of_an_older_version_is_refused_in_one_line(version: int, whole: Path) -> None:
    whole.write_bytes(_with_header(whole.read_bytes(), lambda header: {**header, "version": version}))
    expected = (
        f"^checkpoint must have version 4, got version {version} in .*, written by warpvec [0-9.]+; continue with that"
    )
    with pytest.raises(InputError, match=expected) as caught:
        read_checkpoint(whole)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("path", ["missing", ".", "/dev/zero", "a\0b"])
def test_a_path_that_is_no_file_is_refused(path: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="^checkpoint must be"):
        read_checkpoint(tmp_path / path)
