"""Stack regions into layers, and find the outlines of each layer."""
