"""Kinds of picture files that Pillow does not read, each in a module that works in the sandbox."""
