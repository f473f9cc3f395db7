"""Drive every numeric option of every command, and every numeric setting, at its edges and far beyond them.

    python bench/torture_options.py                       # everything, one process each
    python bench/torture_options.py --only curves,seed    # some options
    python bench/torture_options.py --pairs 500 --seed 1  # that many pairs of options more

Each case is a process of its own: forked, so that it has the imports and compiled kernels already. It must end with
exit code 0 or 2 (from Python: a result or an `InputError` of one line) within `SECONDS`, with at most `MAX_MEMORY`.
What takes long because it was asked for is bounded by a time budget.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import random
import resource
import signal
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields
from functools import cache
from pathlib import Path
from typing import Any

from torture_case import MAX_MEMORY, OK, REFUSED, Case

SECONDS = 20.0
"""Time limit of a case; longer is a hang. Cases with the largest numbers of paths have ten times as much."""

SMALL = {
    "curves": "8", "iterations": "3", "threads": "1", "fit_size": "32", "samples": "8", "lines": "4",
    "initial_curves": "4", "device": "cpu", "time_budget": "2",
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


@dataclass(frozen=True)
class Setup:
    """One value of one or more numeric options, by one way in."""

    way: str
    """"line", "toml" or "python"."""
    command: str
    values: tuple[tuple[str, Any], ...]

    @property
    def name(self) -> str:
        """Return what is done, in a few words."""
        shown = ", ".join(f"{name}={_short(value)}" for name, value in self.values)
        return f"{self.way} {self.command} {shown}"

    @property
    def seconds(self) -> float:
        """Return the time limit; tens of thousands of paths take their time by right."""
        return 10 * SECONDS if {"curves", "initial_curves"} & dict(self.values).keys() else SECONDS


def setups(only: frozenset[str] = frozenset()) -> Iterator[Setup]:
    """Yield every numeric option of every command at every value, by every way in; all of them or those of ``only``."""
    for command, names in numeric_options().items():
        for name in names:
            if only and name not in only:
                continue
            for value in texts_of(name):
                yield Setup("line", command, ((name, value),))
                if command in ("run", "refine") and name in _settings():
                    yield Setup("toml", command, ((name, value),))
    for name in _settings():
        if not only or name in only:
            for value in values_of(name):
                yield Setup("python", "vectorize", ((name, value),))


def pairs(chance: random.Random, count: int) -> Iterator[Setup]:
    """Yield ``count`` random pairs of edge values."""
    for _ in range(count):
        yield _pair(chance)


def case(chance: random.Random) -> Case:
    """Return one random setup, alone or with another, for `bench/torture.py`."""
    setup = _pair(chance)
    if chance.random() < 0.5:
        setup = Setup(setup.way, setup.command, setup.values[:1])
    return Case(setup.name[:300], lambda folder: run_setup(setup, folder), repr(setup).encode(), setup.seconds)


@cache
def numeric_options() -> dict[str, tuple[str, ...]]:
    """Return the options of each command that take a number, as its click parameters say."""
    import click

    from warpvec.cli.main import main
    from warpvec.cli.value_types import ByteCount, CurveCount, Number, WholeNumber

    kinds = (WholeNumber, Number, CurveCount, ByteCount, click.types.IntParamType, click.types.FloatParamType)
    context, found = click.Context(main), {}
    for command in main.list_commands(context):
        parameters = main.get_command(context, command).params
        options = [option for option in parameters if isinstance(option, click.Option) and not option.is_flag]
        found[command] = tuple(option.opts[0].lstrip("-").replace("-", "_") for option in options
                               if isinstance(option.type, kinds) and not option.count)  # fmt: skip
    return {command: names for command, names in found.items() if names}


@cache
def _settings() -> tuple[str, ...]:
    """Return the numeric arguments of `warpvec.vectorize`: fields of FitConfig and of Goal."""
    from warpvec.config.fit_config import FitConfig
    from warpvec.vectorization.goal import Goal

    every = [*fields(FitConfig), *fields(Goal)]
    return tuple(each.name for each in every if str(each.type).split(" | ")[0] in ("int", "float"))


def limits_of(name: str) -> tuple[float, ...]:
    """Return the finite ends of the range of a setting."""
    from warpvec.config import renderers, rules

    ends = {**rules.NUMBER_RANGES, **rules.COUNT_RANGES, **renderers.COUNT_RANGES}.get(name, ())
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


def run_setup(setup: Setup, folder: Path) -> str:
    """Run one setup in this process, in ``folder``.

    Raises:
        Exception: what warpvec must not raise.
    """
    os.chdir(folder)
    _photo(folder / "photo.png")
    if setup.way == "python":
        return _run_python(setup)
    from torture_commands import invoked

    words = _words(setup, folder)
    return invoked(words, codes=(0, 2))


def _run_python(setup: Setup) -> str:
    import warpvec
    from warpvec.errors import InputError

    numbers = {name: _number(value) for name, value in SMALL.items()}
    try:
        result = warpvec.vectorize("photo.png", **{**numbers, **dict(setup.values)})
        result.svg()
    except InputError as error:
        if len(str(error).splitlines()) != 1 or len(str(error)) > 1000:
            raise AssertionError(f"a message of {len(str(error))} characters: {str(error)[:200]!r}") from error
        return REFUSED
    return OK


def _number(text: str) -> Any:
    return int(text) if text.isdecimal() else text


def _words(setup: Setup, folder: Path) -> list[str]:
    """Return the words of a command line."""
    given = dict(setup.values)
    base = {name: value for name, value in SMALL.items() if name not in given}
    if setup.command not in ("run", "refine", "batch"):
        base = {}
    files = {"run": ["photo.png", "out.svg"], "refine": ["photo.png", "out.svg", "--from", "in.svg"],
             "batch": ["photos", "out"]}.get(setup.command, [])  # fmt: skip
    (folder / "in.svg").write_text(_DRAWING)
    (folder / "photos").mkdir(exist_ok=True)
    if setup.way == "line":
        words = [f"--{name.replace('_', '-')}={value}" for name, value in given.items()]
    else:
        lines = [f"{name} = {value}" if _is_toml(value) else f"{name} = {json.dumps(value)}"
                 for name, value in given.items()]  # fmt: skip
        (folder / "settings.toml").write_text("\n".join(lines), encoding="utf-8")
        words = ["--config", "settings.toml"]
    return [setup.command, *files, *(f"--{name.replace('_', '-')}={value}" for name, value in base.items()), *words]


_DRAWING = (
    '<svg xmlns="http://www.w3.org/2000/svg" width="24" height="16"><path d="M1 1h9v9z"/><path d="M5 5h9v9z"/></svg>'
)


def _is_toml(text: str) -> bool:
    import tomllib

    try:
        return bool(tomllib.loads(f"a = {text}"))
    except (ValueError, RecursionError):
        return False


@cache
def _photo_bytes() -> bytes:
    from io import BytesIO

    import numpy as np
    from PIL import Image

    stream = BytesIO()
    Image.fromarray(np.random.default_rng(1).integers(0, 256, (16, 24, 3), dtype=np.uint8)).save(stream, "PNG")
    return stream.getvalue()


def _photo(path: Path) -> None:
    path.write_bytes(_photo_bytes())


def _pair(chance: random.Random) -> Setup:
    way = chance.choice(["line", "toml", "python"])
    command = "vectorize" if way == "python" else chance.choice(["run", "run", "refine"])
    names = _settings() if way != "line" else numeric_options()[command]
    picked = [name for name in chance.sample(names, 2) if name not in ("iterations",) or way == "line"] or ["seed"]
    values = (chance.choice(values_of(name) if way == "python" else texts_of(name)) for name in picked)
    return Setup(way, command, tuple(zip(picked, values, strict=True)))


def _short(value: Any) -> str:
    if isinstance(value, int) and abs(value) > 10**50:
        return f"an integer of {value.bit_length()} bits"
    shown = " ".join(repr(value).split())
    return shown if len(shown) <= 40 else f"{shown[:20]}...({len(shown)} characters)"


@dataclass(frozen=True)
class Ended:
    """The end of a process: an outcome of `torture_case`, one line about it, seconds and peak memory in bytes."""

    outcome: str
    detail: str
    seconds: float
    memory: int


def run_alone(setup: Setup) -> Ended:
    """Run a setup in a process that is forked from this one."""
    with tempfile.TemporaryDirectory(prefix="warpvec-options-") as folder:
        start = time.monotonic()
        answers, answer = os.pipe()
        if (child := os.fork()) == 0:
            os.close(answers)
            _serve(setup, Path(folder), answer)
        os.close(answer)
        killed = _wait_for(answers, start + setup.seconds, child)
        with open(answers, "rb") as stream:
            text = stream.read().decode(errors="replace")
        _, status, usage = os.wait4(child, 0)
        elapsed, memory = time.monotonic() - start, 1024 * usage.ru_maxrss
    outcome, _, detail = text.partition("\n")
    if killed:
        outcome, detail = "hang", ""
    elif os.waitstatus_to_exitcode(status) or not outcome:
        outcome, detail = "crash", f"exit code {os.waitstatus_to_exitcode(status)}"
    elif memory > MAX_MEMORY:
        outcome, detail = "memory", f"{memory >> 20} MB"
    return Ended(outcome, detail, elapsed, memory)


def _serve(setup: Setup, folder: Path, answer: int) -> None:
    """Run a setup in the forked process, and end that."""
    # Four times the limit: address space that is never touched does no harm.
    resource.setrlimit(resource.RLIMIT_AS, (2**35, 2**35))
    sink = os.open(os.devnull, os.O_RDWR)
    for number in (0, 1, 2):
        os.dup2(sink, number)
    try:
        text = run_setup(setup, folder)
    except BaseException as error:
        text = f"exception\n{type(error).__name__}: {' '.join(str(error).split())[:500]}"
    os.write(answer, text.encode(errors="replace")[:4000])
    os._exit(0)


def _wait_for(stream: int, end: float, child: int) -> bool:
    """Wait for an answer; kill the child and return True if there is none in time."""
    import select

    if select.select([stream], [], [], max(0.0, end - time.monotonic()))[0]:
        return False
    os.kill(child, signal.SIGKILL)
    return True


def run_all(cases: Iterator[Setup], on_fault: Callable[[Setup, Ended], None]) -> tuple[Counter[str], Ended, Ended]:
    """Run ``cases``; return the counts by outcome, and the slowest and the largest end."""
    counts: Counter[str] = Counter()
    slowest = largest = Ended(OK, "", 0.0, 0)
    for setup in cases:
        ended = run_alone(setup)
        counts[ended.outcome] += 1
        slowest = max(slowest, ended, key=lambda each: each.seconds)
        largest = max(largest, ended, key=lambda each: each.memory)
        if ended.outcome not in (OK, REFUSED):
            on_fault(setup, ended)
    return counts, slowest, largest


def prepare() -> None:
    """Import and compile what the forked processes share."""
    with tempfile.TemporaryDirectory() as folder:
        run_alone_first = [Setup("python", "vectorize", ()), Setup("line", "refine", ())]
        for setup in run_alone_first:
            here = os.getcwd()
            run_setup(setup, Path(folder))
            os.chdir(here)


def main() -> int:
    """Run what the command line asks for; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default="", help="options, with commas")
    parser.add_argument("--pairs", type=int, default=0)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    sys.set_int_max_str_digits(0)
    prepare()
    sys.set_int_max_str_digits(4300)
    found: list[str] = []

    def show(setup: Setup, ended: Ended) -> None:
        found.append(setup.name)
        print(f"{ended.outcome}: {setup.name}: {ended.detail} ({ended.seconds:.1f} s)", flush=True)

    only = frozenset(name for name in options.only.split(",") if name)
    cases = [*setups(only), *pairs(random.Random(options.seed), options.pairs)]
    counts, slowest, largest = run_all(iter(cases), show)
    shown = ", ".join(f"{count} {name}" for name, count in sorted(counts.items()))
    print(f"{counts.total()} cases: {shown}; slowest {slowest.seconds:.1f} s, largest {largest.memory >> 20} MB")
    return int(bool(found))


if __name__ == "__main__":
    sys.exit(main())
