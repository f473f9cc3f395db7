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
"""Paths behind what lets less light through than this are skipped: full pairs, or the Gaussians on every pixel of a
tile: at most 0.026 of an 8-bit level."""

FLAT_EDGE = 1.0e-20
"""Stand-in for an edge's zero dx or dy in a division: the quotient overflows every clamp, as it should, and its
largest value, 1e27, is still finite in float32."""

EMPTY, FULL, PARTIAL = 0, 1, 2
"""Classes of a (path, tile) pair: no pixel inside, every pixel inside, or crossed by an edge."""

REDUCED_LANES = 32
"""Scalar lanes that share one slot of a sum over a tile: one CUDA warp."""

CANVAS_THREADS = 4096
"""Scalar lanes that share the sums over all tiles: each adds every 4096th, warps of them make 128 sums of theirs, and
one thread adds those. At 4096 x 4096 pixels each has 128 rows to add, as the last one has."""

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

SPLAT_END = 0.007
"""Parameter of the first sample of a side, and its distance from 1 at the last one (Bezier Splatting)."""

LINE_SPREAD = 0.85
LINE_REACH = 2.0
"""Interior lines blend the two sides with the weights Phi(x / LINE_SPREAD), x from -LINE_REACH to LINE_REACH in equal
steps, Phi the standard normal distribution: denser near the sides (Bezier Splatting)."""

SIGMA_PER_SPACING = 2.0 / 3.0
"""Standard deviation of a Gaussian over the distance to its neighbour (Bezier Splatting: a third of the distance in
coordinates of which two span a pixel's worth): neighbours overlap enough that no ripple of 1 % is left between them."""

END_FACTORS = (0.4, 0.9)
"""Length along the curve of the first and second sample of a side, and of the last ones, over the others' rule: sharp
ends (Bezier Splatting)."""

BOUNDARY_SIGMA_X_MIN = 0.3
BOUNDARY_SIGMA_Y_MIN = 0.75
BOUNDARY_SIGMA_Y_MAX = 1.0
"""Bounds in pixels of a boundary sample's standard deviation along and across the curve (Bezier Splatting): an edge as
soft as a pixel, whose Gaussians no pixel centre can miss."""

INTERIOR_SIGMA_MIN = 0.25
"""Least standard deviation in pixels of an interior sample. Bezier Splatting has none, and paths that collapse give
infinities; below it a Gaussian of full opacity is invisible from 0.83 px on, and pixel centres are up to 0.71 away."""

TANGENT_MIN = 1.0e-6
"""Tangents shorter than this, in pixels, have no direction: their samples lie upright."""

SPLAT_ALPHA_MIN = 1.0 / 255.0
"""A Gaussian's alpha below this is dropped (3D Gaussian Splatting): one level of 8 bits, and it bounds its reach."""

SPLAT_ALPHA_MAX = 0.999
"""A Gaussian's alpha is clipped here, in the image and in its adjoint alike, which divides by 1 - alpha."""

SPLAT_GROUP = 8
"""Neighbouring samples of a line that share a box, tested before their own: 9 tests for 8 samples where it is hit."""

LENGTH_MIN = 1.0e-30
"""Stand-in for a length or an opacity of 0 in a division whose numerator is 0 as well."""
