"""Drawings for machines that cut and draw: outlines in millimetres, with true circles and arcs."""
