"""Turn a folder of photos into a folder of SVGs, on many workers, and keep records of it."""
