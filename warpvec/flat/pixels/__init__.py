"""Pictures whose pixels are meant: pixel art and codes."""
