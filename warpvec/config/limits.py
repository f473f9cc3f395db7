"""Limits of the values of settings, each with its reason."""

MAX_THREADS = 4096
"""Largest number of CPU threads, above the cores of any machine: more must be a mistake. A file of settings or a
checkpoint may come from a larger machine, so fewer are not refused, but `usable_threads` starts only some of them."""

GROWTH_MIN = 1.01
"""Smallest growth other than 1. With less, an inflation of a hundred paths adds none, which must be a mistake."""

MAX_CURVES = 2**15
"""Largest number of paths: twice what a goal may ask for. Twice as many take 2 GB on the smallest picture."""

MAX_SEGMENTS = 256
"""Largest number of cubics of a path; a path of so many cubics has more points than any outline needs."""

MAX_ALL_SEGMENTS = 2**22
"""Largest number of cubics of all paths together: they take gigabytes. A goal may have paths of the most segments."""

MAX_COUNT = 10**9
"""Largest count of what takes no memory. A fit of so many iterations takes weeks, and no image has such a side."""

MAX_UNITS = 1000
"""Most units per pixel of a minified file, as fine as three decimals."""

MAX_GRID = 4096
"""Most units along a side of a grid that a drawing is made on."""

MAX_GROWTH = 1e6
"""Largest growth, with which a single inflation adds all paths there may be."""

MAX_RADIUS = 1000.0
"""Largest initial radius, far beyond an image of radius 1. Coordinates of 1e15 would have no decimals to write."""

MAX_RATE = 10.0
"""Largest learning rate, also of the points after the factor: it moves a point by five images in a step. With far more,
values overflow or leave the range of what can be written."""

MAX_SCALE = 1000.0
"""Largest factor of the learning rates, for presets whose rates are small."""

MAX_SECONDS = 1e9
"""Largest time budget: thirty years. The schedule multiplies it, which must not overflow."""

MAX_WEIGHT = 1e6
"""Largest weight of a term of the loss. The optimizer squares the gradients, which must be finite in float32."""

DETAIL_MAX = 10.0
"""Largest tolerance of outlines in pixels. With more, nothing is left of a logo of 500 pixels."""

LINE_WIDTH_MAX = 1000.0
"""Largest width of a line in pixels. Wider ones cover a picture."""

BLUR_MAX = 20.0
"""Largest deviation of a blur in pixels. After more, nothing tells where an edge is."""

LEVEL_MAX = 255
"""Largest level of a threshold, white."""

MAX_PALETTE_BYTES = 2**24
"""Largest file of colours. It may be a style sheet or a drawing, of which the colours are taken."""

MAX_WORLD_FILE_BYTES = 2**12
"""Largest world file. It has six numbers."""
