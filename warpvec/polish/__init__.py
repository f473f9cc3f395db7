"""Fit the outlines and paints of a drawing whose structure stays."""
