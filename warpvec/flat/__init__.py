"""Flat art: find the regions of a logo, an icon or a drawing, and their outlines as few clean paths."""
