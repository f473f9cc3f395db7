"""Find soft light in flat art: a shadow or a glow is what lies in front of it, moved and blurred, on a flat ground."""
