"""Send signals to the server of the page at random moments of its requests, and check that each one ends it.

    python bench/app_signals.py --runs 200 --seed 1

Each run starts ``warpvec app``, adds a picture, and then asks from four clients at once, without end: the page, its
events, fits, changes of shapes, and files to save. SIGINT, SIGTERM or SIGHUP comes at a random moment. The server must
end with 128 plus the number of the signal within `END_SECONDS`, and leave no process, no temporary file and no half
file in its folder. One line a run that does not, and one line at the end.
"""

from __future__ import annotations

import argparse
import http.client
import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from random import Random
from urllib.request import Request, urlopen

import numpy as np
from PIL import Image

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "support"))

from children import take_default_signals

END_SECONDS = 60.0
"""Longest time to end, on a busy machine: requests have three seconds to be answered."""

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)

DRAWING = (
    b'<svg xmlns="http://www.w3.org/2000/svg" width="64" height="64">'
    + b"".join(b'<path d="M%d %dh9v9h-9z" fill="#c31"/>' % (x, y) for x in range(0, 60, 10) for y in range(0, 60, 10))
    + b"</svg>"
)

SHAPE = '<svg xmlns="http://www.w3.org/2000/svg" width="9" height="9"><path d="M1 1h6v6h-6z"/></svg>'


def run(folder: Path, number: signal.Signals, chance: Random) -> str:
    """Start a server, send it a signal, and return what is wrong afterwards; nothing if all is right."""
    for name in ("home", "temporary", "pictures"):
        (folder / name).mkdir()
    picture = folder / "pictures" / "a.png"
    Image.fromarray(np.random.default_rng(chance.randrange(99)).integers(0, 256, (48, 48, 3), np.uint8)).save(picture)
    temporary = str(folder / "temporary")
    environment = {**os.environ, "TMPDIR": temporary, "XDG_RUNTIME_DIR": str(folder / "home")}
    command = [sys.executable, "-m", "warpvec", "app", "--no-browser", "--threads", "1", str(picture.parent)]
    process = subprocess.Popen(
        command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, env=environment, start_new_session=True
    )
    assert process.stderr is not None
    found = re.search(r"http://127\.0\.0\.1:\d+/[\w-]{32}/", process.stderr.readline())
    if found is None:
        process.kill()
        return "no address"
    over = threading.Event()
    clients = [threading.Thread(target=task, args=(found[0], picture, over), daemon=True) for task in TASKS]
    for client in clients:
        client.start()
    try:
        time.sleep(chance.random() ** 2 * 12.0)  # many in the first seconds, when workers and modules are loaded
        process.send_signal(number)
        begun = time.monotonic()
        code = process.wait(END_SECONDS)
        seconds = time.monotonic() - begun
    except subprocess.TimeoutExpired:
        return f"did not end in {END_SECONDS:.0f} s"
    finally:
        over.set()
        left = _ended_group(process)
    SECONDS.append(seconds)
    rest = [path.name for path in (folder / "temporary").iterdir() if not path.name.startswith("warp")]
    half = [
        path.name
        for path in picture.parent.iterdir()
        if path != picture and not path.read_bytes().rstrip().endswith(b"</svg>")
    ]
    faults = {
        f"exit code {code}": code != 128 + number, f"{left} processes left": left > 0, f"left {rest}": bool(rest),
        f"half files {half}": bool(half), f"said {(said := process.stderr.read())[-300:]!r}": bool(said.strip("\n")),
    }  # fmt: skip
    return "; ".join(fault for fault, is_there in faults.items() if is_there and fault not in _HARMLESS)


SECONDS: list[float] = []
"""The seconds that each server took to end."""

_HARMLESS = ("said 'Ctrl-C ends it.\\n'",)


def _ended_group(process: subprocess.Popen[str]) -> int:
    """Kill what is left of the session of a server, and return how many processes that were."""
    count = 0
    for _ in range(20):  # a worker that ends now takes a moment
        count = sum(_session_of(path) == process.pid for path in Path("/proc").glob("[0-9]*/stat"))
        if count == 0:
            return 0
        time.sleep(0.25)
    with suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)
    return count


def _session_of(path: Path) -> int:
    with suppress(OSError):
        fields = path.read_text().rpartition(")")[2].split()
        return int(fields[3]) if fields[0] != "Z" else 0
    return 0


# What clients ask for


def _ask(url: str, body: bytes | None = None) -> bytes:
    with urlopen(Request(url, body), timeout=20) as answer:
        return bytes(answer.read())


def _again(request: Callable[[str, Path], object]) -> Callable[[str, Path, threading.Event], None]:
    def task(root: str, picture: Path, over: threading.Event) -> None:
        while not over.is_set():
            with suppress(OSError, http.client.HTTPException, ValueError):
                request(root, picture)
            time.sleep(0.02)

    return task


def _look(root: str, picture: Path) -> None:
    for path in ("", "folder", "folder/a.png"):
        _ask(root + path)


def _listen(root: str, picture: Path) -> None:
    with urlopen(root + "events?page=a", timeout=20) as answer:
        while answer.read1(4096):
            pass


def _fit(root: str, picture: Path) -> None:
    made = json.loads(_ask(root + "pictures?page=a&name=a.png", picture.read_bytes()))
    place = f"{root}pictures/{made['id']}"
    _ask(place + "/fit", json.dumps({"settings": {"mode": "photo", "curves": 16}}).encode())
    _ask(place + "/preview")
    time.sleep(0.2)
    _ask(place + "/stop", b"")


def _save(root: str, picture: Path) -> None:
    for query in ("format=svg&to=folder&name=b", "format=png&width=900", "format=svgz"):
        _ask(root + "export?" + query, DRAWING)
    _ask(root + "reshape?to=outline", json.dumps({"shapes": [SHAPE]}).encode())


TASKS = [_again(request) for request in (_look, _listen, _fit, _save)]


def main() -> None:
    """Run the servers."""
    parser = argparse.ArgumentParser(description="Send signals to the server of the page.")
    parser.add_argument("--runs", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    take_default_signals()  # a background job of a script ignores SIGINT, and so would its servers
    chance, faults, count = Random(asked.seed), 0, Counter[str]()
    for index in range(asked.runs):
        number = chance.choice(SIGNALS)
        with tempfile.TemporaryDirectory() as folder:
            fault = run(Path(folder), number, chance)
        count[number.name] += 1
        if fault:
            faults += 1
            print(f"run {index}, {number.name}: {fault}", flush=True)
        if index % 10 == 9:
            print(f"{index + 1} of {asked.runs} runs, {faults} faults", file=sys.stderr, flush=True)
    longest = max(SECONDS, default=0.0)
    print(f"{asked.runs} runs, seed {asked.seed}, {dict(count)}: {faults} faults, the slowest ended in {longest:.1f} s")


if __name__ == "__main__":
    main()
