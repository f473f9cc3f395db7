"""Change bytes as a disk, a network or an attacker does: bits, runs of bytes, numbers, values, the end of the file."""

from __future__ import annotations

import re
import struct
import zlib
from collections.abc import Callable
from random import Random


def mutate(data: bytes, chance: Random, others: list[bytes]) -> bytes:
    """Return ``data`` after one to four changes of bits, bytes, runs of bytes, numbers, values, or its end."""
    for _ in range(chance.choice([1, 1, 2, 4])):
        data = chance.choice(_CHANGES)(data, chance, others)
    return data


def _flip_bit(data: bytes, chance: Random, _: list[bytes]) -> bytes:
    return _changed(data, chance, lambda byte: byte ^ 1 << chance.randrange(8))


def _set_byte(data: bytes, chance: Random, _: list[bytes]) -> bytes:
    return _changed(data, chance, lambda _: chance.choice([0, 1, 127, 128, 255, 45, 57, 34, 60, 32]))


def _changed(data: bytes, chance: Random, change: Callable[[int], int]) -> bytes:
    if not data:
        return data
    position = chance.randrange(len(data))
    return data[:position] + bytes([change(data[position])]) + data[position + 1 :]


def _cut(data: bytes, chance: Random, _: list[bytes]) -> bytes:
    start, stop = _run(data, chance)
    return data[:start] + data[stop:]


def _repeat(data: bytes, chance: Random, _: list[bytes]) -> bytes:
    start, stop = _run(data, chance)
    return data[:start] + data[start:stop] * chance.choice([2, 3, 50]) + data[stop:]


def _splice(data: bytes, chance: Random, others: list[bytes]) -> bytes:
    other = chance.choice(others)
    start, stop = _run(other, chance)
    position = chance.randrange(len(data) + 1)
    return data[:position] + other[start:stop] + data[position:]


def _truncate(data: bytes, chance: Random, _: list[bytes]) -> bytes:
    return data[: chance.randrange(len(data) + 1)]


def _set_number(data: bytes, chance: Random, _: list[bytes]) -> bytes:
    """Replace a digit in text, or four bytes of another file, by a number that is often handled wrongly."""
    places = [position for position, byte in enumerate(data) if 48 <= byte <= 57]
    if not data.lstrip().startswith(b"<") or not places:
        position = chance.randrange(len(data) + 1)
        value = chance.choice([0, 1, 0xFFFF, 0x7FFFFFFF, 0xFFFFFFFF])
        return data[:position] + struct.pack(chance.choice("<>") + "I", value) + data[position + 4 :]
    position = chance.choice(places)
    word = chance.choice([b"0", b"-1", b"1e9", b"1e38", b"-1e-38", b"1e999", b"nan", b"99999999999", b".0001", b"5%"])
    return data[:position] + word + data[position + 1 :]


def _set_value(data: bytes, chance: Random, others: list[bytes]) -> bytes:
    """Replace a quoted value in text by another one, so that the file stays well-formed."""
    values = _VALUE.findall(chance.choice(others))
    places = list(_VALUE.finditer(data))
    if not data.lstrip().startswith(b"<") or not places or not values:
        return _set_byte(data, chance, others)
    place = chance.choice(places)
    return data[: place.start()] + chance.choice(values) + data[place.end() :]


def _run(data: bytes, chance: Random) -> tuple[int, int]:
    start = chance.randrange(len(data) + 1)
    return start, min(len(data), start + chance.choice([1, 2, 4, 16, 64]))


_VALUE = re.compile(rb"\"[^\"<>]*\"")
_CHANGES = [_flip_bit, _set_byte, _cut, _repeat, _splice, _truncate, *(4 * [_set_number]), *(4 * [_set_value])]


def with_checksums(data: bytes) -> bytes:
    """Return a PNG with its checksums corrected, so that they do not reveal the damage."""
    parts, position = [data[:8]], 8
    while position + 12 <= len(data):
        (length,) = struct.unpack_from(">I", data, position)
        body = data[position + 4 : position + 8 + length]
        parts.append(data[position : position + 4] + body + struct.pack(">I", zlib.crc32(body)))
        position += 12 + length
    return b"".join(parts)
