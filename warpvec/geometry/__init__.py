"""Geometry: scenes of closed Bezier paths, and operations on curves."""
