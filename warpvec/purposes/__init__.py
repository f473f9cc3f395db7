"""Purposes of files: which programs and machines read them, what these cannot show, and what is drawn in its place."""
