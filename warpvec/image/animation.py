"""Write animated GIF and WebP files while their frames come, so that memory does not grow with their number.

Pillow writes an animation only as a whole. A few frames at a time are therefore encoded as an animation of their own,
and its frames are appended to the file. The formats are described in the GIF89a specification and in RFC 9649.
"""

from __future__ import annotations

import os
import struct
from abc import ABC, abstractmethod
from collections.abc import Iterator
from io import BytesIO
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray
from PIL import Image

PART_FRAMES = 8
"""Frames that are encoded together, in which equal pixels are stored once. 24 MB of memory at a megapixel."""

_GIF_HEAD_BYTES = 13
_WEBP_HEAD_BYTES = 12


class PartWriter(ABC):
    """Writes frames, each shown for ``duration`` milliseconds, and encodes ``PART_FRAMES`` of them at a time."""

    _FORMAT: str

    def __init__(self, stream: BinaryIO, duration: int) -> None:
        self._stream, self._duration = stream, duration
        self._frames: list[Image.Image] = []
        self._size = 0, 0

    def add(self, frame: NDArray[np.uint8]) -> None:
        """Append ``frame`` [h, w, 3]."""
        self._frames.append(Image.fromarray(frame))
        self._size = self._frames[0].size
        if len(self._frames) == PART_FRAMES:
            self._encode()

    def finish(self) -> None:
        """Write what is left, bring the file to the disk, where a full one is noticed at the latest, and close it."""
        if self._frames:
            self._encode()
        self._end()
        self._stream.flush()
        os.fsync(self._stream.fileno())
        self._stream.close()  # Windows cannot move a file that is open

    def _encode(self) -> None:
        """Append the frames since the last part."""
        (first, *others), count, self._frames = self._frames, len(self._frames), []
        several = {"save_all": True, "append_images": others} if others else {}
        buffer = BytesIO()
        first.save(buffer, self._FORMAT, duration=self._duration, loop=0, **several)
        self._append(buffer.getvalue(), count)

    @abstractmethod
    def _append(self, part: bytes, frame_count: int) -> None:
        """Append the file ``part``, an animation of ``frame_count`` frames."""

    @abstractmethod
    def _end(self) -> None:
        """Write the end of the file."""


class GifWriter(PartWriter):
    """Writes a GIF that repeats for ever."""

    _FORMAT = "GIF"

    def _append(self, part: bytes, frame_count: int) -> None:
        if self._stream.tell():
            self._stream.writelines(_gif_frames(part))
        else:
            self._stream.write(part.removesuffix(b";"))

    def _end(self) -> None:
        self._stream.write(b";")


class WebpWriter(PartWriter):
    """Writes a WebP file that repeats for ever."""

    _FORMAT = "WEBP"
    _flags = 0
    _first: tuple[bytes, int] | None = None
    """The first part and the number of its frames, as long as there is no other."""

    def _append(self, part: bytes, frame_count: int) -> None:
        if self._first is None and not self._flags:
            self._first = part, frame_count
            return
        if self._first is not None:
            self._stream.write(self._head(0))
            self._append_frames(*self._first)
            self._first = None
        self._append_frames(part, frame_count)

    def _end(self) -> None:
        """Write the header, which tells the number of bytes; one part is a file of its own."""
        head = self._head(self._stream.tell()) if self._first is None else self._first[0]
        self._stream.seek(0)
        self._stream.write(head)

    def _append_frames(self, part: bytes, frame_count: int) -> None:
        """Append the frames of ``part``. If all are equal, it is a still image without times."""
        self._flags |= _ANIMATED
        chunks = dict(_chunks(part))
        if b"VP8X" in chunks:
            self._flags |= chunks[b"VP8X"][0] & _HAS_ALPHA
        if b"ANIM" in chunks:
            frames = [data for name, data in _chunks(part) if name == b"ANMF"]
        else:
            width, height = self._size
            place = bytes(6) + _bytes3(width - 1) + _bytes3(height - 1) + _bytes3(frame_count * self._duration)
            pixels = [_chunk(name, data) for name, data in _chunks(part) if name in (b"ALPH", b"VP8 ", b"VP8L")]
            frames = [place + b"\0" + b"".join(pixels)]
        self._stream.writelines(_chunk(b"ANMF", frame) for frame in frames)

    def _head(self, byte_count: int) -> bytes:
        width, height = self._size
        features = bytes([self._flags, 0, 0, 0]) + _bytes3(width - 1) + _bytes3(height - 1)
        body = b"WEBP" + _chunk(b"VP8X", features) + _chunk(b"ANIM", bytes(6))
        return b"RIFF" + struct.pack("<I", max(0, byte_count - 8)) + body


_ANIMATED, _HAS_ALPHA = 0x02, 0x10
"""Flags of a WebP file."""


def _gif_frames(data: bytes) -> Iterator[bytes]:
    """Yield the frames of a GIF file, each with the colour table of the file unless it has one of its own."""
    table_bits = data[10] & 0x07
    position = _GIF_HEAD_BYTES + (3 << (table_bits + 1))
    table = data[_GIF_HEAD_BYTES:position]
    while data[position : position + 1] != b";":
        is_image = data[position : position + 1] == b","
        # An image has nine bytes of place and flags; then, like an extension, a byte and a row of blocks.
        head = bytearray(data[position : position + (10 if is_image else 1)])
        start = position + len(head)
        if is_image and head[9] & 0x80:
            own_bytes = 3 << ((head[9] & 0x07) + 1)
            head += data[start : start + own_bytes]
            start += own_bytes
        elif is_image:
            head[9] |= 0x80 | table_bits
            head += table
        position = _end_of_blocks(data, start + 1)
        is_control = not is_image and data[start] == 0xF9
        if is_image or is_control:
            yield bytes(head) + data[start:position]


def _end_of_blocks(data: bytes, position: int) -> int:
    """Return the position after the row of blocks that starts at ``position``; an empty block ends it."""
    while data[position]:
        position += 1 + data[position]
    return position + 1


def _chunks(data: bytes) -> Iterator[tuple[bytes, bytes]]:
    """Yield the name and the contents of each chunk of a WebP file."""
    position = _WEBP_HEAD_BYTES
    while position + 8 <= len(data):
        name, length = struct.unpack_from("<4sI", data, position)
        yield name, data[position + 8 : position + 8 + length]
        position += 8 + length + length % 2


def _chunk(name: bytes, contents: bytes) -> bytes:
    return name + struct.pack("<I", len(contents)) + contents + bytes(len(contents) % 2)


def _bytes3(value: int) -> bytes:
    return value.to_bytes(3, "little")
