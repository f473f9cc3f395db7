"""Goals for a file, and the search of a mode for a drawing that meets them."""
