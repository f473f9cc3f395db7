"""The kinds of pictures that can be read."""

SUFFIXES = (
    ".png", ".jpg", ".jpeg", ".webp", ".tif", ".tiff", ".bmp", ".gif", ".avif", ".pbm", ".pgm", ".ppm", ".pnm", ".pam",
    ".psd", ".ico", ".icns", ".tga", ".qoi", ".pcx", ".dds", ".jp2", ".j2k", ".heic", ".heif",
    ".jxl", ".exr", ".ora", ".kra",
)  # fmt: skip
"""Suffixes of the files that count as pictures."""
