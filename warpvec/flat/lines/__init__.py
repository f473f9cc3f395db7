"""Draw scans and drawings of lines by strokes: their centre lines, each once."""
