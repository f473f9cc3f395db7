"""Read damaged files: each must give a result or an error of one line, fast and with little memory.

    python tests/support/fuzz.py svg 10000       # by hand: kind and number of files; --seed N for other files

It runs as a process of its own with limited memory. The readers' limits are lowered to sizes that a test can afford.
"""

from __future__ import annotations

import argparse
import faulthandler
import json
import random
import re
import resource
import struct
import sys
import time
import warnings
import zlib
from collections import Counter
from collections.abc import Callable

import fuzz_files

MAX_PIXELS = 2**20
"""Largest image and largest drawing in pixels, in place of the readers' own limits."""

MEMORY = 2**30
"""Address space in bytes beyond that of the imports: about a hundred times that of the largest canvas."""

CASE_SECONDS = 5.0
"""Time limit for one file; drawing in the child process may take 2 seconds of it."""

DRAWN = 4
"""One SVG of so many is also drawn, because most drawings take a child process."""

HANG_SECONDS = 60.0
"""Time after which the process ends with a traceback, because native code hangs."""

Reader = tuple[Callable[[bytes], object], int]
"""A function, and the step between the files that it reads."""


def mutate(data: bytes, random: random.Random, others: list[bytes]) -> bytes:
    """Return ``data`` after one to four changes of bits, bytes, runs of bytes, numbers, values, or its end."""
    for _ in range(random.choice([1, 1, 2, 4])):
        data = random.choice(_CHANGES)(data, random, others)
    return data


def _flip_bit(data: bytes, random: random.Random, _: list[bytes]) -> bytes:
    return _changed(data, random, lambda byte: byte ^ 1 << random.randrange(8))


def _set_byte(data: bytes, random: random.Random, _: list[bytes]) -> bytes:
    return _changed(data, random, lambda _: random.choice([0, 1, 127, 128, 255, 45, 57, 34, 60, 32]))


def _changed(data: bytes, random: random.Random, change: Callable[[int], int]) -> bytes:
    if not data:
        return data
    position = random.randrange(len(data))
    return data[:position] + bytes([change(data[position])]) + data[position + 1 :]


def _cut(data: bytes, random: random.Random, _: list[bytes]) -> bytes:
    start, stop = _run(data, random)
    return data[:start] + data[stop:]


def _repeat(data: bytes, random: random.Random, _: list[bytes]) -> bytes:
    start, stop = _run(data, random)
    return data[:start] + data[start:stop] * random.choice([2, 3, 50]) + data[stop:]


def _splice(data: bytes, random: random.Random, others: list[bytes]) -> bytes:
    other = random.choice(others)
    start, stop = _run(other, random)
    position = random.randrange(len(data) + 1)
    return data[:position] + other[start:stop] + data[position:]


def _truncate(data: bytes, random: random.Random, _: list[bytes]) -> bytes:
    return data[: random.randrange(len(data) + 1)]


def _set_number(data: bytes, random: random.Random, _: list[bytes]) -> bytes:
    """Replace a digit in text, or four bytes of another file, by a number that is often handled wrongly."""
    places = [position for position, byte in enumerate(data) if 48 <= byte <= 57]
    if not data.lstrip().startswith(b"<") or not places:
        position = random.randrange(len(data) + 1)
        value = random.choice([0, 1, 0xFFFF, 0x7FFFFFFF, 0xFFFFFFFF])
        return data[:position] + struct.pack(random.choice("<>") + "I", value) + data[position + 4 :]
    position = random.choice(places)
    word = random.choice([b"0", b"-1", b"1e9", b"1e38", b"-1e-38", b"1e999", b"nan", b"99999999999", b".0001", b"5%"])
    return data[:position] + word + data[position + 1 :]


def _set_value(data: bytes, random: random.Random, others: list[bytes]) -> bytes:
    """Replace a quoted value in text by another one, so that the file stays well-formed."""
    values = _VALUE.findall(random.choice(others))
    places = list(_VALUE.finditer(data))
    if not data.lstrip().startswith(b"<") or not places or not values:
        return _set_byte(data, random, others)
    place = random.choice(places)
    return data[: place.start()] + random.choice(values) + data[place.end() :]


def _run(data: bytes, random: random.Random) -> tuple[int, int]:
    start = random.randrange(len(data) + 1)
    return start, min(len(data), start + random.choice([1, 2, 4, 16, 64]))


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


def damaged_files(kind: str, count: int, seed: int) -> list[bytes]:
    """Return ``count`` damaged copies of the seed files of ``kind``, the same for the same ``seed``."""
    seeds, chance = fuzz_files.seeds(kind), random.Random(f"{kind} {seed}")
    files = [mutate(chance.choice(seeds), chance, seeds) for _ in range(count)]
    return [with_checksums(data) if kind == "png" and chance.random() < 0.8 else data for data in files]


def image_reader() -> list[Reader]:
    from warpvec.image import read as image

    image.MAX_PIXELS = MAX_PIXELS
    return [(image.read_image, 1)]


def svg_readers() -> list[Reader]:
    from warpvec.svg import measure, resvg, units
    from warpvec.svg.read import read_svg
    from warpvec.svg.write import write_svg

    units.MAX_PIXELS, resvg.MAX_SECONDS, resvg.MAX_MEMORY = MAX_PIXELS, 2.0, MEMORY

    def read_and_write(data: bytes) -> None:
        drawing = read_svg(data)
        write_svg(drawing.scene, 64, 64)

    return [(read_and_write, 1), (measure.file_facts, 1), (measure.draw, DRAWN)]


def check(kind: str, count: int, seed: int) -> dict[str, object]:
    """Count the outcomes, and list every fault: number of the file, name of the reader, what happened instead."""
    readers = svg_readers() if kind == "svg" else image_reader()
    for data in fuzz_files.seeds(kind):
        for read, _ in readers:
            read(data)
    _limit_memory()
    outcomes: Counter[str] = Counter()
    faults: list[tuple[int, str, str]] = []
    for number, data in enumerate(damaged_files(kind, count, seed)):
        for read in (read for read, every in readers if number % every == 0):
            outcome = _outcome(read, data)
            if outcome in ("result", "refused"):
                outcomes[outcome] += 1
            else:
                faults.append((number, read.__name__, outcome))
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss >> 10
    return {"outcomes": dict(outcomes), "faults": faults, "peak_mb": peak}


def _outcome(read: Callable[[bytes], object], data: bytes) -> str:
    from warpvec.errors import InputError

    faulthandler.dump_traceback_later(HANG_SECONDS, exit=True)
    start, outcome = time.perf_counter(), "result"
    try:
        read(data)
    except InputError as error:
        in_one_line = "\n" not in str(error) and len(str(error)) <= 500
        outcome = "refused" if in_one_line else f"message: {error}"
    except BaseException as error:
        outcome = repr(error)[:500]
    finally:  # or the timer would end the caller
        faulthandler.cancel_dump_traceback_later()
    seconds = time.perf_counter() - start
    return outcome if seconds <= CASE_SECONDS else f"{outcome} after {seconds:.1f} s"


def _limit_memory() -> None:
    with open("/proc/self/statm") as file:
        used = int(file.read().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + MEMORY, used + MEMORY))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("kind", choices=["png", "jpeg", "webp", "tiff", "svg"])
    parser.add_argument("count", type=int)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    warnings.simplefilter("error")
    print(json.dumps(check(options.kind, options.count, options.seed)))


if __name__ == "__main__":
    main()
    sys.stdout.flush()
