"""Find the regions of a picture: areas of one paint, and how the pixels between them are mixed."""
