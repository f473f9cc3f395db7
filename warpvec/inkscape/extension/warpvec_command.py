"""Call warpvec, as it was when the extension was installed, and show the progress of its fits."""

from __future__ import annotations

import json
import os
import queue
import select
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from typing import IO, Any

from warpvec_refusal import Refusal

SETTINGS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "command.json")
"""File that ``warpvec inkscape install`` writes beside this one: {"command": [program, argument, ...]}."""

REMEDY = "Open a terminal and run: warpvec inkscape install"

WAIT_SECONDS = 0.1
"""Time between two looks at the buttons and the output: short for a hand, and long for the processor."""

END_SECONDS = 0.5
"""Time that a process gets to end after each signal. Nobody wants its result any more."""

_ERROR = "warpvec: error: "
_STOPPED = 130
"""Exit code of warpvec if it was told to stop: 128 + SIGINT. It has then saved the best result so far, if any."""


def installed_command() -> list[str]:
    """Return the program and arguments that start warpvec.

    Raises:
        Refusal: warpvec is no longer where it was.
    """
    try:
        with open(SETTINGS, encoding="utf-8") as file:
            command = json.load(file)["command"]
    except (OSError, ValueError, KeyError):
        raise Refusal("The extension is not completely installed. " + REMEDY) from None
    if not os.path.isfile(command[0]):
        raise Refusal(f"warpvec is not at {command[0]} any more, or Inkscape may not look there. {REMEDY}")
    return [str(word) for word in command]


def fit(*arguments: str, title: str | None) -> Any:
    """Return the JSON that warpvec prints with ``arguments``, and show its progress under a ``title``, None for not.

    The process ends here, with warpvec, if the user cancels or Inkscape does not wait for it any more.

    Raises:
        Refusal: warpvec fails or was stopped before it had a result; the message is that of warpvec.
    """
    process = _started([*installed_command(), *arguments])
    lines: queue.Queue[str] = queue.Queue()
    output: list[str] = []
    readers = [_reader(process.stderr, lines.put), _reader(process.stdout, output.append)]
    window = None if title is None else _Window(title)
    try:
        seen = _follow(process, lines, window)
    finally:
        _end(process)
        if window is not None:
            window.close()
    for reader in readers:
        reader.join()
    if process.returncode not in (0, _STOPPED) or not output:
        raise Refusal(_reason(process.returncode, seen + _waiting(lines)))
    return json.loads("".join(output))


def _started(command: list[str]) -> subprocess.Popen[str]:
    # Inkscape sets PYTHONPATH and PYTHONHOME for its own Python, and warpvec has another.
    environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    options: dict[str, Any] = {"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    options["creationflags"] = getattr(subprocess, "CREATE_NO_WINDOW", 0)  # Windows would open a black one
    try:
        return subprocess.Popen(command, env=environment, encoding="utf-8", errors="replace", **options)
    except OSError as error:
        raise Refusal(f"{command[0]} does not start ({error.strerror}). {REMEDY}") from None


def _reader(stream: IO[str] | None, take: Callable[[str], Any]) -> threading.Thread:
    """Give each line of ``stream`` to ``take``, in a thread: a full pipe would stop warpvec."""
    assert stream is not None
    thread = threading.Thread(target=_read, args=(stream, take), daemon=True)
    thread.start()
    return thread


def _read(stream: IO[str], take: Callable[[str], Any]) -> None:
    with stream:  # an open stream at the end is a warning, and Inkscape shows every warning
        for line in stream:
            take(line)


def _follow(process: subprocess.Popen[str], lines: queue.Queue[str], window: _Window | None) -> list[str]:
    """Wait until warpvec ends, and return the ``lines`` that have been shown."""
    seen: list[str] = []
    while process.poll() is None:
        for line in _waiting(lines):
            seen.append(line)
            if window is not None:
                window.show(line)
        answers = [] if window is None else window.answers()
        if _has_left() or "cancel" in answers:
            _end(process)
            sys.exit(0)  # without a new document on stdout, the old one stays
        if "stop" in answers:
            process.send_signal(signal.SIGTERM if sys.platform == "win32" else signal.SIGINT)
        with suppress(subprocess.TimeoutExpired):
            process.wait(WAIT_SECONDS)
    return seen


def _waiting(lines: queue.Queue[str]) -> list[str]:
    """Return the lines that have come since the last call."""
    found = []
    with suppress(queue.Empty):
        while True:
            found.append(lines.get_nowait())
    return found


def _has_left() -> bool:
    """Return whether nobody reads our stdout any more: Inkscape closes it if the user cancels. Windows cannot tell."""
    if not hasattr(select, "poll"):
        return False
    poll = select.poll()
    poll.register(1, 0)
    return any(event & (select.POLLERR | select.POLLHUP) for _, event in poll.poll(0))


def _end(process: subprocess.Popen[str]) -> None:
    """End ``process``. The first signal lets warpvec end in order, the second one makes it leave at once."""
    for _ in range(2):
        if process.poll() is None:
            process.terminate()
            with suppress(subprocess.TimeoutExpired):
                process.wait(END_SECONDS)
    process.kill()
    process.wait()


def _reason(code: int, lines: list[str]) -> str:
    """Return why warpvec had no result: the line of its error, or its last line."""
    texts = [line.strip() for line in lines if line.strip()]
    errors = [text[len(_ERROR) :] for text in texts if text.startswith(_ERROR)]
    if errors:
        return "warpvec: " + errors[-1]
    if code == _STOPPED:
        return "warpvec was stopped before it had a result."
    return "warpvec ended with the code {}: {}. {}".format(code, texts[-1] if texts else "it gave no reason", REMEDY)


class _Window:
    """A window with the progress, in a process of its own: without GTK there is none, and the work goes on."""

    def __init__(self, title: str) -> None:
        script = os.path.join(os.path.dirname(SETTINGS), "warpvec_progress.py")
        pipes: dict[str, Any] = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL}
        self._process = subprocess.Popen([sys.executable, script, title], encoding="utf-8", **pipes)
        self._answers: queue.Queue[str] = queue.Queue()
        self._reader = _reader(self._process.stdout, self._answers.put)

    def show(self, line: str) -> None:
        """Show a line of warpvec."""
        assert self._process.stdin is not None
        with suppress(OSError, ValueError):  # there is no window
            self._process.stdin.write(line)
            self._process.stdin.flush()

    def answers(self) -> list[str]:
        """Return what the user has chosen since the last call: "stop" to keep the best so far, or "cancel"."""
        return [answer.strip() for answer in _waiting(self._answers)]

    def close(self) -> None:
        """Close the window."""
        assert self._process.stdin is not None
        with suppress(OSError):
            self._process.stdin.close()
        _end(self._process)
        self._reader.join()
