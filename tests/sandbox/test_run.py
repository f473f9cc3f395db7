"""The child process for hostile input: its limits and errors. No child stays behind."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from children import limit, runs, start, wait_for
from svg_files import mask_bomb, svg_file

from warpvec.errors import InputError
from warpvec.sandbox import child, run
from warpvec.sandbox.run import SandboxError, run_in_sandbox

ENVIRONMENT = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}

TASK = {"work": "warpvec.svg.resvg_work", "options": {}, "memory": run.MAX_MEMORY, "files": 0}

WORK = """
import time

from warpvec.errors import InputError


def work(data, kind):
    if kind == "input":
        raise InputError("picture", "must be good", data.decode(), "draw it again")
    if kind == "memory":
        return [bytes(2**33)]
    if kind == "deep":
        return work(data, kind)
    if kind == "slow":
        return [b"a" for _ in [time.sleep(1.5)]]
    if kind == "file":
        return [open(data).read()]
    return [b"a", memoryview(data)]
"""


@pytest.fixture(name="work")
def work_fixture(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """Return the name of a module with the work above."""
    (tmp_path / "some_work.py").write_text(WORK)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    return "some_work"


def test_the_result_is_that_of_the_work(work: str) -> None:
    assert run_in_sandbox(work, bytes(10**6), kind="") == b"a" + bytes(10**6)


def test_an_input_error_of_the_work_is_raised_here(work: str) -> None:
    with pytest.raises(InputError, match=r"^picture must be good, got bad; draw it again$"):
        run_in_sandbox(work, b"bad", kind="input")


def test_work_that_waits_for_the_processor_has_time(work: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(run, "MAX_SECONDS", 1.0)
    assert run_in_sandbox(work, b"", kind="slow") == b"a"


@pytest.mark.parametrize(
    ("kind", "words"),
    [("memory", "more memory"), ("deep", "recursion"), ("file", "Too many open files"), ("other argument", "")],
)
def test_work_that_fails_or_opens_a_file_is_named(work: str, kind: str, words: str, tmp_path: Path) -> None:
    options = {"kind": kind} if words else {"kinds": kind}
    with pytest.raises(SandboxError, match=words or "unexpected keyword"):
        run_in_sandbox(work, os.fsencode(tmp_path / "some_work.py"), **options)


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux ends a process with the one that started it")
@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM, signal.SIGINT])
def test_the_child_process_ends_with_the_one_that_started_it(tmp_path, number):
    (tmp_path / "bomb.svg").write_text(mask_bomb())
    program = "from warpvec.svg.resvg import rasterize; rasterize(open('bomb.svg').read())"
    with start([sys.executable, "-c", program], cwd=tmp_path, env=ENVIRONMENT, stderr=subprocess.PIPE) as drawing:
        child = wait_for(lambda: busy_child(drawing.pid))
        drawing.send_signal(number)
        drawing.communicate(timeout=limit(20))
        wait_for(lambda: not runs(child))


def busy_child(pid: int) -> int | None:
    """Return the child of a process once it has worked for a while, so that it is drawing."""
    children = Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
    ticks = [int(Path(f"/proc/{child}/stat").read_text().rpartition(")")[2].split()[11]) for child in children]
    return int(children[0]) if ticks and ticks[0] > 15 else None


def test_a_child_process_without_the_one_that_started_it_draws_nothing():
    task = {**TASK, "seconds": 20, "patience": 20, "parent": os.getpid() + 1}
    command = [sys.executable, child.__file__, json.dumps(task)]
    done = subprocess.run(command, input=svg_file().encode(), capture_output=True, check=False)
    assert done.returncode and not done.stdout


def test_a_child_process_that_nobody_stops_ends_by_itself():
    task = {**TASK, "seconds": 20, "patience": 1, "parent": os.getpid()}
    command = [sys.executable, child.__file__, json.dumps(task)]
    done = subprocess.run(command, input=mask_bomb().encode(), capture_output=True, check=False, timeout=limit(20))
    assert done.returncode and not done.stdout
