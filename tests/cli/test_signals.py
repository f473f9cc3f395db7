"""Signals that end a command: what is kept, what is left, and the exit code. Each case is a process of its own."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from children import limit, runs, start, wait_for

from warpvec.watch.interrupt import SIGNALS

pytestmark = pytest.mark.skipif(os.name == "nt", reason="Windows has no signals to send to a process")

START = """
import hashlib, sys, time
from pathlib import Path
from warpvec.cli.signals import listener, raised_interrupts, run_command
from warpvec.temporary_files import temporary_file

def say(word):
    print(word, flush=True)

def wait_for_signal():
    for _ in range(3000):
        if listener().has_signal():
            return
        time.sleep(0.01)
    sys.exit("no signal came")

def command():
"""

NATIVE = 'hashlib.pbkdf2_hmac("sha256", b"", b"", 10**9)'
"""Minutes of native code. Python runs no signal handler meanwhile."""


class Child:
    """A process with a command of these lines, which has printed "ready"."""

    def __init__(self, *lines: str, ignored: int | None = None) -> None:
        def ignore() -> None:
            if ignored is not None:
                signal.signal(ignored, signal.SIG_IGN)

        code = START + "".join(f"    {line}\n" for line in lines) + "run_command(command)"
        self._process = start(
            [sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, preexec_fn=ignore
        )
        self.expect("ready")

    def expect(self, word: str) -> None:
        """Wait for a line of the process."""
        assert self._process.stdout is not None
        assert self._process.stdout.readline() == f"{word}\n"

    def send(self, number: int) -> None:
        """Send a signal."""
        self._process.send_signal(number)

    def end(self) -> tuple[int, str, str]:
        """Return the exit code and what is left of the output, within half a minute."""
        try:
            stdout, stderr = self._process.communicate(timeout=limit(30))
        finally:
            self._process.kill()
        return self._process.returncode, stdout, stderr


def test_a_command_that_draws_says_if_a_signal_leaves_no_drawing() -> None:
    child = Child("from warpvec.cli.signals import drawing_listener", "drawing_listener()", "say('ready')", NATIVE)
    child.send(signal.SIGTERM)
    code, _, stderr = child.end()
    assert code == 128 + signal.SIGTERM
    assert stderr == "warpvec: interrupted before there was a drawing; none is written\n"


@pytest.mark.parametrize("number", SIGNALS)
def test_before_there_is_a_result_a_signal_ends_the_process_and_leaves_nothing(tmp_path: Path, number: int) -> None:
    child = Child(
        f"with temporary_file(Path({str(tmp_path)!r}, 'out.svg')):",
        "    say('ready')",
        f"    {NATIVE}",
    )
    assert len(os.listdir(tmp_path)) == 1
    child.send(number)
    assert child.end() == (128 + number, "", "")
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize("number", SIGNALS)
def test_a_signal_lets_a_command_with_a_result_write_it(number: int) -> None:
    child = Child(
        "listener().hold()",
        "say('ready')",
        "wait_for_signal()",
        "say('written')",
    )
    child.send(number)
    assert child.end() == (128 + number, "written\n", "")


def test_the_second_signal_ends_the_process_and_leaves_nothing(tmp_path: Path) -> None:
    child = Child(
        "listener().hold()",
        f"with temporary_file(Path({str(tmp_path)!r}, 'out.svg')):",
        "    say('ready')",
        "    wait_for_signal()",
        "    say('noted')",
        f"    {NATIVE}",
    )
    child.send(signal.SIGTERM)
    child.expect("noted")
    child.send(signal.SIGINT)
    assert child.end() == (130, "", "")
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize("number", SIGNALS)
def test_a_signal_that_is_ignored_at_the_start_stays_ignored(number: int) -> None:
    child = Child("say('ready')", "time.sleep(0.3)", "say('done')", ignored=number)
    child.send(number)
    assert child.end() == (0, "done\n", "")


@pytest.mark.parametrize("number", SIGNALS)
def test_a_batch_gets_a_keyboard_interrupt(number: int) -> None:
    child = Child(
        "try:",
        "    with raised_interrupts():",
        "        say('ready')",
        "        time.sleep(30)",
        "except KeyboardInterrupt:",
        "    say('stopped')",
    )
    child.send(number)
    assert child.end() == (128 + number, "stopped\n", "")


def test_a_slow_listener_does_not_end_a_batch_that_was_interrupted() -> None:
    child = Child(
        "from warpvec.cli.signals import _Listener",
        "_Listener._leave_closed_terminal = lambda self: time.sleep(0.3)",
        "try:",
        "    with raised_interrupts():",
        "        say('ready')",
        "        time.sleep(30)",
        "except KeyboardInterrupt:",
        "    time.sleep(1)",
        "    say('stopped')",
    )
    child.send(signal.SIGINT)
    assert child.end() == (130, "stopped\n", "")


def test_an_error_keeps_its_exit_code() -> None:
    child = Child("listener().hold()", "say('ready')", "wait_for_signal()", "sys.exit(2)")
    child.send(signal.SIGTERM)
    assert child.end() == (2, "", "")


def test_a_closed_terminal_ends_a_command_in_order(tmp_path: Path) -> None:
    termios = pytest.importorskip("termios")
    fcntl = pytest.importorskip("fcntl")
    body = f"""
    listener().hold()
    say("ready")
    wait_for_signal()
    Path({str(tmp_path)!r}, "out.svg").touch()
    say("summary")
run_command(command)"""

    def take_terminal() -> None:
        fcntl.ioctl(0, termios.TIOCSCTTY, 0)

    ours, theirs = os.openpty()
    with start(
        [sys.executable, "-c", START + body],
        stdin=theirs, stdout=theirs, stderr=theirs, start_new_session=True, preexec_fn=take_terminal,
    ) as process:  # fmt: skip
        os.close(theirs)
        with open(ours, "rb", buffering=0) as terminal:
            assert terminal.readline() == b"ready\r\n"
        assert process.wait(timeout=limit(30)) == 128 + signal.SIGHUP
    assert os.listdir(tmp_path) == ["out.svg"]


def test_a_missing_stream_is_not_taken_for_the_signals() -> None:
    body = """
    os.write(1, bytes([signal.SIGTERM]))
    time.sleep(0.3)
import os, signal
run_command(command)"""
    done = subprocess.run([sys.executable, "-c", START + body], preexec_fn=lambda: os.closerange(0, 2), check=False)
    assert done.returncode == 0


@pytest.mark.skipif(sys.platform != "linux", reason="reads the state of a process in /proc")
def test_a_signal_ends_the_encoder_of_a_video(tmp_path: Path) -> None:
    pytest.importorskip("imageio_ffmpeg", reason="the extra video is not installed")
    encoder, number = tmp_path / "encoder", tmp_path / "number"
    encoder.write_text(f"#!/bin/sh\necho $$ > {number}\nexec sleep 60\n")
    encoder.chmod(0o700)
    child = Child(
        "import os, numpy",
        "from warpvec.image.video import Video",
        f"os.environ['IMAGEIO_FFMPEG_EXE'] = {str(encoder)!r}",
        f"with Video({str(tmp_path / 'fit.mp4')!r}) as video:",
        "    video.add(numpy.zeros((2, 2, 3), numpy.float32))",
        f"    while not Path({str(number)!r}).exists() or not Path({str(number)!r}).read_text(): time.sleep(0.01)",
        "    say('ready')",
        f"    {NATIVE}",
    )
    child.send(signal.SIGTERM)
    assert child.end() == (128 + signal.SIGTERM, "", "")
    wait_for(lambda: not runs(int(number.read_text())))
    assert sorted(os.listdir(tmp_path)) == ["encoder", "number"]


@pytest.mark.slow
def test_a_signal_removes_the_temporary_folder_of_kernels(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    child = Child(
        "import os",
        f"os.environ.update(TMPDIR={str(tmp_path)!r}, WARP_CACHE_PATH={str(tmp_path / 'file')!r})",
        "from warpvec.rendering.launch import start_warp",
        "start_warp()",
        "assert len(os.listdir(os.environ['TMPDIR'])) == 2",
        "say('ready')",
        NATIVE,
    )
    child.send(signal.SIGTERM)
    assert child.end()[0] == 128 + signal.SIGTERM
    assert os.listdir(tmp_path) == ["file"]
