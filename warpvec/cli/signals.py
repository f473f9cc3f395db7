"""End the command in order when a signal asks for it: Ctrl-C (SIGINT), SIGTERM, or SIGHUP of a closed terminal.

- As long as there is no result, the process ends at once. Nothing is written, and no temporary file stays. A command
  that draws says so.
- Once a fit has a result, the first signal ends the fit. The result is measured and written as after a whole fit.
- In a batch the first signal raises KeyboardInterrupt, which stops the workers and keeps the records.
- A second signal ends the process at once.

The exit code is 128 plus the number of the signal, as shells have it. A signal that is ignored when the command
starts, as SIGHUP is under nohup, stays ignored.

A thread of its own acts on the signals. Python calls a handler in the main thread only, between two instructions of
its own: it waits while native code compiles a kernel, which takes up to half a minute. And an exception that a handler
raises can be lost in a destructor, or turned into another error while a module is loaded.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext, suppress
from types import FrameType

from warpvec.cli.streams import prepare_streams
from warpvec.temporary_files import remove_live_files
from warpvec.watch.interrupt import SIGNALS, Listener, blocked_signals

INTERRUPTED = 130
"""Exit code of a command that ended itself after Ctrl-C: 128 + SIGINT."""

_STOP = 0
_SHOW_CURSOR = b"\x1b[?25h"
_NONE_WRITTEN = b"warpvec: interrupted before there was a drawing; none is written\n"


def run_command(command: Callable[[], None]) -> None:
    """Call ``command``, which ends with SystemExit, and end with the exit code of the first signal if there was one."""
    prepare_streams()  # before the listener opens files, which would get the numbers of missing streams
    listener = _Listener()
    listener.start()
    code: str | int | None = 0
    try:
        command()
    except SystemExit as end:
        code = end.code
    finally:
        listener.stop()
    if listener.number is not None and code in (0, None, INTERRUPTED):
        code = 128 + listener.number
    sys.exit(code)


def raised_interrupts() -> AbstractContextManager[None]:
    """Raise KeyboardInterrupt at the first signal in this block, whichever it is. It does nothing without a listener.

    This is for work that waits for other processes, whose end a flag would not bring about.
    """
    return nullcontext() if _Listener.current is None else _Listener.current.raising()


def end_if_signalled() -> None:
    """End this process at once if a signal has come, although threads of it still work: nothing waits for them."""
    listening = _Listener.current
    if listening is not None and listening.number is not None:
        _end_now(128 + listening.number)


def listener() -> Listener | None:
    """Return what listens to the signals of this process, for the watch over a run; None outside of `run_command`."""
    return _Listener.current


def drawing_listener() -> Listener | None:
    """Return the `listener` for a command that draws: it says so if a signal ends it without a drawing."""
    if _Listener.current is not None:
        _Listener.current.early_words = _NONE_WRITTEN
    return listener()


class _Listener:
    """The signals of this process, and what the first of them does.

    Attributes:
        number: that of the first signal; None if there was none.
        early_words: what is printed if the first signal ends the process because there is no result.
    """

    current: _Listener | None = None

    def __init__(self) -> None:
        self.number: int | None = None
        self.early_words = b""
        self._has_result = self._raises = self._has_raised = False
        self._handled = [number for number in SIGNALS if _is_default(number)]
        self._terminals = [stream for stream in (1, 2) if os.isatty(stream)]

    def start(self) -> None:
        """Handle the signals from now on."""
        _Listener.current = self
        self._pipe = os.pipe()
        if os.name != "nt":
            os.set_blocking(self._pipe[1], False)
        self._thread = threading.Thread(target=self._listen, name="warpvec-signals", daemon=True)
        with blocked_signals():  # the thread inherits that: the system gives signals to the main thread
            self._thread.start()
        signal.set_wakeup_fd(self._pipe[1], warn_on_full_buffer=False)
        self._install()

    def stop(self) -> None:
        """Leave the signals to the system again. What the command has printed is out by then."""
        for stream in (sys.stdout, sys.stderr):
            with suppress(OSError, ValueError, AttributeError):  # closed, or None
                stream.flush()
        # Not Python's handler of SIGINT, which would print a traceback while Python ends.
        for number in self._handled:
            signal.signal(number, signal.SIG_DFL)
        signal.set_wakeup_fd(-1)
        os.write(self._pipe[1], bytes([_STOP]))
        self._thread.join()
        for end in self._pipe:
            os.close(end)
        _Listener.current = None

    def has_signal(self) -> bool:
        """Return whether there was a signal."""
        return self.number is not None

    def hold(self) -> None:
        """From now on there is a result, which the first signal must not lose."""
        self._has_result = True

    @contextmanager
    def raising(self) -> Iterator[None]:
        """Raise KeyboardInterrupt at the first signal in this block."""
        self._install()  # Ray has handlers of its own
        self._raises = True
        try:
            yield
        finally:
            self._raises = False

    def _install(self) -> None:
        for number in self._handled:
            signal.signal(number, self._handle)

    def _handle(self, number: int, frame: FrameType | None) -> None:
        if self._raises and not self._has_raised:
            self._has_raised = True
            raise KeyboardInterrupt

    def _listen(self) -> None:
        """Receive the number of each signal from the system."""
        while (number := os.read(self._pipe[0], 1)[0]) != _STOP:
            self._leave_closed_terminal()
            is_first, self.number = self.number is None, self.number or number
            # The main thread may have raised already, and left its block, before this thread runs.
            is_handled = self._has_result or self._raises or self._has_raised
            if is_first and not is_handled:
                with suppress(OSError):  # stderr is closed
                    os.write(2, self.early_words)
            if not is_first or not is_handled:
                _end_now(128 + number)

    def _leave_closed_terminal(self) -> None:
        """Drop what is printed from now on if the terminal is closed: the command would fail on its summary."""
        for stream in self._terminals:
            if not os.isatty(stream):
                sink = os.open(os.devnull, os.O_WRONLY)
                os.dup2(sink, stream)
                os.close(sink)


def _end_now(code: int) -> None:
    """End this process, without a temporary file left."""
    remove_live_files()
    if "rich" in sys.modules and os.isatty(2):  # its bars hide the cursor
        with suppress(OSError):
            os.write(2, _SHOW_CURSOR)
    os._exit(code)


def _is_default(number: int) -> bool:
    return signal.getsignal(number) in (signal.SIG_DFL, signal.default_int_handler)
