"""Run warpvec with full disks, closed streams and endless inputs, and check its exit code, messages and files.

- A full disk holds one or more of OUT, the checkpoint, the frames, the video, the page and the settings, from the
  start or after some kilobytes. The others must be whole. The exit code is 1 if OUT is lost, else 0. Every file that is
  lost is named in one line, and no half file and no temporary file stays. The disk is a tmpfs of its own, which only
  root can mount; without root these cases are left out.
- Every combination of closed stdin, stdout and stderr: a run from file to file works, a run that needs a closed stream
  is refused in one line.
- Endless inputs (/dev/zero, and a stream that begins like a picture) are refused.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from random import Random

import numpy as np
from PIL import Image
from torture_case import OK, REFUSED, Case, Wrong, limit

FILES = {
    "OUT": "out.svg",
    "--checkpoint": "state",
    "--save-frames": "frames",
    "--video": "fit.gif",
    "--report": "page.html",
    "--write-config": "settings.toml",
}
"""Name of an output on the command line -> its file."""

VIDEOS = (".gif", ".webp", ".mp4")

FIT = ["--curves", "24", "--iterations", "12", "--every", "1", "--device", "cpu", "-q"]
"""A short fit whose outputs are larger than the blocks of a disk."""

DISK_BYTES = 2**20

MAX_FREE = 2**17
"""Most bytes that are free on a full disk. It is more than each of the files takes, so that some still fit."""

RUN_SECONDS = 120.0
"""A run that takes longer hangs."""

ENDLESS = {
    "zeros as image": ["eval", "/dev/zero", "{svg}"],
    "zeros as image on stdin": ["eval", "-", "{svg}"],
    "zeros as SVG": ["eval", "{photo}", "/dev/zero"],
    "zeros as SVG on stdin": ["eval", "{photo}", "-"],
    "zeros as IN": ["run", "/dev/zero", "{out}"],
    "zeros as settings": ["run", "{photo}", "{out}", "--config", "/dev/zero"],
    "zeros as palette": ["run", "{photo}", "{out}", "--palette", "/dev/zero"],
    "zeros as checkpoint": ["run", "{photo}", "{out}", "--resume", "/dev/zero"],
    "zeros as drawing": ["refine", "{photo}", "{out}", "--from", "/dev/zero"],
    "zeros as history": ["view", "{svg}", "--history", "/dev/zero", "--report", "{page}"],
    "zeros as levels": ["lod", "/dev/zero"],
    "the memory as image": ["run", "/proc/self/mem", "{out}"],
    "the memory as SVG": ["eval", "{photo}", "/proc/self/mem"],
}
"""What is read -> arguments of warpvec. Each must be refused."""

PREFIXES = {
    "png": b"\x89PNG\r\n\x1a\n",
    "tiff": b"II*\0\x08\0\0\0",
    "bmp": b"BM",
    "svg": b"<svg>",
    "gzip": b"\x1f\x8b\x08",
}
"""Beginnings of streams that look like a picture or a drawing and then never end."""


def case(chance: Random) -> Case:
    """Return one full disk, one combination of closed streams, or one endless input."""
    undisturbed()  # here, and not in the process of each case
    kind = chance.choices(["disk", "streams", "endless"], [6 if can_mount() else 0, 2, 2])[0]
    if kind == "streams":
        closed = tuple(number for number in range(3) if chance.random() < 0.5)
        return Case(f"closed {closed}", lambda folder: check_closed(folder, closed), seconds=RUN_SECONDS)
    if kind == "endless":
        name = chance.choice([*ENDLESS, *PREFIXES])
        return Case(f"endless {name}", lambda folder: check_endless(folder, name), seconds=RUN_SECONDS)
    full = chance.sample(list(FILES), chance.choice([1, 1, 1, 2, 3]))
    free = chance.choice([0, chance.randrange(MAX_FREE)])
    video = chance.choice(VIDEOS)
    name = f"full disk for {', '.join(full)} after {free} bytes, {video}"
    return Case(name, lambda folder: check_full_disk(folder, full, free, video), seconds=RUN_SECONDS)


# full disks


@contextmanager
def small_disk(folder: Path, free: int = 0) -> Iterator[Path]:
    """Yield an empty folder on a disk of its own with ``free`` bytes, rounded to blocks.

    Raises:
        OSError: this process may not mount disks.
    """
    place = folder / "disk"
    place.mkdir()
    options = ["-t", "tmpfs", "-o", f"size={DISK_BYTES}", "none"]
    try:
        done = subprocess.run(["mount", *options, place], capture_output=True, check=False)
    except FileNotFoundError as error:
        raise OSError("there is no command mount") from error
    if done.returncode:
        raise OSError(done.stderr.decode().strip())
    try:
        with suppress(OSError), open(place / "ballast", "wb", buffering=0) as file:
            while True:
                file.write(bytes(4096))
        os.truncate(place / "ballast", DISK_BYTES - free)
        (place / "files").mkdir()
        yield place / "files"
    finally:
        subprocess.run(["umount", "-l", place], check=True)


@cache
def can_mount() -> bool:
    """Return whether this process may mount a disk."""
    try:
        with tempfile.TemporaryDirectory() as name, small_disk(Path(name)):
            return True
    except OSError:
        return False


def check_full_disk(folder: Path, full: Sequence[str], free: int, video: str) -> str:
    """Run with the outputs ``full`` on a disk with ``free`` bytes; return `OK`.

    Raises:
        Wrong: a file that fits is not whole, a half file stays, or the exit code or the messages are wrong.
    """
    photo = write_photo(folder)
    with small_disk(folder, free) as disk:
        places = {
            name: (disk if name in full else folder)
            / Path(file).with_suffix(video if name == "--video" else Path(file).suffix)
            for name, file in FILES.items()
        }
        others = [str(word) for name, place in places.items() if name != "OUT" for word in (name, place)]
        code, stderr = run(["run", photo, places["OUT"], *others, *FIT])
        lost = [name for name, place in places.items() if not is_whole(name, place)]
        _check_lost(lost, full, code, stderr)
        expected = undisturbed()
        if "OUT" not in lost and places["OUT"].read_bytes() != expected:
            raise Wrong("OUT has other bytes than without a full disk")
        for place in (folder, disk):
            left = [path.name for path in place.rglob(".warpvec-*")]
            if left:
                raise Wrong(f"left over: {left}")
        halves = [name for name in lost if name != "--save-frames" and places[name].exists()]
        if halves:
            raise Wrong(f"half files of {halves}")
    return OK


def _check_lost(lost: Sequence[str], full: Sequence[str], code: int, stderr: str) -> None:
    if not set(lost) <= set(full):
        raise Wrong(f"lost {lost} with a full disk only for {full}: {stderr}")
    if code != int("OUT" in lost):
        raise Wrong(f"exit code {code} with {lost} lost: {stderr}")
    lines = stderr.splitlines()
    # A checkpoint may fail once and fit the next time, when the old one has made room.
    wanted = {name: f"warpvec: warning: {name} could not be written (" for name in FILES if name != "OUT"}
    wanted["OUT"] = "warpvec: error: '"  # its name, and where the drawing is
    for name in lost:
        if sum(line.startswith(wanted[name]) for line in lines) != 1:
            raise Wrong(f"no single line about {name}: {stderr}")
    if any(not line.startswith(tuple(wanted[name] for name in full)) for line in lines):
        raise Wrong(f"other lines: {stderr}")


def is_whole(name: str, path: Path) -> bool:
    """Return whether the output ``name`` was written to its end."""
    if not path.exists():
        return False
    if name == "--save-frames":
        return len(list(path.glob("*.png"))) == 12 and all(_frame_count(frame) == 1 for frame in path.iterdir())
    if name == "--video":
        return path.stat().st_size > 0 and (path.suffix == ".mp4" or _frame_count(path) > 1)
    ends = {"OUT": b"</svg>\n", "--report": b"</html>\n", "--write-config": b"\n"}
    return path.stat().st_size > 0 and path.read_bytes().endswith(ends.get(name, b""))


def _frame_count(path: Path) -> int:
    with Image.open(path) as image:
        count = getattr(image, "n_frames", 1)
        image.seek(count - 1)
        image.load()
    return count


# streams


def check_closed(folder: Path, closed: Sequence[int]) -> str:
    """Run with the streams ``closed``, from file to file, from stdin and to stdout; return `OK`.

    Raises:
        Wrong: a run that needs no stream fails, or one that needs a closed stream is not refused in one line.
    """
    photo, out = write_photo(folder), folder / "out.svg"
    code, stderr = run(["run", photo, out, *FIT], closed=closed)
    if code != 0 or stderr or out.read_bytes() != undisturbed():
        raise Wrong(f"from file to file: exit code {code}: {stderr}")
    for number, arguments in ((0, ["eval", "-", out]), (1, ["run", photo, "-", *FIT])):
        with photo.open("rb") as stdin:
            code, stderr = run(arguments, closed=closed, stdin=stdin.fileno())
        if code != (2 if number in closed else 0):
            raise Wrong(f"{arguments}: exit code {code}: {stderr}")
        if number in closed and 2 not in closed and stderr.count("\n") != 1:
            raise Wrong(f"{arguments}: {stderr}")
    left = sorted(os.listdir(folder))
    if left != ["out.svg", "photo.png"]:
        raise Wrong(f"files after it: {left}")
    return OK


# endless inputs


def check_endless(folder: Path, name: str) -> str:
    """Give one of `ENDLESS` or `PREFIXES`; return `REFUSED`.

    Raises:
        Wrong: it is not refused in one line.
    """
    photo, svg = write_photo(folder), folder / "drawing.svg"
    svg.write_bytes(undisturbed())
    arguments = ENDLESS.get(name) or (["eval", photo, "-"] if name in ("svg", "gzip") else ["eval", "-", svg])
    paths = {"photo": photo, "svg": svg, "out": folder / "out.svg", "page": folder / "page.html"}
    words = [str(word).format(**paths) for word in arguments]
    with _endless(PREFIXES.get(name, b"")) as stdin:
        code, stderr = run(words, stdin=stdin)
    if code != 2 or stderr.count("\n") != 1:
        raise Wrong(f"exit code {code}: {stderr}")
    return REFUSED


@contextmanager
def _endless(prefix: bytes) -> Iterator[int]:
    """Yield a descriptor that gives ``prefix`` and then zeros without end."""
    if not prefix:
        with open("/dev/zero", "rb") as file:
            yield file.fileno()
        return
    script = "import os, sys; os.write(1, bytes.fromhex(sys.argv[1]))\nwhile True: os.write(1, bytes(65536))"
    command = [sys.executable, "-c", script, prefix.hex()]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as writer:
        assert writer.stdout is not None
        try:
            yield writer.stdout.fileno()
        finally:
            writer.kill()


# runs


def write_photo(folder: Path) -> Path:
    """Write a noisy picture to ``folder`` and return its path."""
    path = folder / "photo.png"
    Image.fromarray(np.random.default_rng(1).integers(0, 256, (48, 64, 3), dtype=np.uint8)).save(path)
    return path


@cache
def undisturbed() -> bytes:
    """Return the SVG of an undisturbed run."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        code, stderr = run(["run", write_photo(folder), folder / "out.svg", *FIT])
        if code != 0:
            raise RuntimeError(f"the undisturbed run failed: {stderr}")
        return (folder / "out.svg").read_bytes()


def run(arguments: Sequence[object], closed: Sequence[int] = (), stdin: int = subprocess.DEVNULL) -> tuple[int, str]:
    """Run warpvec in a process without the streams ``closed``; return its exit code and its stderr."""
    signs = " ".join(f"{number}>&-" for number in closed)
    command = ["sh", "-c", f'exec "$@" {signs}', "sh", sys.executable, "-m", "warpvec", *map(str, arguments)]
    done = subprocess.run(
        command, stdin=stdin, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, timeout=limit(RUN_SECONDS),
        check=False,
    )  # fmt: skip
    return done.returncode, done.stderr
