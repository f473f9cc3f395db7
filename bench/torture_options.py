"""Numeric options of every command, and numeric settings, at their edges and far beyond them."""

from __future__ import annotations

import json
import math
import os
import random
import tomllib
from functools import cache
from pathlib import Path
from typing import Any

from torture_case import OK, Case
from torture_commands import invoked
from torture_image_files import seeds

SECONDS = 20.0
"""Time limit of a case; longer is a hang. Cases with the largest numbers of paths have ten times as much."""

SMALL = {
    "curves": 8, "iterations": 3, "threads": 1, "fit_size": 32, "samples": 8, "lines": 4, "initial_curves": 4,
    "device": "cpu", "time_budget": 2,
}  # fmt: skip
"""Settings that keep a fit small; the one under test takes the place of its own."""

VALUES = (
    "nan", "inf", "-inf", "Infinity", "1e308", "-1e308", "1e309", "1e-320", "-0", "-0.0", "0", "1", "2", "-1", "0.5",
    "1.5", "", " ", "+1", " 1", "1 ", "1\n", "1_000", "_1", "\u0661\u0662", "\uff13", "\u00bd", "\u00b2", "\u2212" "1",
    "0x10", "1e3", "1,5", "auto", "true", "1" * 5000, "9" * 400, "1e" + "9" * 5000, "0." + "1" * 5000, "2147483647",
    "2147483648", "4294967296", "9223372036854775807", "9223372036854775808", "-9223372036854775809", "1000000",
    "1000000000000",
)  # fmt: skip
"""Texts for any number: not finite, huge, tiny, with other signs, digits, underscores and spaces, and no numbers."""

_PYTHON_VALUES: tuple[Any, ...] = (
    math.nan, math.inf, -math.inf, 1e308, -1e308, 5e-324, -0.0, 0, 1, 2, -1, 0.5, True, "1", "", b"1", [], {}, 1j,
    10**6, 10**12, 2**31 - 1, 2**31, 2**63 - 1, 2**63, -(2**63) - 1, 10**400, 10**5000,
)  # fmt: skip


def case(chance: random.Random) -> Case:
    """Return one command or call with one or two random values."""
    way = chance.choice(["line", "toml", "python"])
    command = "vectorize" if way == "python" else chance.choice(["run", "run", "refine"])
    names = chance.sample(_settings() if way != "line" else numeric_options()[command], chance.choice([1, 2]))
    if way == "toml":
        names = [name for name in names if name in _settings()]
    values = {name: chance.choice(values_of(name) if way == "python" else texts_of(name)) for name in names}
    # Tens of thousands of paths take their time by right.
    seconds = 10 * SECONDS if {"curves", "initial_curves"} & values.keys() else SECONDS
    name = f"{way} {command} {', '.join(f'{name}={_short(value)}' for name, value in values.items())}"
    return Case(name[:300], lambda folder: check(way, command, values, folder), repr(values).encode(), seconds)


def check(way: str, command: str, values: dict[str, Any], folder: Path) -> str:
    """Give ``values`` to a command by its "line" or by a "toml" file, or to `warpvec.vectorize` in "python"."""
    os.chdir(folder)
    Path("photo.png").write_bytes(seeds("png")[0])
    Path("in.svg").write_text(_DRAWING)
    small = {name: value for name, value in SMALL.items() if name not in values}
    if way == "python":
        import warpvec

        warpvec.vectorize("photo.png", **{**small, **values}).svg()
        return OK
    words = {"run": ["photo.png", "out.svg"], "refine": ["photo.png", "out.svg", "--from", "in.svg"]}[command]
    lines = "\n".join(f"{name} = {value if _is_toml(value) else json.dumps(value)}" for name, value in values.items())
    Path("settings.toml").write_text(lines, encoding="utf-8")
    given = ["--config", "settings.toml"] if way == "toml" else _options_of(values)
    return invoked([command, *words, *_options_of(small), *given])


def _options_of(values: dict[str, Any]) -> list[str]:
    return [f"--{name.replace('_', '-')}={value}" for name, value in values.items()]


_DRAWING = (
    '<svg xmlns="http://www.w3.org/2000/svg" width="24" height="16"><path d="M1 1h9v9z"/><path d="M5 5h9v9z"/></svg>'
)


def _is_toml(text: str) -> bool:
    try:
        return bool(tomllib.loads(f"a = {text}"))
    except (ValueError, RecursionError):
        return False


def _short(value: Any) -> str:
    if isinstance(value, int) and abs(value) > 10**50:
        return f"an integer of {value.bit_length()} bits"
    shown = " ".join(repr(value).split())
    return shown if len(shown) <= 40 else f"{shown[:20]}...({len(shown)} characters)"


@cache
def numeric_options() -> dict[str, tuple[str, ...]]:
    """Return the options of each command that take a number, as its click parameters and their kinds say."""
    import click

    from warpvec.cli.main import main
    from warpvec.cli.options import OPTIONS

    plain = (click.types.IntParamType, click.types.FloatParamType)
    numeric = {name for name, option in OPTIONS.items() if _is_number(option.kind)}
    context, found = click.Context(main), {}
    for command in main.list_commands(context):
        parameters = main.get_command(context, command).params
        options = [option for option in parameters if isinstance(option, click.Option) and not option.is_flag]
        numbers = [each for each in options if isinstance(each.type, plain) or each.name in numeric]
        found[command] = tuple(each.opts[0].lstrip("-").replace("-", "_") for each in numbers if not each.count)
    return {command: names for command, names in found.items() if names}


@cache
def _settings() -> tuple[str, ...]:
    """Return the numeric arguments of `warpvec.vectorize`: settings and goals."""
    return tuple(name for name, each in _numbers().items() if _is_number(each.kind))


def _numbers() -> dict[str, Any]:
    from warpvec.config.fit_config import SETTINGS
    from warpvec.goals.registry import QUANTITIES

    return {**SETTINGS, **QUANTITIES}


def _is_number(kind: Any) -> bool:
    """Return whether values of a setting of this kind may be numbers."""
    try:
        kind.parse("value", "1")
    except Exception:
        return False
    return not isinstance(kind.parse("value", "1"), bool | str)


def limits_of(name: str) -> tuple[float, ...]:
    """Return the finite ends of the range of a setting."""
    kind = getattr(_numbers().get(name), "kind", None)
    ends = [getattr(kind, end, None) for end in ("low", "high")]
    return tuple(end for end in ends if end is not None and math.isfinite(end))


def values_of(name: str) -> list[Any]:
    """Return Python values of a setting: its ends, their neighbours, and those of any number."""
    import numpy as np

    beside = [
        near for end in limits_of(name)
        for near in ((end - 1, end, end + 1) if isinstance(end, int)
                     else (math.nextafter(end, -math.inf), end, math.nextafter(end, math.inf)))
    ]  # fmt: skip
    arrays = [np.int8(-1), np.uint64(2**64 - 1), np.float32("nan"), np.float64(1), np.zeros(2), np.array(3)]
    return [*beside, *_PYTHON_VALUES, *arrays]


def texts_of(name: str) -> list[str]:
    """Return texts for an option: the ends of its range, their neighbours, and those of any number."""
    beside = [repr(value) for value in values_of(name)[: 3 * len(limits_of(name))]]
    return list(dict.fromkeys([*beside, *VALUES]))
