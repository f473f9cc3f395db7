"""Differentiable rendering of scenes: the exact and the splat renderer, and ``render`` for torch."""
