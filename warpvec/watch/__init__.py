"""The watch over a run: progress, stop, clock and history."""
