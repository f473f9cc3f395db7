"""Fit outlines with few lines and cubics."""
