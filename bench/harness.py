"""Shared parts of all benchmarks: timing by laps, settings from text, facts of the machine, tables.

It imports neither torch nor Warp at the top, because a process that measures the memory of another must be small.
"""

from __future__ import annotations

import hashlib
import os
import platform
import statistics
import subprocess
import tempfile
import time
from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, fields
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import click

import warpvec
from warpvec.config.fit_config import FitConfig

T = TypeVar("T")

_PACKAGE = Path(warpvec.__file__).parent
CHECKOUT = _PACKAGE.parent
"""Folder of the measured copy of warpvec."""


# Time


class Span(NamedTuple):
    """Wall seconds, and CPU seconds of all threads of the process."""

    wall: float
    cpu: float

    def plus(self, other: Span) -> Span:
        """Return the sum of both."""
        return Span(self.wall + other.wall, self.cpu + other.cpu)

    def minus(self, other: Span) -> Span:
        """Return the difference of both."""
        return Span(self.wall - other.wall, self.cpu - other.cpu)


ZERO = Span(0.0, 0.0)


class Laps:
    """Stopwatch for the named parts of a repeated action; times of a part that runs twice within a lap are added."""

    def __init__(self, device: str = "cpu") -> None:
        self._synchronize = _synchronizer(device)
        self._laps: list[dict[str, Span]] = []

    def start(self) -> None:
        """Begin the next lap."""
        self._laps.append(defaultdict(lambda: ZERO))

    def time(self, name: str, action: Callable[[], T]) -> T:
        """Run ``action`` and add its time to the part ``name`` of this lap."""
        self._synchronize()
        wall, cpu = time.perf_counter(), time.process_time()
        result = action()
        self._synchronize()
        lap = self._laps[-1]
        lap[name] = lap[name].plus(Span(time.perf_counter() - wall, time.process_time() - cpu))
        return result

    def remainder(self, name: str, whole: str, parts: Iterable[str]) -> None:
        """Subtract ``parts`` from ``whole`` in every lap; the rest becomes the part ``name``."""
        for lap in self._laps:
            rest = lap[whole]
            for part in parts:
                rest = rest.minus(lap.get(part, ZERO))
            lap[name] = rest

    def statistics(self) -> dict[str, Statistics]:
        """Return the statistics of each part, in the order in which the parts first ended."""
        names = dict.fromkeys(name for lap in self._laps for name in lap)
        return {name: summarize([lap.get(name, ZERO) for lap in self._laps]) for name in names}


@dataclass(frozen=True)
class Statistics:
    """Statistics of the seconds of repeated runs; ``spread`` is the distance between the quartiles."""

    median: float
    minimum: float
    spread: float
    cpu_median: float
    count: int

    def milliseconds(self) -> dict[str, float]:
        """Return every time in ms, for JSON."""
        named = {"median": self.median, "min": self.minimum, "spread": self.spread, "cpu_median": self.cpu_median}
        return {name: round(1e3 * seconds, 4) for name, seconds in named.items()}


def summarize(spans: Sequence[Span]) -> Statistics:
    """Summarize at least one span. The median is used because other processes sometimes add a lot of time."""
    wall = sorted(span.wall for span in spans)
    lower, _, upper = statistics.quantiles(wall, n=4, method="inclusive") if len(wall) > 1 else (0.0, 0.0, 0.0)
    cpu = statistics.median(span.cpu for span in spans)
    return Statistics(statistics.median(wall), wall[0], upper - lower, cpu, len(wall))


def _synchronizer(device: str) -> Callable[[], object]:
    """Return a function that waits for the device, because launches on CUDA return before the work is done."""
    if device == "cpu":
        return lambda: None
    import warp as wp

    return lambda: wp.synchronize_device(device)


# Settings


def parse_settings(assignments: Iterable[str]) -> dict[str, Any]:
    """Parse texts such as ``curves=7`` into fields of FitConfig with values of the right type."""
    kinds = {field.name: str(field.type) for field in fields(FitConfig)}
    settings = {}
    for assignment in assignments:
        name, _, value = assignment.partition("=")
        if name not in kinds:
            raise click.BadParameter(f"--set must name a field of warpvec.FitConfig, got {assignment!r}")
        settings[name] = _parse_value(assignment, value, kinds[name].removesuffix(" | None"))
    return settings


def _parse_value(assignment: str, value: str, kind: str) -> Any:
    parsers: dict[str, Callable[[str], Any]] = {
        "int": int, "float": float, "bool": _parse_bool, "float | str": _parse_number_or_word,
    }  # fmt: skip
    try:
        return parsers.get(kind, str)(value)
    except ValueError:
        raise click.BadParameter(f"--set must give a value of type {kind}, got {assignment!r}") from None


def _parse_number_or_word(value: str) -> float | str:
    try:
        return float(value)
    except ValueError:
        return value


def _parse_bool(value: str) -> bool:
    words = {"true": True, "1": True, "false": False, "0": False}
    if value.lower() not in words:
        raise ValueError(value)
    return words[value.lower()]


def comma_separated(ctx: click.Context, param: click.Parameter, value: str) -> list[str]:
    """Parse an option whose value is a list such as draft,default."""
    del ctx, param
    return value.split(",")


def comma_separated_counts(ctx: click.Context, param: click.Parameter, value: str) -> list[int]:
    """Parse an option whose value is a list of whole numbers such as 256,512,1024."""
    items = comma_separated(ctx, param, value)
    if not all(item.isdecimal() and int(item) > 0 for item in items):
        raise click.BadParameter(f"must be whole numbers of at least 1, as in 1,2 without spaces, got {value!r}")
    return [int(item) for item in items]


settings_option = click.option(
    "--set", "assignments", metavar="NAME=VALUE", multiple=True, help="Set a field of warpvec.FitConfig; repeatable."
)


# The machine


def machine_facts(device: str = "cpu") -> dict[str, Any]:
    """Return the facts that belong to every measured number: machine, load before the run, versions, commit."""
    packages = ("torch", "warp-lang", "numpy", "resvg_py")
    return {
        "cpu": _cpu_name(),
        "cores": os.cpu_count(),
        "load": round(os.getloadavg()[0], 2) if hasattr(os, "getloadavg") else None,
        "device": _device_name(device),
        "system": f"{platform.system()} {platform.machine()}",
        "python": platform.python_version(),
        "warpvec": warpvec.__version__,
        **{package: _version(package) for package in packages},
        "commit": _commit(),
        "source": source_digest(),
    }


def _version(package: str) -> str | None:
    """Return the version of an installed package, or None for one that was unpacked without its metadata."""
    try:
        return version(package)
    except PackageNotFoundError:
        return None


@cache
def source_digest() -> str:
    """Return a digest of the sources of warpvec, kernels included; it also tells uncommitted changes apart."""
    return _digest_of(_PACKAGE)


def _digest_of(package: Path) -> str:
    # In a checkout, kernels/ is a symbolic link, which rglob does not follow.
    paths = {*package.rglob("*.py"), *(package / "kernels").glob("*.py")}
    digest = hashlib.sha256()
    for path in sorted(paths):
        digest.update(path.relative_to(package).as_posix().encode() + path.read_bytes())
    return digest.hexdigest()[:12]


def _cpu_name() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        lines = []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()


def _device_name(device: str) -> str:
    if not device.startswith("cuda"):
        return device
    import torch

    return f"{device} {torch.cuda.get_device_name(device)}"


def _commit() -> str | None:
    """Return the commit of the checkout, with "-dirty" if tracked files differ from it; None outside a checkout."""
    command = ["git", "-C", str(CHECKOUT), "describe", "--always", "--dirty", "--exclude=*"]
    try:
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return None


def default_cache() -> Path:
    """Return a folder outside of the checkout for results that are costly to make again."""
    return Path(tempfile.gettempdir()) / "warpvec-bench"


# Text


def markdown_table(header: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """Return a Markdown table: the first column is aligned left, the others, which hold numbers, right."""
    lines = [header, ["---", *["---:"] * (len(header) - 1)], *rows]
    return "\n".join("| " + " | ".join(str(cell) for cell in line) + " |" for line in lines)


def machine_line(facts: dict[str, Any]) -> str:
    """Return the facts of the machine as a line of text under a table."""
    return ", ".join(f"{name} {value}" for name, value in facts.items() if value is not None)
