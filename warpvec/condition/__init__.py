"""Measure what has happened to a picture: it was enlarged, blurred, saved as JPEG, or is noisy."""
