"""The types of the keyword arguments of `warpvec.vectorize` and `warpvec.refine`.

Written by ``python -m warpvec.keywords.table > warpvec/keywords/typed.py``; do not edit.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, TypedDict


class Keywords(TypedDict, total=False):
    """Settings, goals and choices about the file; see `warpvec/config/README.md`."""

    max_bytes: int | None
    """Make the best file of at most this size (50000, 80k)."""
    target_psnr: float | None
    """Use the fewest paths that reach this PSNR (25 to 35)."""
    target_ssim: float | None
    """Use the fewest paths that reach this SSIM (0.6 to 0.9)."""
    gzip: bool
    """Count max_bytes after gzip."""
    mode: Literal["auto", "photo", "flat", "mono", "lines", "pixel", "mixed"]
    """auto, photo, flat, mono, lines, pixel or mixed."""
    detail: float
    """Drawings: how far outlines may move, in pixels."""
    cutout: bool
    """Flat: make no overlaps, for cutters and plotters."""
    strokes: Literal["auto", "all", "off"]
    """Flat, mono: draw lines as strokes along their middle."""
    threshold: int | str
    """Black and white: level from 0 to 255 below which a pixel is dark, or auto (Otsu's)."""
    line_width: float | str
    """Lines: width of all strokes in pixels, or auto (as in the picture)."""
    pens: int
    """Lines: most pens, each of a colour; 0 for as many as the picture has."""
    smooth_pixels: bool
    """Pixels: draw the curves that pixel art and bitmap fonts mean."""
    as_is: bool
    """Drawings: do not undo an enlargement or uneven light."""
    blur: float | str
    """Drawings: blur to undo, a deviation in pixels (0: none), or auto (as measured)."""
    paper: Literal["auto", "keep", "remove"]
    """Flat, mono: paper below the drawing: keep (white), remove (transparent), or auto."""
    colors: int
    """Most colours, 0 for any; makes paths opaque."""
    palette: str | Sequence[str] | None
    """Use only these colours: red,#a0b1c2, or a file."""
    opacity: Literal["free", "common", "opaque"]
    """Opacity of the paths: free, common (one for all) or opaque."""
    gradients: float | Literal["auto"] | None
    """Paths with a gradient: 40, a share (0.5), auto or 0."""
    soft: int | str
    """Most paths with a blurred edge, for shadows and smooth shades: auto, N or 0."""
    min_area: float
    """Leave out paths smaller than X square pixels."""
    lod: bool
    """Make levels of detail: the lowest K layers alone make a good picture, for every K."""
    minify: bool
    """Write the shortest file; on with --max-bytes."""
    units: int
    """Units per pixel of a minified file; 0 for as many as needed."""
    grid: int | str
    """Drawings: units along the longer side of the grid that it was made on; auto or off."""
    precision: int
    """Decimals of the coordinates, 0 to 6."""
    path_model: Literal["segments", "sides"]
    """Shape of a path: segments (a loop of cubics) or sides (two curves, for splat)."""
    segments: int
    """Average number of cubics per path."""
    fixed_segments: bool
    """Give each path exactly --segments cubics."""
    closing_line: bool
    """Close every path by a straight line after its cubics."""
    backdrop: Literal["learned", "white"]
    """Canvas colour: learned (fitted) or white."""
    iterations: int
    """Optimization steps; more give a better picture."""
    time_budget: float | None
    """Longest time for the optimization, in seconds."""
    seed: int
    """Start of the random numbers; equal seeds give equal files."""
    renderer: Literal["exact", "splat"]
    """Renderer: exact (areas, as SVG viewers draw them) or splat (the paper's Gaussians)."""
    device: str
    """Processor: auto, cpu, cuda or cuda:K."""
    threads: int | None
    """CPU threads; the result does not depend on them."""
    fit_size: int
    """Longest side of the image that is fitted, in pixels."""
    policy: Literal["scaffolding", "replacement", "stratification"]
    """Policy: scaffolding (Algorithm 1) or replacement (Bezier Splatting's) or stratification (its code's)."""
    z_order: Literal["creation", "area"]
    """Paths on top: creation (the newest) or area (the smallest)."""
    initial_curves: int
    """Number of paths at the start, N0."""
    growth: float
    """Each inflation multiplies the paths by this, r_num: 1, or at least 1.01."""
    inflation_gap: int
    """Iterations between inflations, dT."""
    shorten_gap: bool
    """Shorten the gaps between inflations, and between removals, if the run is too short."""
    initial_radius: float
    """Radius of the first paths, in units of half the longer side."""
    radius_decay: float
    """Radius of new paths, as a share of the generation before, r_rad."""
    prune_opacity: float
    """Largest opacity at which an inflation removes a path."""
    compensate: bool
    """Replace the paths that an inflation removed."""
    one_generation: bool
    """Start with all paths, in one generation."""
    recycle_gap: int
    """Iterations between recyclings; 0 for none."""
    recycle_share: float
    """Share of the paths that one recycling replaces."""
    recycle_until: float
    """Time of the last recycling, as a share of the iterations."""
    lr_points: float
    """Learning rate of the control points, in units of half the longer side."""
    lr_color: float
    """Learning rate of the colours."""
    lr_opacity: float
    """Learning rate of the opacities."""
    lr_scale: float
    """Factor for every learning rate."""
    lr_decay: Literal["cosine", "constant", "steps"]
    """Decay of the learning rates: cosine, constant or steps (Bezier Splatting's)."""
    lr_final: float
    """Ratio of the final and the initial learning rate, for cosine decay."""
    axis_rates: bool
    """Measure the rate of the control points by half of each side, not of the longer one."""
    common_age: bool
    """Let new paths take the optimizer's count of steps from the others."""
    color_parameter: Literal["direct", "logit"]
    """Optimize colours directly (direct) or through a sigmoid (logit)."""
    opacity_weight: float
    """Weight of the term for opaque paths."""
    ssim_weight: float
    """Weight of the structural similarity (SSIM); 0 for the squared error alone."""
    xing_weight: float
    """Weight of the term against crossing handles."""
    bezier_weight: float
    """Weight of the Bezier regularizer."""
    degree: int
    """Degree of the curves of --path-model sides."""
    samples: int
    """Number of Gaussians along each side and line of a path."""
    lines: int
    """Number of lines of Gaussians between the two sides of a path."""
    interior_gradient: bool
    """Let the Gaussians inside a path move its control points."""
    covariance_gradient: bool
    """Let the sizes and directions of Gaussians move the control points."""
    released_adjoint: bool
    """Clip opacities in the adjoint as the code of Vector Scaffolding does."""
    side_opacities: bool
    """Let opacity change from side A over the middle to side B of a path."""
    color_falloff: bool
    """Let Gaussians near the middle of a path count less for its colour."""
    without_projection: bool
    """Leave the projection out of the Bezier regularizer of --path-model sides."""
    replace_gap: int
    """Iterations from removing paths to adding as many, and until the next removal."""
    size: str | None
    """Width: 90mm, also in, cm, pt, px, %; Qt, Skia: --ppi."""
    purpose: Literal["web", "plain", "word", "print", "android", "font", "tiny", "pen", "cricut"]
    """What it is for, such as plain, android, word or pen."""
    trim: bool
    """Cut the paths off at the edges of the canvas."""
    plain_paths: bool
    """Write paths only, no circles, ellipses or rectangles."""
    no_dashes: bool
    """Write each dash of a dashed line as a line, for cutters and pens."""
    line_width_min: float
    """Say so if strokes are thinner, in pixels of the picture."""
    dxf_splines: bool
    """DXF: write curves as splines, not as arcs."""
    dxf_strokes: Literal["auto", "edges", "center"]
    """DXF: strokes as both edges, or for pens as the center lines."""
    world_file: str | Sequence[float] | None
    """GeoJSON: place it on the map by this world file, such as map.pgw."""
    ppi: Literal["mm", "96", "72"]
    """State --size as is (mm), or in px of 1/96 or 1/72 inch: Qt and Skia take mm at 90 dpi, sharp at 72."""
    current_color: str | None
    """Give this colour (or the darkest) the page's text colour."""
    symbol: str | None
    """Write a <symbol> with this id, for a sprite."""
