"""A window with the progress of warpvec: lines come from stdin, and "stop" goes to stdout if the user wants that."""

from __future__ import annotations

import re
import sys
import threading

import gi

gi.require_version("Gtk", "3.0")
from gi.repository import GLib, Gtk  # noqa: E402 (the version must be known before)

PULSE_MS = 150
"""Time between two steps of the bar while the length of the work is unknown."""

WIDTH = 420
"""Width in pixels, which the longest line fits."""

_ITERATION = re.compile(r"iteration (\d+) of (\d+), (.*)")


class ProgressWindow(Gtk.Window):  # type: ignore[misc] # GTK has no types
    """A bar, a line of text and a button."""

    def __init__(self, title: str) -> None:
        super().__init__(title="warpvec", default_width=WIDTH, border_width=12)
        self.set_keep_above(True)
        self._is_counted = False
        self._bar = Gtk.ProgressBar()
        self._text = Gtk.Label(label="Starting. A first run takes longer.", xalign=0.0)
        self._button = Gtk.Button(label="Stop and keep the best so far", halign=Gtk.Align.END)
        self._button.connect("clicked", self._stop)
        self.connect("delete-event", self._stop)
        rows = Gtk.Box(orientation=Gtk.Orientation.VERTICAL, spacing=8)
        for row in (Gtk.Label(label=title, xalign=0.0), self._bar, self._text, self._button):
            rows.add(row)
        self.add(rows)
        GLib.timeout_add(PULSE_MS, self._pulse)

    def show_line(self, line: str) -> None:
        """Show a line of warpvec."""
        match = _ITERATION.match(line)
        if match:
            self._is_counted = True
            self._bar.set_fraction(int(match[1]) / max(1, int(match[2])))
        self._text.set_text(match[3] if match else line.strip())

    def _pulse(self) -> bool:
        if not self._is_counted:
            self._bar.pulse()
        return not self._is_counted

    def _stop(self, *_: object) -> bool:
        print("stop", flush=True)
        self._button.set_sensitive(False)
        self._text.set_text("Stopping.")
        return True  # a closed window would look as if the work had ended


def _read(window: ProgressWindow) -> None:
    for line in sys.stdin:
        GLib.idle_add(window.show_line, line)
    GLib.idle_add(Gtk.main_quit)


def main() -> None:
    """Show the window until stdin ends."""
    window = ProgressWindow(sys.argv[1])
    window.show_all()
    threading.Thread(target=_read, args=(window,), daemon=True).start()
    Gtk.main()


if __name__ == "__main__":
    main()
