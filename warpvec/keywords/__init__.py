"""Keyword arguments of `warpvec.vectorize` and `warpvec.refine`: their types, and signatures that help() shows."""
