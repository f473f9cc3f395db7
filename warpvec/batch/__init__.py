"""Turn a folder of photos into a folder of SVGs or VectorDrawables, on many workers, and keep records of it."""
