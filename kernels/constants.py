"""Every number the kernels depend on, each with its reason; the only copy."""

TILE = 16
"""Tile side in pixels: one AVX-512 register of float32 per pixel column; 256 pixels, one CUDA block, per tile."""

COLUMNS = TILE + 1
"""Columns a partial pair stores: its own, and one that takes what its last column passes on to the right."""

CHORD_TOLERANCE = 0.1
"""Largest distance in pixels between a cubic and its chords, by Wang's bound; most chords stay far below it. 8 fixed
chords per cubic cost 0.8 dB in the file that resvg draws; at 0.05 px there are 1.4 times as many chords to walk and
the gap between the internal image and resvg's does not shrink (0.06 dB at 30 dB: resvg's anti-aliasing)."""

SEGMENT_CHORDS_MAX = 256
"""Chords per cubic at most: enough for a cubic of 25,000 px at CHORD_TOLERANCE; bounds what one wild path can cost."""

COORDINATE_MAX = 1.0e7
"""Vertices farther out than this are treated as not finite: beyond it float32 cannot tell neighbouring pixels apart
and integer tile indices could overflow."""

COLUMN_GUARD = 1.0 / 64.0
"""Pixels by which an edge's range of columns is widened, so that rounding in the clipping (about 1e-5 px at 8,000 px)
never puts part of an edge in a column or a tile that was not marked."""

TRANSMITTANCE_MIN = 1.0e-4
"""Paths behind full pairs that let less light through than this are skipped: at most 0.026 of an 8-bit level."""

FLAT_EDGE = 1.0e-20
"""Stand-in for an edge's zero dx or dy in a division: the quotient overflows every clamp, as it should, and its
largest value, 1e27, is still finite in float32."""

EMPTY, FULL, PARTIAL = 0, 1, 2
"""Classes of a (path, tile) pair: no pixel inside, every pixel inside, or crossed by an edge."""

REDUCED_LANES = 32
"""Scalar lanes that share one slot of a sum over a tile: one CUDA warp."""

CPU_FLAGS = "-march=native -ffp-contract=fast -mprefer-vector-width=512"
"""Clang flags for the CPU kernels: fused multiply-adds gain 10-25 %, 512-bit vectors up to 5 %."""
