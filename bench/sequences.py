"""Do what a user may do on the page of `warpvec app` in any order, with its real worker, and look that nothing is lost.

Each sequence is of steps of `tests/support/desk_sequences.py`: settings, fits, edits, Undo and Redo, a reload, the x
beside the picture, saving, opening what was saved, a server that is killed and started again. After each step all edits
must be there, the figures right and a saved file what the page shows; in the end all are undone.

    python bench/sequences.py --length 8 --count 300
    python bench/sequences.py --length 2 --count 121
"""

from __future__ import annotations

import itertools
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import click
import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "support"))

from browser import CHROMIUM
from children import take_default_signals
from desk_browser import DeskServer
from desk_sequences import STEPS, Sequences


def sequence(length: int, number: int) -> tuple[str, ...]:
    """Return the sequence of this ``number``: all of two steps after an edit come in turn, others are random."""
    if length == 2:
        return ("edit", *list(itertools.product(STEPS, repeat=2))[number])
    return tuple(np.random.default_rng([length, number]).choice(STEPS, length).tolist())


@contextmanager
def opened(folder: Path) -> Iterator[Sequences]:
    """Open the page of a new server in a browser of its own."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as driver:
        browser, server = driver.chromium.launch(executable_path=CHROMIUM), DeskServer(folder)
        try:
            yield Sequences(browser, server, folder)
        finally:
            server.end()
            browser.close()


def fault_of(sequences: Sequences, steps: tuple[str, ...]) -> str | None:
    """Return what went wrong, in a line; None if nothing did."""
    try:
        sequences.check(steps)
    except Exception as error:  # Playwright's, when it waits in vain, or of an assertion
        return " ".join(str(error).split())[:600] or type(error).__name__
    complaints = sequences.complaints()
    return f"console: {complaints}" if complaints else None


def tried(length: int, numbers: range) -> Iterator[tuple[int, Any]]:
    """Yield each number with the fault of its sequence. After a fault the server and the browser are new."""
    left = iter(numbers)
    while True:
        with tempfile.TemporaryDirectory() as folder, opened(Path(folder)) as sequences:
            for number in left:
                fault = fault_of(sequences, sequence(length, number))
                yield number, fault
                if fault is not None:
                    break
            else:
                return


@click.command()
@click.option("--length", default=8, help="Steps of a sequence; with 2 all are tried, after an edit.")
@click.option("--first", default=0, help="Number of the first sequence.")
@click.option("--count", default=300, help="Number of sequences.")
def main(length: int, first: int, count: int) -> None:
    """Try sequences of steps on the page."""
    take_default_signals()
    faults, begin, last = 0, time.monotonic(), first
    for last, fault in tried(length, range(first, first + count)):
        faults += fault is not None
        words = "right" if fault is None else fault
        click.echo(f"{last} {' '.join(sequence(length, last))}: {words} ({time.monotonic() - begin:.0f} s)")
    click.echo(f"{last - first + 1} sequences of {length} steps, {faults} with a fault")


if __name__ == "__main__":
    main()
