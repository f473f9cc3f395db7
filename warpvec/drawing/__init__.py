"""A drawing: a scene, and how it becomes a file."""
