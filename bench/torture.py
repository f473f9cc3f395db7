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
from collections import Counter
from dataclasses import asdict
from pathlib import Path

import torture_corpus
from torture_case import FAULTS, OK, REFUSED
from torture_runner import Fault, Torture, Worker

SHARES = {
    "corpus": 1.0,
    "images": 0.15,
    "svgs": 0.25,
    "checkpoints": 0.15,
    "toml": 0.05,
    "commands": 0.1,
    "options": 0.1,
    "batch": 0.07,
    "disks": 0.06,
    "kills": 0.07,
}
"""Kind -> its share of the time: the larger, the more there is to find. A kind is the module `torture_<kind>`.

The corpus, which comes first, ends after each of its cases has run once.
"""


def main() -> int:
    """Run what the command line asks for; return the exit code."""
    options = _options()
    if options.replay is not None:
        return _replay(options.replay, options.folder, options.patience)
    shares = {kind: SHARES[kind] for kind in options.kinds.split(",")}
    limits = {kind: int(count) for kind, _, count in (part.partition("=") for part in options.cases.split(",") if part)}
    limits.setdefault("corpus", len(torture_corpus.entries()))
    torture = Torture(shares, options.seed, options.folder, _show, options.patience)
    start = time.monotonic()
    torture.run(options.workers, 60 * options.minutes, limits)
    seconds = time.monotonic() - start
    print(table(torture))
    print(f"{seconds:.0f} s, seed {options.seed}, {options.workers} workers")
    if options.json is not None:
        options.json.write_text(json.dumps(_facts(torture, seconds), indent=1))
    return int(bool(torture.faults))


def table(torture: Torture) -> str:
    """Return the counts by kind as a table in Markdown."""
    names = [OK, REFUSED, *FAULTS]
    lines = [f"| kind | cases | {' | '.join(names)} | slowest | peak |", "|---" * (len(names) + 4) + "|"]
    total: Counter[str] = Counter()
    for kind, tally in torture.tallies.items():
        total += tally.outcomes
        counts = " | ".join(f"{tally.outcomes[name]:,}" for name in names)
        lines.append(
            f"| {kind} | {tally.outcomes.total():,} | {counts} | {tally.slowest:.1f} s | {tally.peak >> 20:,} MB |"
        )
    counts = " | ".join(f"{total[name]:,}" for name in names)
    slowest = max(tally.slowest for tally in torture.tallies.values())
    peak = max(tally.peak for tally in torture.tallies.values()) >> 20
    return "\n".join([*lines, f"| all | {total.total():,} | {counts} | {slowest:.1f} s | {peak:,} MB |"])


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=60.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--kinds", default=",".join(SHARES), help="kinds with commas between them")
    parser.add_argument("--cases", default="", help="most cases of each kind: images=1000,svgs=200")
    parser.add_argument("--patience", type=float, default=1.0, help="factor of all time limits, on a busy machine")
    parser.add_argument("--folder", type=Path, default=Path("build/torture"), help="receives the faults")
    parser.add_argument("--json", type=Path, help="file for the counts and the faults")
    parser.add_argument("--replay", type=Path, metavar="FILE", help="run the case of a fault again")
    return parser.parse_args()


def _replay(path: Path, folder: Path, patience: float) -> int:
    wanted = json.loads(path.read_text())
    worker = Worker(folder / "replay", patience)
    try:
        answer = worker.run(wanted["kind"], wanted["seed"], wanted["number"])
    finally:
        worker.stop()
    print(json.dumps({key: value for key, value in answer.items() if key != "stderr"}, indent=1))
    print(answer["stderr"])
    return int(answer["outcome"] in FAULTS)


def _show(fault: Fault) -> None:
    print(f"{fault.outcome}: {fault.kind} {fault.seed} {fault.number} ({fault.name}): {fault.detail}", flush=True)


def _facts(torture: Torture, seconds: float) -> dict[str, object]:
    tallies = {kind: {**asdict(tally), "outcomes": dict(tally.outcomes)} for kind, tally in torture.tallies.items()}
    return {"seconds": seconds, "kinds": tallies, "faults": [asdict(fault) for fault in torture.faults]}


if __name__ == "__main__":
    sys.exit(main())
