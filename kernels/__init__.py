"""The renderer's kernels, one stage a file, for CPU and CUDA from one source.

Stages in order, each with its adjoint beside it or in ``<stage>_adjoint``::

    flattening    control points -> vertices           adj_vertices -> adj_points
    binning       vertices -> (path, tile) pairs       (no gradient)
    coverage      vertices, pairs -> winding           adj_winding -> adj_edges
    compositing   winding, colour, opacity -> image    adj_image -> adj_color, adj_opacity, adj_winding
    limits        counts -> what there is room for     (no gradient)
    regularization                                     adds to adj_points, adj_opacity
    population                                         the optimizer's step (adan), and the scene after it

and, in place of the first three, those of the splat renderer::

    splatting          control points -> Gaussians        splat_sums -> adj_points, adj_opacity
    splat_binning      Gaussians -> (path, tile) pairs    (no gradient)
    splat_coverage     Gaussians, pairs -> coverage       adj_coverage -> splat_sums, over each Gaussian's pixels

Conventions: pixels, origin at the top left, x right, y down, the centre of pixel (row i, column j) at
(j + 0.5, i + 0.5). Tiles are TILE x TILE pixels and store their pixels column by column, so that the TILE rows of one
column are neighbours in memory: a lane is a pixel row. ``adj_x`` is dL/dx; arrays are named ``<index>_<value>``,
counts ``<thing>_count``. A kernel's first argument is the index of its first work item, so that CPU threads can share
one launch; its outputs come last. Kernels write only slots that they own: no atomics, so results are reproducible.
"""
