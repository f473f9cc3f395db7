"""The extension for Inkscape: its installer, and in ``extension/`` the files that Inkscape's own Python runs."""
