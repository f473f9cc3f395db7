"""Feed warpvec hostile input and events for a while, and count what it does.

    python bench/torture.py --minutes 60 --seed 1 --workers 2
    python bench/torture.py --kinds images,svgs --cases images=1000,svgs=200
    python bench/torture.py --replay build/torture/svgs-1-57.json

Allowed are a result and an `InputError` of one line (exit code 2). Faults are another exception, a crash, more than
20 s, more than 2 GB in one process, and a broken rule, such as a file left over. Every fault is written to --folder
with all that is needed to run it again, and its input. The exit code is 1 if there were any.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path

import torture_corpus
from torture_case import FAULTS
from torture_runner import POLL_SECONDS, Ended, Running, run_all, table

SHARES = {
    "corpus": 1.0, "images": 0.15, "svgs": 0.25, "checkpoints": 0.15, "toml": 0.05, "commands": 0.1, "options": 0.1,
    "batch": 0.07, "disks": 0.06, "kills": 0.07,
}  # fmt: skip
"""Kind -> its share of the time: the larger, the more there is to find. A kind is the module `torture_<kind>`.

The corpus, which comes first, ends after each of its cases has run once.
"""


def main() -> int:
    """Run what the command line asks for; return the exit code."""
    options = _options()
    warm_up()
    if options.replay is not None:
        return _replay(options.replay, options.folder, options.patience)
    shares = {kind: SHARES[kind] for kind in options.kinds.split(",")}
    limits = {kind: int(count) for kind, _, count in (part.partition("=") for part in options.cases.split(",") if part)}
    limits.setdefault("corpus", len(torture_corpus.entries()))
    start, seconds = time.monotonic(), 60 * options.minutes
    tallies, faults = run_all(
        shares, options.seed, limits, options.folder, options.workers, seconds, options.patience, show
    )
    print(table(tallies))
    print(f"{time.monotonic() - start:.0f} s, seed {options.seed}, {options.workers} workers")
    return int(bool(faults))


def warm_up() -> None:
    """Load torch and the kernels of usual fits, which the processes of all cases then have."""
    import numpy as np
    import torch

    import warpvec
    from warpvec.modes.precompile import compile_kernels

    torch.set_num_threads(1)
    photo = np.random.default_rng(0).integers(0, 256, (16, 24, 3), dtype=np.uint8)
    compile_kernels("cpu")
    text = warpvec.vectorize(photo, 8, iterations=3, threads=1).svg()
    warpvec.refine(photo, text, iterations=3, threads=1)


def show(fault: Ended) -> None:
    """Print a fault in a line."""
    print(f"{fault.outcome}: {fault.kind} {fault.seed} {fault.number} ({fault.name}): {fault.detail}", flush=True)


def _replay(path: Path, folder: Path, patience: float) -> int:
    wanted = json.loads(path.read_text())
    folder.mkdir(parents=True, exist_ok=True)
    running = Running(wanted["kind"], wanted["seed"], wanted["number"], folder, patience)
    while not running.has_ended():
        time.sleep(POLL_SECONDS)
    ended = running.finish()
    show(ended)
    print(ended.stderr)
    return int(ended.outcome in FAULTS)


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=60.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--kinds", default=",".join(SHARES), help="kinds with commas between them")
    parser.add_argument("--cases", default="", help="most cases of each kind: images=1000,svgs=200")
    parser.add_argument("--patience", type=float, default=1.0, help="factor of all time limits, on a busy machine")
    parser.add_argument("--folder", type=Path, default=Path("build/torture"), help="receives the faults")
    parser.add_argument("--replay", type=Path, metavar="FILE", help="run the case of a fault again")
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
