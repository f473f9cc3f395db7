"""Processes of tests get default signals and are not left over, and a test that hangs fails."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import hangs
import pytest
from children import kill_all, limit, runs, start, wait_for

SUPPORT = str(Path(__file__).parent)

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such signals")


def test_signals_that_a_background_job_ignores_end_what_tests_start() -> None:
    sleep = [sys.executable, "-c", "import time; print('ready', flush=True); time.sleep(60)"]
    code = f"""import sys, signal; sys.path.append({SUPPORT!r})
from children import start, take_default_signals
take_default_signals()
for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
    process = start({sleep!r}, stdout=-1, stderr=-3)
    process.stdout.readline()
    process.send_signal(number)
    assert process.wait({limit()}) == -number
"""

    def ignore() -> None:
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            signal.signal(number, signal.SIG_IGN)

    subprocess.run([sys.executable, "-c", code], preexec_fn=ignore, check=True)


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux ends a process with the one that started it")
def test_what_a_killed_suite_has_started_ends_with_it() -> None:
    code = f"""import sys, time; sys.path.append({SUPPORT!r})
from children import start
print(start(["sleep", "60"]).pid, flush=True)
time.sleep(60)
"""
    suite = start([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert suite.stdout is not None
    number = int(suite.stdout.readline())
    assert runs(number)
    kill_all()
    wait_for(lambda: not runs(number))


def test_a_test_that_waits_too_long_fails_where_it_waits(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(hangs, "limit", lambda seconds: seconds)
    monkeypatch.setattr(hangs, "PERIOD", 0.1)
    with pytest.raises(hangs.HangError, match="its children worked"), hangs.no_hang(0.2):
        time.sleep(60)


def test_time_in_which_a_test_works_is_no_hang(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(hangs, "_work", hangs.monotonic)  # a core of its own
    monkeypatch.setattr(hangs, "PERIOD", 0.1)
    end = time.monotonic() + 0.6
    with hangs.no_hang(0.2):
        while time.monotonic() < end:
            pass


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere the work of a running child is not known")
def test_the_work_of_a_running_grandchild_counts() -> None:
    busy = f"[{sys.executable!r}, '-c', 'while True: pass']"
    parent = start([sys.executable, "-c", f"import subprocess; subprocess.run({busy})"], start_new_session=True)
    try:
        before = hangs._work()
        wait_for(lambda: hangs._work() > before + 0.5)
    finally:
        os.killpg(parent.pid, signal.SIGKILL)
