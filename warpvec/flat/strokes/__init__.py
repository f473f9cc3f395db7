"""Find the shapes of flat art that are strokes, and their centre lines."""
