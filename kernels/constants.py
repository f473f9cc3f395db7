"""Every number the kernels depend on, each with its reason; the only copy."""

TILE = 16
"""Tile side in pixels: one AVX-512 register of float32 per pixel column; 256 pixels, one CUDA block, per tile."""

COLUMNS = TILE + 1
"""Columns a partial pair stores: its own, and one that takes what its last column passes on to the right."""

CHORD_TOLERANCE = 0.15
"""Largest distance in pixels between a cubic and its chords, by Wang's bound; most chords stay far below it. 8 fixed
chords per cubic cost 0.8 dB in the file that resvg draws; at 0.05 px there are 1.4 times as many chords to walk and
the gap between the internal image and resvg's does not shrink (0.06 dB at 30 dB: resvg's anti-aliasing)."""

SEGMENT_CHORDS_MAX = 256
"""Chords per cubic at most: enough for a cubic of 25,000 px at CHORD_TOLERANCE; bounds what one wild path can cost."""

COORDINATE_MAX = 1.0e7
"""Vertices farther out than this are treated as not finite: beyond it float32 cannot tell neighbouring pixels apart
and integer tile indices could overflow."""

COLUMN_GUARD = 1.0 / 64.0
COLUMN_GUARD_SLOPE = 1.0e-6
"""Pixels, and share of its length, by which an edge's range of columns is widened, so that rounding in the clipping
(1e-5 px at 8,000 px, and of the order of 1e-7 of a long edge) never puts part of an edge in an unmarked tile."""

TRANSMITTANCE_MIN = 1.0e-4
"""Paths behind full pairs that let less light through than this are skipped: at most 0.026 of an 8-bit level."""

FLAT_EDGE = 1.0e-20
"""Stand-in for an edge's zero dx or dy in a division: the quotient overflows every clamp, as it should, and its
largest value, 1e27, is still finite in float32."""

EMPTY, FULL, PARTIAL = 0, 1, 2
"""Classes of a (path, tile) pair: no pixel inside, every pixel inside, or crossed by an edge."""

REDUCED_LANES = 32
"""Scalar lanes that share one slot of a sum over a tile: one CUDA warp."""

CPU_FLAGS = "-march=native -ffp-contract=fast"
CPU_FLAGS_X86 = " -mprefer-vector-width=512"
"""Clang flags for the CPU kernels: fused multiply-adds gain 10-25 %, 512-bit vectors, of x86 alone, up to 5 %."""

XING_SCALE = 1e-2
"""What ``xing_weight`` multiplies besides the loss: the scale inside Bezier Splatting's ``xing_loss``, on which
the paper builds (LIVE's own is 1e-3). Without it the weight 0.02 costs 1.5 dB after 400 iterations."""

LEG_MIN = 1e-2
"""Shortest leg with a direction, in pixels: the ends of a shorter one round to the same point of the file (2 decimals).
The gradient of a sine grows as 1 / length, so this also bounds it."""

PROJECTION_WEIGHT = 0.01
"""Weight of the projection term inside the Bezier regularizer, from Bezier Splatting's code."""

EXTENT_MIN = 1.0
"""Added to the squared extent of a path, in pixels per axis: a path below a pixel has no shape that the image shows.
(Bezier Splatting adds 1e-8 in normalised units.)"""

TIP_PARAMETER = 5 / 32
"""How far along the two cubics at an anchor its tip is probed. Bezier Splatting looks 5 of 128 samples of the closed
outline away, which is 5 / 32 of a cubic when 4 of them make the outline."""

TIP_COSINE = 0.5
"""Corners sharper than 60 degrees are needle tips (Bezier Splatting)."""
