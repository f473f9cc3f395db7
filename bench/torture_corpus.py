"""Every fault that was ever found, as the smallest input that showed it: `tests/corpus`.

Its folders `images`, `svgs` and `toml` hold files, each of which is read in every way. What is described more briefly
than it is stored is in JSON: `checkpoints.json` (name of the fit, changes), `commands.json` (arguments), `options.json`
(values of numeric options), `batch.json` (names and kinds of files), `largest.json` (colour type of the largest PNG).
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from functools import cache
from pathlib import Path
from random import Random
from typing import Any

import torture_batch
import torture_checkpoints
import torture_commands
import torture_images
import torture_options
import torture_svgs
import torture_toml
from torture_case import OK, REFUSED, Case

FOLDER = Path(__file__).resolve().parent.parent / "tests" / "corpus"


LARGEST = "largest"
"""Beginning of the names of cases that take 2 GB."""


@cache
def entries() -> list[tuple[str, Any]]:
    """Return the names of all cases, the largest ones at the end, with what `case_at` needs."""
    found: list[tuple[str, Any]] = []
    for kind in _FILES:
        found += [(f"{kind}/{path.name}", path) for path in sorted((FOLDER / kind).iterdir())]
    for kind in _DESCRIBED:
        described = json.loads((FOLDER / f"{kind}.json").read_text())
        found += [(f"{kind}: {entry['fault']}", entry) for entry in described]
    return found


def case_at(number: int) -> Case:
    """Return a case of the corpus."""
    name, entry = entries()[number]
    kind = name.partition("/")[0].partition(":")[0]
    if kind in _DESCRIBED:
        seconds = torture_batch.SECONDS if kind == "batch" else 20.0
        return Case(name, lambda folder: _DESCRIBED[kind](entry, folder), json.dumps(entry).encode(), seconds)
    data = entry.read_bytes()
    ways = _FILES[kind]
    return Case(name, lambda folder: _in_every_way(data, folder, ways), data, seconds=20.0 * len(ways))


def _in_every_way(data: bytes, folder: Path, ways: list[Callable[[bytes, Path], str]]) -> str:
    """Read ``data`` in all ``ways``, each in a folder of its own; return `OK` if one of them was."""
    from warpvec.errors import InputError

    outcomes = set()
    for number, way in enumerate(ways):
        place = folder / str(number)
        place.mkdir()
        os.chdir(place)
        try:
            outcomes.add(way(data, place))
        except InputError:
            outcomes.add(REFUSED)
    return OK if OK in outcomes else REFUSED


def _checkpoint(entry: dict[str, Any], folder: Path) -> str:
    header, arrays = torture_checkpoints.unpacked(torture_checkpoints.checkpoint_of(entry["fit"]))
    for path, change, value in entry["changes"]:
        torture_checkpoints.changed(header, arrays, path, change, value)
    return torture_checkpoints.check(torture_checkpoints.packed(header, arrays), folder, entry["fit"])


def _command(entry: dict[str, Any], folder: Path) -> str:
    return torture_commands.check(entry["words"], folder, torture_commands.inputs()[entry.get("stdin", "empty")])


def _batch(entry: dict[str, Any], folder: Path) -> str:
    names = {os.fsencode(name): kind for name, kind in entry["files"].items()}
    return torture_batch.check(folder, names, ["--retry", "1"], entry.get("old", "new"), Random(0))


def _largest(entry: dict[str, Any], folder: Path) -> str:
    return torture_images.check(torture_images.largest_png(entry["color"]), folder, "from bytes")


def _options(entry: dict[str, Any], folder: Path) -> str:
    return torture_options.check(entry["way"], entry.get("command", "run"), entry["values"], folder)


def _ways(check: Callable[[bytes, Path, str], str], names: Any) -> list[Callable[[bytes, Path], str]]:
    return [lambda data, folder, name=name: check(data, folder, name) for name in names]  # type: ignore[misc]


_FILES: dict[str, list[Callable[[bytes, Path], str]]] = {
    "images": _ways(torture_images.check, torture_images.WAYS),
    "svgs": _ways(torture_svgs.check, torture_svgs.READERS),
    "toml": [torture_toml.check],
}
_DESCRIBED = {
    "checkpoints": _checkpoint, "commands": _command, "options": _options, "batch": _batch, "largest": _largest,
}  # fmt: skip
