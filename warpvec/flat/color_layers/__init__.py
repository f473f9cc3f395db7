"""Layers of a file of flat art: one for each colour, as far as the painting order allows it."""
