"""The weights of brightness. This module imports nothing, so that the command line starts fast."""

LUMA = (0.299, 0.587, 0.114)
"""Weights of red, green and blue in how bright a colour is (ITU-R BT.601), as JPEG has them."""
