"""Fitting: the loop, its target, the optimizer, and the policies that add and remove paths."""
