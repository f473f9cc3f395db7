"""Read the drawings in SVGs of other programs."""
