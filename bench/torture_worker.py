"""Run cases in this process, one after another, as `torture_runner.Worker` asks for them.

A line of JSON on stdin names a case: kind, seed and number. The answer is two lines of JSON on stdout: name and time
limit before the case runs, and its outcome afterwards. The input of the case is first written to "input" in the folder
of the worker, so that a crash does not lose it.
"""

from __future__ import annotations

import argparse
import faulthandler
import importlib
import json
import os
import random
import resource
import shutil
import sys
import time
import traceback
import warnings
from pathlib import Path
from typing import Any, TextIO

from torture_case import MAX_MEMORY, OK, REFUSED, Case, Wrong

ADDRESS_SPACE = 2**34
"""Address space of a worker in bytes, so that a fault cannot take the memory of the machine from the other worker."""

MAX_MESSAGE = 500
"""Longest message of an `InputError`; it is read as one line."""


def case_of(kind: str, seed: int, number: int) -> Case:
    """Return a case by its name; the same on every machine."""
    if kind == "corpus":
        return importlib.import_module("torture_corpus").case_at(number)
    module = importlib.import_module(f"torture_{kind}")
    sys.set_int_max_str_digits(0)  # the cases have numbers of any length, but warpvec meets them with the limit
    case: Case = module.case(random.Random(f"{kind} {seed} {number}"))
    sys.set_int_max_str_digits(sys.int_info.default_max_str_digits)
    return case


def main() -> None:
    """Answer the lines on stdin until it ends."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    folder = parser.parse_args().folder.resolve()
    requests, answers = _take_streams()
    _prepare(folder)
    for line in requests:
        wanted = json.loads(line)
        case = case_of(wanted["kind"], wanted["seed"], wanted["number"])
        (folder / "input").write_bytes(case.data)
        _send(answers, {"name": case.name, "seconds": case.seconds})
        _send(answers, outcome_of(case, folder))


def outcome_of(case: Case, folder: Path) -> dict[str, Any]:
    """Run ``case`` in an empty folder inside ``folder``; return outcome, detail, seconds and peak memory in bytes."""
    place, temporary = folder / "case", folder / "tmp"
    for path in (place, temporary):
        shutil.rmtree(path, ignore_errors=True)
        path.mkdir(parents=True)
    os.chdir(place)
    _forget_peak()
    start = time.monotonic()
    outcome, detail = _result(case, place)
    seconds = time.monotonic() - start
    left = os.listdir(temporary) + [str(path) for path in place.rglob(".warpvec-*")]
    if left and outcome in (OK, REFUSED):
        outcome, detail = "wrong", f"left behind: {left[:3]}"
    peak = max(_peak(), resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss << 10)
    if peak > MAX_MEMORY:
        outcome, detail = "memory", f"{peak >> 20} MB"
    os.chdir(folder)
    _remove(place)
    return {"outcome": outcome, "detail": detail, "seconds": seconds, "peak": peak}


def _result(case: Case, place: Path) -> tuple[str, str]:
    from warpvec.errors import InputError

    try:
        outcome = case.run(place)
        return (outcome, "") if outcome in (OK, REFUSED) else ("wrong", f"the case returned {outcome!r}")
    except InputError as error:
        message = str(error)
        if "\n" in message or len(message) > MAX_MESSAGE:
            return "wrong", f"a message of {len(message)} characters: {message!r}"[:MAX_MESSAGE]
        return REFUSED, ""
    except Wrong as error:
        return "wrong", str(error)
    except BaseException as error:  # SystemExit and Rust's PanicException among them
        return "exception", f"{type(error).__name__}: {error} ({_place(error)})"[:MAX_MESSAGE]


def _place(error: BaseException) -> str:
    """Return file and line of the code of warpvec that the error left last, or else of any code."""
    places = [(Path(frame.filename), frame.lineno) for frame in traceback.extract_tb(error.__traceback__)]
    own = [place for place in places if "warpvec" in place[0].parts] or places or [(Path("?"), 0)]
    path, line = own[-1]
    return f"{path.parent.name}/{path.name}:{line}"


def _take_streams() -> tuple[TextIO, TextIO]:
    """Return stdin and stdout, and put the null device in their place: native code must not write into the answers."""
    requests, answers = os.fdopen(os.dup(0), "r"), os.fdopen(os.dup(1), "w")
    null = os.open(os.devnull, os.O_RDWR)
    os.dup2(null, 0)
    os.dup2(null, 1)
    return requests, answers


def _prepare(folder: Path) -> None:
    os.environ["TMPDIR"] = str(folder / "tmp")
    (folder / "tmp").mkdir(parents=True, exist_ok=True)
    faulthandler.enable()
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_AS, (ADDRESS_SPACE, ADDRESS_SPACE))
    # Writing with no reader must be an error and not the end; huge files must not fill the disk.
    resource.setrlimit(resource.RLIMIT_FSIZE, (2**31, 2**31))
    warnings.simplefilter("error")


def _send(answers: TextIO, message: dict[str, Any]) -> None:
    answers.write(json.dumps(message) + "\n")
    answers.flush()


def _forget_peak() -> None:
    Path("/proc/self/clear_refs").write_text("5")


def _peak() -> int:
    (line,) = (line for line in Path("/proc/self/status").read_text().splitlines() if line.startswith("VmHWM"))
    return int(line.split()[1]) << 10


def _remove(place: Path) -> None:
    """Remove a folder, also one in which the case has made folders that cannot be entered."""
    for root, folders, _ in os.walk(place):
        for name in folders:
            path = os.path.join(root, name)
            if not os.path.islink(path):
                os.chmod(path, 0o700)
    shutil.rmtree(place, ignore_errors=True)


if __name__ == "__main__":
    sys.exit(main())
