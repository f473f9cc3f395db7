"""The display of a batch: a line for each photo, the table on a terminal, and the summary."""

from __future__ import annotations

import time
from dataclasses import replace
from io import StringIO

import pytest
from rich.console import Console

from warpvec.batch.console import Tally, describe, show_batch
from warpvec.batch.jobs import PhotoJob
from warpvec.batch.journal import Record

DONE = Record(
    input="[red]a.png", output="a.svg", curves=8, bytes=1234, psnr=27.254, seconds=1.25, attempts=2, settings={}
)
FAILED = Record(input="b.png", output="b.svg", error="no luck", settings={})


def test_a_record_in_a_line() -> None:
    assert describe(DONE) == "[red]a.png: 27.25 dB, 8 paths, 1,234 bytes, 1.2 s, 2 attempts"
    assert describe(FAILED) == "b.png: failed: no luck"
    lossy = replace(DONE, losses="not kept in .dxf: the blur of 1 soft path")
    assert describe(lossy).endswith(", 2 attempts; not kept in .dxf: the blur of 1 soft path")


def test_a_tally_in_a_line() -> None:
    tally = Tally(skipped=3, total=4, records=[DONE, FAILED])
    assert tally.summary().startswith("7 images: 1 done, 1 failed, 3 done before, 2 left, PSNR 27.25 dB on average; ")
    assert tally.pace().startswith("2 of 4, 1 failed, ")


def test_a_tally_counts_the_modes_of_new_files() -> None:
    records = [replace(DONE, mode=mode) for mode in ("flat", "photo", "photo", None)]
    tally = Tally(skipped=0, total=5, records=[*records, replace(FAILED, mode="mono")])
    assert "5 images: 4 done (2 as photos, 1 as flat art), 1 failed, PSNR" in tally.summary()
    assert tally.facts()["modes"] == {"photo": 2, "flat": 1}


def test_photos_that_were_not_tried_do_not_count_for_the_time_left() -> None:
    refused = replace(FAILED, attempts=0)
    tally = Tally(skipped=0, total=5, started=time.monotonic() - 60.0, records=[refused, refused])
    assert tally.pace() == "2 of 5, 2 failed"
    tally.records.append(DONE)
    assert tally.pace() == "3 of 5, 2 failed, 1.0 a minute, 120 s left"


def test_the_time_left_follows_the_efforts_and_does_not_jump() -> None:
    efforts = {"large.png": 6.0, **{f"{k}.png": 1.0 for k in range(6)}}
    tally = Tally(skipped=0, total=7, started=time.monotonic() - 600.0, efforts=efforts)
    tally.records.append(replace(DONE, input="large.png"))
    assert tally.share() == pytest.approx(0.5)
    assert tally.pace() == "1 of 7, 0.1 a minute, 10 min left"
    tally.started -= 600.0  # a photo that took much longer than expected
    tally.records.append(replace(DONE, input="0.png"))
    assert tally.pace() == "2 of 7, 0.1 a minute, 12 min left"  # half of the way from 10 to 14 min


def test_the_table_shows_the_photo_of_each_worker() -> None:
    class Terminal(StringIO):
        def isatty(self) -> bool:
            return True

    stream = Terminal()
    tally = Tally(skipped=0, total=3)
    with show_batch(stream, tally) as view:
        for name in ("[red]a.png", "c.png"):
            view.update(PhotoJob(name, ""), f"iteration 1 of 9 of {name}")
        tally.records.append(DONE)
        view.show(DONE, tally)
        console = Console(file=StringIO(), width=100)
        console.print(view)
        table = console.file.getvalue()  # type: ignore[attr-defined]
    assert "[red]a.png: 27.25 dB, 8 paths" in stream.getvalue()
    assert "c.png" in table
    assert "iteration 1 of 9 of c.png" in table
    assert "a.png" not in table
    assert "1 of 3, " in table


def test_a_quiet_batch_shows_failures_alone() -> None:
    stream = StringIO()
    tally = Tally(skipped=0, total=2)
    failed = replace(DONE, input="b.png", error="no image", attempts=1)
    with show_batch(stream, tally, quiet=True) as view:
        for record in (DONE, failed):
            view.show(record, tally)
    assert stream.getvalue() == "warpvec: b.png: failed: no image\n"


def test_one_curve_is_one() -> None:
    assert "27.25 dB, 1 path, 1,234 bytes" in describe(replace(DONE, curves=1))


def test_a_closed_stream_shows_nothing() -> None:
    tally = Tally(skipped=0, total=1)
    with show_batch(None, tally) as view:
        view.show(DONE, tally)


HOSTILE = "a\nb\r\x1b[31m\u2028\u202e\x9bé.png"


def test_a_hostile_name_stays_in_its_line() -> None:
    record, stream = replace(FAILED, input=HOSTILE, error=f"cannot read {HOSTILE}"), StringIO()
    tally = Tally(skipped=0, total=3)
    with show_batch(stream, tally) as view:
        view.show(record, tally)
        view.update(PhotoJob(HOSTILE, "a.svg"), f"tried again: {HOSTILE}")
        view.show(replace(DONE, input=HOSTILE), tally)
    lines = stream.getvalue().splitlines()
    assert len(lines) == 3
    assert all(line.isprintable() and r"a\nb\r\x1b[31m\u2028\u202e\x9bé.png" in line for line in lines)
