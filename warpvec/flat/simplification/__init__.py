"""Drop what a picture does not need: paths, nodes, and small irregularities."""
