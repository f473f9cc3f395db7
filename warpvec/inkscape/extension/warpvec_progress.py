"""A window with the progress of warpvec: lines come from stdin, and "stop" or "cancel" goes to stdout."""

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
    """A bar, a line of text and two buttons. Inkscape 1.2 itself does not react while an extension works."""

    def __init__(self, title: str) -> None:
        super().__init__(title="warpvec", default_width=WIDTH, border_width=12)
        self.set_keep_above(True)
        self._is_counted = False
        self._bar = Gtk.ProgressBar()
        self._text = Gtk.Label(label="Starting. A first run takes longer.", xalign=0.0)
        self._buttons = Gtk.Box(spacing=8, halign=Gtk.Align.END)
        for label, answer in (("Cancel", "cancel"), ("Stop and keep the best so far", "stop")):
            button = Gtk.Button(label=label)
            button.connect("clicked", self._answer, answer)
            self._buttons.add(button)
        self.connect("delete-event", self._answer, "cancel")
        rows = Gtk.Box(orientation=Gtk.Orientation.VERTICAL, spacing=8)
        for row in (Gtk.Label(label=title, xalign=0.0), self._bar, self._text, self._buttons):
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

    def _answer(self, *values: object) -> bool:
        """Print the last of ``values``, the answer that a button stands for."""
        print(values[-1], flush=True)
        self._buttons.set_sensitive(False)
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
