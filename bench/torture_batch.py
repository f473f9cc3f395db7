"""Folders of files with hostile names and of hostile kinds, through the command `warpvec batch`."""

from __future__ import annotations

import csv
import json
import os
import re
import socket
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from random import Random

import torture_image_files as images
from torture_case import OK, REFUSED, Case, Wrong, limit
from torture_changes import mutate

BASE = ("--curves", "4", "--iterations", "2", "--fit-size", "16", "--jobs", "1", "--threads", "1", "--device", "cpu")
"""Options that keep the batch small."""

SECONDS = 90.0
"""Time limit of a batch: it starts a process that imports torch, and one more that fits, and may do so twice."""

NAMES = (
    b"a.png", b"A.png", b"a.PNG", b"a.jpg", b"a.png.png", b"a\nb.png", b"a\r\nb.png", b"a\tb.png", b"\x1b[31mred.png",
    b"\x07.png", b"\x7f.png", b"=1+1.png", b"+1.png", b"-a.png", b"--json.png", b"@x.png", b"|x.png", b"\xff\xfe.png",
    b"\xed\xa0\x80.png", "\u202egnp.png".encode(), "\u00e9.png".encode(), "e\u0301.png".encode(), b" .png", b"a .png",
    b"a,b.png", b'a"b.png', b"'a.png", b"a;b.png", b"$(x).png", b"%s.png", b"{0}.png", b"..png", b"...png", b".a.png",
    b"a\\b.png", b"CON.png", b"batch.csv", b"batch.jsonl", b"batch.csv.png", b"[bold]x.png", b"[x].png",
    b"*.png", b"x" * 251 + b".png", b"x" * 250 + b".webp", b"\xc3\xa9" * 125 + b".png", b"a.svg", b"a.svgz", b"a.txt",
    b"png", b"<b>.png", b"a&b.png", b"http:.png", b"~.png", b"a#b.png", b"a?b.png", b"nul\xe2\x80\xa8line.png",
)  # fmt: skip

_NO_FORMULA = re.compile(r"[=+\-@\t\r]")


def case(chance: Random) -> Case:
    """Return one batch, which may run twice."""
    entries = {}
    for name in chance.sample(NAMES, chance.choice([1, 3, 8])):
        entries[name] = chance.choice(list(KINDS)) if chance.random() < 0.4 else "photo"
    in_folder = chance.random() < 0.3
    options = [word for word in ("--recursive", "--svgz", "--keep-suffix", "--json") if chance.random() < 0.3]
    options += ["--retry", chance.choice(["0", "1"])]
    options += chance.choice([[], [], [], ["--quiet"], ["--skip-existing"]])
    old = chance.choices(list(OLD), [12, 1, 1, 1, 1, 1, 1])[0]
    source = "in/inner\n" if in_folder else "in"
    inner, count = Random(chance.getrandbits(32)), chance.choice([1, 1, 1, 1, 2])
    return Case(
        f"{options}, {old}, {entries}"[:300],
        lambda folder: check(folder, entries, options, old, inner, source, count),
        repr((entries, options, old)).encode(),
        SECONDS,
    )


def check(
    folder: Path,
    entries: dict[bytes, str],
    options: list[str],
    old: str,
    chance: Random,
    source: str = "in",
    count: int = 1,
) -> str:
    """Run a batch ``count`` times: ``entries`` are names and `KINDS` of the files in ``source``, ``old`` one of `OLD`.

    Raises:
        Wrong: exit code, log or records break a rule.
    """
    (folder / source).mkdir(parents=True)
    (folder / "out").mkdir()
    OLD[old](folder / "out")
    for name, kind in entries.items():
        KINDS[kind](os.fsencode(folder / source) + b"/" + name, chance)
    return [_batch(folder, options) for _ in range(count)][-1]


def _batch(folder: Path, options: list[str]) -> str:
    """Run the command once and check what it wrote."""
    command = [sys.executable, "-m", "warpvec", "batch", "in", "out", *BASE, *options]
    done = subprocess.run(command, cwd=folder, capture_output=True, timeout=limit(SECONDS), check=False)
    text = (done.stdout + done.stderr).decode(errors="surrogateescape")
    if done.returncode not in (0, 1, 2) or "Traceback" in text or "-debug" in text:
        raise Wrong(f"exit code {done.returncode}: {text[-300:]!r}")
    if re.search(r"[\x00-\x08\x0b\x0e-\x1f\x7f]", text):
        raise Wrong(f"control characters in the log: {text[-300:]!r}")
    if any(line.startswith(("b.png", "/")) for line in text.splitlines()):
        raise Wrong(f"a line that is split: {text[-300:]!r}")
    if done.returncode == 2:
        return REFUSED
    _check_records(folder / "out", done.returncode)
    return OK


def _check_records(out: Path, code: int) -> None:
    """Check that both files of records can be read, agree, and hold no formula."""
    if not (out / "batch.jsonl").is_file():
        return
    records = [json.loads(line) for line in (out / "batch.jsonl").read_text().split("\n") if line]
    with open(out / "batch.csv", newline="", encoding="utf-8", errors="surrogateescape") as stream:
        rows = list(csv.DictReader(stream))
    if len(rows) != len(records):
        raise Wrong(f"{len(rows)} rows in the CSV for {len(records)} records")
    for row in rows:
        if any(_NO_FORMULA.match(row[name] or "") for name in ("input", "output", "error")):
            raise Wrong(f"a formula in the CSV: {row['input']!r}")
    failed = [record for record in records if record["error"]]
    if any("\n" in record["error"] for record in failed):
        raise Wrong(f"an error of two lines: {failed[0]['error']!r}")
    if code == 1 and not failed:
        raise Wrong("exit code 1 without a failure in the records")
    for record in records:
        if not record["error"] and not (out / record["output"]).is_file():
            raise Wrong(f"no file {record['output']!r}")


def _photo(path: bytes, chance: Random) -> None:
    data = images.seeds(chance.choice(["png", "jpeg", "webp"]))[0]
    with open(path, "wb") as stream:
        stream.write(data)


def _damaged(path: bytes, chance: Random) -> None:
    seeds = images.seeds(chance.choice(images.KINDS))
    with open(path, "wb") as stream:
        stream.write(mutate(chance.choice(seeds), chance, seeds))


def _empty(path: bytes, chance: Random) -> None:
    open(path, "wb").close()


def _folder(path: bytes, chance: Random) -> None:
    os.mkdir(path)


def _locked_folder(path: bytes, chance: Random) -> None:
    os.mkdir(path, 0)


def _unreadable(path: bytes, chance: Random) -> None:
    _photo(path, chance)
    os.chmod(path, 0)


def _pipe(path: bytes, chance: Random) -> None:
    os.mkfifo(path)


def _socket(path: bytes, chance: Random) -> None:
    before = os.getcwd()
    os.chdir(os.path.dirname(path))  # the address of a socket may have 108 bytes
    try:
        with socket.socket(socket.AF_UNIX) as made:
            made.bind(os.path.basename(path)[-100:])
    finally:
        os.chdir(before)


def _link_to(target: bytes) -> Callable[[bytes, Random], None]:
    return lambda path, chance: os.symlink(target, path)


def _loop(path: bytes, chance: Random) -> None:
    os.symlink(os.path.basename(path), path)


KINDS: dict[str, Callable[[bytes, Random], None]] = {
    "photo": _photo, "damaged": _damaged, "empty": _empty, "folder": _folder, "locked folder": _locked_folder,
    "unreadable": _unreadable, "pipe": _pipe, "socket": _socket, "loop": _loop,
    "dangling link": _link_to(b"missing.png"), "link to its folder": _link_to(b"."), "link above": _link_to(b"../.."),
    "endless": _link_to(b"/dev/zero"), "memory": _link_to(b"/proc/self/mem"), "no file": _link_to(b"/dev/null"),
}  # fmt: skip
"""What may have the name of an image."""


def _write(name: str, data: bytes) -> Callable[[Path], None]:
    def write(out: Path) -> None:
        (out / name).write_bytes(data)

    return write


OLD: dict[str, Callable[[Path], None]] = {
    "new": lambda out: None,
    "cut records": _write("batch.jsonl", b'{"input": "a.png", "outp'),
    "other records": _write("batch.jsonl", b'{"input": 1}\n[]\n'),
    "binary records": _write("batch.jsonl", b"\xff\x00\n"),
    "table is a folder": lambda out: (out / "batch.csv").mkdir(),
    "records are a folder": lambda out: (out / "batch.jsonl").mkdir(),
    "output is a folder": lambda out: (out / "a.svg").mkdir(),
}
"""What is in the folder for the SVGs before."""
