"""The numbers that the kernels depend on, each with its reason. This is their only copy."""

TILE = 16
"""Tile side in pixels: one AVX-512 register of float32 per pixel column; 256 pixels, one CUDA block, per tile."""

COLUMNS = TILE + 1
"""Columns stored for a partial pair: the tile's own, and one for the winding to the right of the tile."""

CHORD_TOLERANCE = 0.15
"""Largest distance in pixels between a cubic and its chords, by Wang's bound; most chords stay far below it. A fixed
number of 8 chords per cubic costs 0.8 dB in the file as resvg draws it. A tolerance of 0.05 px needs 1.4 times as
many chords and leaves the gap between the internal image and resvg's as it is (0.06 dB at 30 dB: anti-aliasing)."""

SEGMENT_CHORDS_MAX = 256
"""Maximum number of chords per cubic: enough for 25,000 px at CHORD_TOLERANCE. It bounds the cost of one wild path."""

ARC_CHORDS_MAX = 256
"""Maximum number of chords of a round cap or join, and of a side of a stroke because of its turns."""

TURN_SAMPLES = 32
"""Equal steps of t in which a row of a stroke is looked at for the fastest turn of its tangent."""

JOIN_ANGLE_MIN = 1.0e-4
"""Angle in radians below which the rows of a stroke meet without a join: at a width of 1,000 px its sides are then
0.05 px apart."""

COORDINATE_MAX = 1.0e7
"""Vertices farther out than this, in pixels, count as not finite: beyond it float32 cannot tell neighbouring pixels
apart, and integer tile indices could overflow."""

COLUMN_GUARD = 1.0 / 64.0
COLUMN_GUARD_SLOPE = 1.0e-6
"""Margin added to an edge's range of columns: pixels, and a share of the edge's length. It keeps rounding in the
clipping (1e-5 px at 8,000 px, about 1e-7 of a long edge) from putting part of an edge in an unmarked tile."""

TRANSMITTANCE_MIN = 1.0e-4
"""Transmittance below which everything farther back in a tile is skipped. It is tested on the full pairs of the exact
renderer, and on every pixel of a tile by the splat renderer. The error is at most 0.026 of an 8-bit level."""

FLAT_EDGE = 1.0e-20
"""Replaces an edge's zero dx or dy in a division. The quotient then exceeds every clamp, as it should, and its largest
value, 1e27, is still finite in float32."""

EMPTY, FULL, PARTIAL = 0, 1, 2
"""Classes of a (path, tile) pair: no pixel inside the path, every pixel inside, or crossed by an edge."""

REDUCED_LANES = 32
"""Number of scalar lanes that add to one slot of a sum over a tile: one CUDA warp."""

CANVAS_THREADS = 4096
"""Number of scalar lanes that add the sums over all tiles. Each lane adds every 4096th row, each warp adds its lanes'
sums to one of 128, and one thread adds those. At 4096 x 4096 pixels each lane adds 128 rows, like the last thread."""

CPU_FLAGS = "-march=native -ffp-contract=fast"
CPU_FLAGS_X86 = " -mprefer-vector-width=512"
"""Clang flags for the CPU kernels: fused multiply-adds gain 10-25 %; 512-bit vectors, on x86 only, gain up to 5 %."""

GAUSSIAN_REACH = 3.5
"""Reach of the Gaussian of a soft path, in standard deviations. What lies beyond is 0.05 % of an edge on each side, an
eighth of an 8-bit level; at 3 the blur would be 1.4 % narrower than its standard deviation."""

XING_SCALE = 1e-2
"""Scale of the Xing loss, by which ``xing_weight`` is multiplied. It is the scale inside Bezier Splatting's
``xing_loss``, on which the paper builds (LIVE: 1e-3). Without it a weight of 0.02 costs 1.5 dB in 400 iterations."""

DIRECTION_MIN = 1e-6
"""Shorter directions, in pixels, are divided by this and not by their length."""

LEG_MIN = 1e-2
"""Length in pixels below which a leg of the control polygon has no direction: its ends round to the same point of the
file (2 decimals). The gradient of a sine grows as 1 / length, so this also bounds the gradient."""

PROJECTION_WEIGHT = 0.01
"""Weight of the projection term inside the Bezier regularizer, from Bezier Splatting's code."""

EXTENT_MIN = 1.0
"""Pixels per axis added to the squared extent of a path: the image does not show the shape of a path smaller than a
pixel. (Bezier Splatting adds 1e-8 in normalised units.)"""

TIP_PARAMETER = 5 / 32
"""Parameter distance from an anchor at which its two cubics are probed for a needle tip. Bezier Splatting looks 5 of
128 samples of the closed outline away, which is 5 / 32 of a cubic when the outline has 4 cubics."""

TIP_COSINE = 0.5
"""Corners sharper than 60 degrees are needle tips (Bezier Splatting)."""

SPLAT_END = 0.007
"""Parameter of the first sample of a side; the last sample is at 1 minus this (Bezier Splatting)."""

LINE_SPREAD = 0.85
LINE_REACH = 2.0
"""Interior lines blend the two sides with the weights Phi(x / LINE_SPREAD), where Phi is the standard normal
distribution and x runs from -LINE_REACH to LINE_REACH in equal steps: denser near the sides (Bezier Splatting)."""

SIGMA_PER_SPACING = 2.0 / 3.0
"""Standard deviation of a Gaussian divided by the distance to its neighbour. (Bezier Splatting uses a third,
in coordinates with two units per pixel.) Neighbours overlap enough that the ripple between them stays below 1 %."""

END_FACTORS = (0.4, 0.9)
"""Factors on the standard deviation along the curve of the first and second sample of a side, and of the last and last
but one: they keep the ends sharp (Bezier Splatting)."""

BOUNDARY_SIGMA_X_MIN = 0.3
BOUNDARY_SIGMA_Y_MIN = 0.75
BOUNDARY_SIGMA_Y_MAX = 1.0
"""Bounds in pixels of a boundary sample's standard deviation along (x) and across (y) the curve (Bezier Splatting).
They make an edge as soft as a pixel, whose Gaussians no pixel centre can miss."""

THIN_SIGMA, THIN_RATIO = 0.1, 3.0
"""Where an interior sample is less than the first number across the curve, in pixels, its longer standard deviation is
at most the second number times the shorter one (Bezier Splatting)."""

SIGMA_MIN_INSIDE = 1.0e-2
"""Least standard deviation in pixels of an interior sample: its inverse square stays finite, which Bezier Splatting
leaves to chance. So small a Gaussian reaches a pixel centre from one place in 300; those of a whole path still do."""

TANGENT_MIN = 1.0e-6
"""Length in pixels below which a tangent has no direction; (1, 0) is used instead."""

SPLAT_ALPHA_MIN = 1.0 / 255.0
"""Alpha below which a Gaussian is dropped at a pixel (3D Gaussian Splatting): one 8-bit level. It bounds the reach."""

SPLAT_ALPHA_MAX = 0.999
"""Maximum alpha of a Gaussian, in the image and in its adjoint, because the adjoint divides by 1 - alpha."""

RELEASED_ALPHA_MAX = 0.99
"""Maximum alpha by which the adjoint of Vector Scaffolding's code divides, from the backward pass of gsplat's 2D
kernel. Its forward pass has SPLAT_ALPHA_MAX."""

COLOR_FALLOFF = 4.0
"""The gradient that the colour of a path gets through an interior Gaussian is multiplied by 1 - exp(-COLOR_FALLOFF d).
There d = |u| + |v|, and u and v run from -1 to 1 along a line and across the lines (Bezier Splatting's code)."""

XING_TRIPLE = 3
"""Legs of the control polygon of two sides that the Xing term looks at together (Bezier Splatting's code)."""

XING_NORM_ADDED = 1e-8
"""Added to the product of the lengths of two legs, in half sides, before a sine is divided by it (its code)."""

LOGIT_MARGIN = 1e-7
"""Where a path has three opacities, they stay this far from 0 and 1 in the logits of which those of lines are blends.
It is the precision of a float32 near 1."""

SPLAT_GROUP = 8
"""Number of neighbouring samples of a line that share a bounding box. The box is tested first: 9 tests for 8 samples
where it is hit, 1 where it is missed."""

LENGTH_MIN = 1.0e-30
"""Replaces a length or an opacity of 0 in a division whose numerator is 0 as well."""
