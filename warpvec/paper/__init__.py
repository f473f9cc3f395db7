"""The methods of papers that warpvec compares itself with: Vector Scaffolding and Bezier Splatting as published.

The splat renderer, paths of two sides, the policy "replacement", and their presets and settings. Without this folder
and its line in `warpvec.config.rooms`, warpvec works without them.
"""
