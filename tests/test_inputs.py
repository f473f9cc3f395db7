"""Reading up to a limit: exact at the limit, endless inputs, pipes, and files that cannot be read."""

from __future__ import annotations

import io
import os
import threading
from pathlib import Path

import pytest

from warpvec.errors import InputError
from warpvec.inputs import read_file, read_stream


def test_the_limit_itself_is_read(tmp_path: Path) -> None:
    path = tmp_path / "data"
    path.write_bytes(b"12345")
    assert read_file(path, 5, "IN") == b"12345"
    with pytest.raises(InputError, match="^IN must have at most 4 bytes, got more in '.*data'; give a smaller file$"):
        read_file(path, 4, "IN")


def test_an_endless_stream_is_left_soon_after_the_limit() -> None:
    class Endless(io.RawIOBase):
        given = 0

        def read(self, count: int = -1) -> bytes:
            assert count > 0
            self.given += count
            return b"x" * count

    stream = Endless()
    with pytest.raises(InputError, match="IN must have at most 3000000 bytes, got more in stdin"):
        read_stream(stream, 3_000_000, "IN", "stdin")  # type: ignore[arg-type]
    assert stream.given < 5_000_000


def test_a_pipe_is_read_to_its_end_in_any_pieces(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)

    def write() -> None:
        with pipe.open("wb", buffering=0) as file:
            for piece in (b"one", b" ", b"two" * 50_000):
                file.write(piece)

    writer = threading.Thread(target=write, daemon=True)
    writer.start()
    assert read_file(pipe, 10**6, "IN") == b"one " + b"two" * 50_000
    writer.join()


@pytest.mark.parametrize(("name", "reason"), [("none", "No such file"), (".", "directory"), ("a\0b", "null")])
def test_what_cannot_be_read_is_refused(name: str, reason: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=f"^FILE must be a palette, got .*{reason}.*; check the path$"):
        read_file(tmp_path / name, 9, "FILE", "a palette")
