"""From an image to a result: one fit, or the search for a file that meets a goal."""
