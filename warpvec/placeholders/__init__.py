"""Placeholders: rough drawings of few bytes that a page shows until an image is there."""
