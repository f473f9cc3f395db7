"""Settings files that are damaged, nested or of wrong types: read, and given to `warpvec run --config`."""

from __future__ import annotations

from pathlib import Path
from random import Random

from torture_case import Case
from torture_changes import mutate
from torture_commands import BASE, NAMES, invoked, value, write_inputs

PLAIN = b"""# Settings of warpvec
preset = "draft"
curves = 8
iterations = 3
colors = 4
seed = 7
min_area = 0.5
opacity = "free"
flat = true
lr-scale = 1e-1
background = "#123"
"""


def case(chance: Random) -> Case:
    """Return one settings file for `warpvec run`, whose fit stays small whatever the file asks for."""
    make = chance.choices([_damaged, _settings, _structure], [3, 4, 2])[0]
    data = make(chance)
    return Case(make.__name__.strip("_"), lambda folder: check(data, folder), data)


def check(data: bytes, folder: Path) -> str:
    """Run a fit with the settings file ``data``."""
    write_inputs(folder)
    (folder / "settings.toml").write_bytes(data)
    return invoked(["run", "photo.png", "out.svg", "--config", "settings.toml", *BASE])


def _damaged(chance: Random) -> bytes:
    return mutate(
        PLAIN, chance, [PLAIN, b"[[\"\"\"{}=,.\n1979-05-27T07:32:00Z inf nan 0x1 0o7 1_0 ''' \\u0000 \\U00110000"]
    )


def _settings(chance: Random) -> bytes:
    lines = []
    for _ in range(chance.choice([1, 1, 2, 5])):
        name = chance.choice([*NAMES, *NAMES, "config", "write_config", "debug", "x", "", "curves ", "a.b", "resume"])
        shown = value(chance, name)
        quoted = chance.choice([f'"{shown}"', f"'{shown}'", shown, shown, "true", "[]", "{}", "1979-05-27", "[1, 2]"])
        lines.append(f"{name} = {quoted}")
    return "\n".join(lines).encode(errors="replace")


def _structure(chance: Random) -> bytes:
    depth = chance.choice([10, 500, 5000, 10**5])
    made: bytes = chance.choice([
        b"curves = " + b"[" * depth, b"curves = " + b"[" * depth + b"]" * depth, b"a={b=" * depth + b"1" + b"}" * depth,
        b"[" + b"a." * depth + b"a]\nx = 1", b"a." * depth + b"a = 1", b"curves = " + b"9" * depth, b"[[a]]\n" * depth,
        b"x" * depth + b" = 1", b"curves = 8\n" * depth, b"#" * depth, b"\n" * depth, b'a = "' + b"\\" * depth + b'"',
        b"curves = 1" + b"0" * depth + b".5", b"curves = 0x" + b"f" * depth, b"\xef\xbb\xbf" + PLAIN, PLAIN + b"\0",
        PLAIN.decode().encode("utf-16"), b"\xff" + PLAIN, PLAIN.replace(b"\n", b"\r"), b"", b"=", b"[run]\n" + PLAIN,
        b"".join(b"k%d = 1\n" % number for number in range(depth // 10)), b'palette = "' + b"red," * depth + b'"',
    ])  # fmt: skip
    return made
