"""The numbers of flat art: how the stages of a drawing of flat art follow each other."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class DrawingConstants:
    """How the stages of a drawing of flat art follow each other."""

    # Fits between the stages (drawing.py)

    first_iterations: int = 8
    last_iterations: int = 16
    """Iterations of the fit of the traced outlines, and of that of the simplified ones. With 60 and 60 the mean PSNR of
    four pictures is 0.2 dB higher, for 1.3 times the time of the whole run."""

    many_values: int = 12_000
    """Coordinates of a drawing from which on each fit takes half as many iterations: a screenshot of 500 paths loses
    0.2 dB and takes a third of the time less."""

    share_after_long_steps: float = 0.3
    """Share of a time budget that must be left for a fit of so many coordinates, or for the search for paths that it
    does not need: one step of either with a Hilbert curve of 84,000 segments takes one to two seconds."""

    share_for_cutting: float = 0.4
    """Coordinates of a large drawing, and the share of a time budget that must be left when its fits end. With less
    left, cutting takes less care: a spiral of 42,000 coordinates takes 6 seconds with care, and 2 without."""

    gradient_steps: int = 6
    """Steps by gradients alone, with which large drawings are fitted, in place of each iteration."""

    small_side: int = 128
    small_tolerance: float = 0.14
    """Longest side of small pictures in pixels, and the largest distance in pixels of their traced outlines from the
    curves: they are shown several times larger. The mean PSNR of icons at four times their size is 0.8 dB higher so."""

    small_detail: float = 0.5
    """Share of the detail by which outlines of small pictures may move, as they are shown larger. The colour error of
    icons of 128 px is 0.11 with 0.5 and 0.14 with 1, and their files need 9 % more numbers."""

    fine_side: int = 64
    """Longest side in pixels of pictures whose outlines are found on a finer grid, and whose fits have tension. Sixteen
    drawings of 64 px gain 1.3 dB and 0.6 at four times their size; of 128 px they gain 0.3 and 0.2, but need 11 % more
    segments, and corners are farther off."""

    small_scale: float = 3.0
    """Enlargement at which curves are fitted to the outlines of small pictures that are found on a finer grid. Corners
    and round ends are closer to each other there than the fit expects: ends of lines of 2 to 3 px are off by 0.43 px at
    2, by 0.13 px at 3 and by 0.09 px at 4."""

    tension: float = 0.01
    """Squared error that a pixel of outline between black and white is worth in fits of pictures of ``fine_side``. What
    goes are hooks and spikes that hardly change a pixel: 44 icons of 24 and 48 px gain 0.18 dB at four times their
    size, with 5 % fewer segments. Logos enlarged from 100 px lose 0.05 dB, and the letters of up100_mantine 1.2 dB."""

    snap: float = 2.5 / 255.0
    """A fitted colour that differs by less in every channel from what the inside of its region shows is that colour:
    white stays #fff."""

    snap_noise: float = 1.0
    """The same as a part of the noise of the picture: ringing beside edges changes a fitted colour by 3 levels where
    the noise is 5.5. Of 31 logos as JPEG, 13 have tinted paper with half as much, and two with this; none is
    farther from the clean picture."""

    snap_shared: float = 120.0 / 255.0
    """The same for a path whose colour others have, too: the fitted colour of thin ones is uncertain. Those of text,
    dots of a halftone and small logos as JPEG differ by up to 100 levels; a magenta line of 3 px that JPEG had made
    look black differed by 160."""

    snap_canvas: float = 8.0 / 255.0
    """The same for the canvas, which may be white, too: fits move that of icons of 16 px by up to 4 levels. A
    traced one that no pure pixel shows is off by 15 where the fitted one is off by 3. With the 2.5 of others, two of
    thirteen icons of 16 to 32 px have tinted pages."""

    # Paper (modes/flat.py)

    paper_light_min: float = 0.6
    paper_tint_max: float = 0.16
    """Least channel of paper, and largest difference of its channels: yellowed paper has up to 40 of 255 levels, and
    recycled paper some 170."""

    # Layers of a scene (scene_building.py)

    layers_min: int = 16
    """Layers that are drawn even if the time is over: with none, nothing would be seen."""

    share_after_tracing: float = 0.4
    """Share of a time budget that is left for what follows the outlines: drawing, cutting and writing them."""

    share_after_words: float = 0.7
    """The same for what follows the search for words over several grounds: the regions below them, which take about as
    long as those of the picture, and the outlines."""

    layers_at_once: int = 32
    """Layers whose outlines are fitted together. The memory of a thousand together is 300 MB."""

    points_at_once: int = 30_000
    """Points of outlines above which those of so many layers are fitted in parts, between which the clock is seen."""

    # Layers of a file (color_layers/)

    overlap_side: int = 2
    overlap_squares: int = 256
    """Side in pixels of the squares of which overlapping paths both cover a part, and the largest number of squares in
    a row, above which they are larger. A square has whole pixels, so that no two paths of one pixel change places."""

    shades_apart: float = 0.05
    shade_lightness: float = 0.5
    """Largest distance in OKLab of paints that share a layer, and the weight of lightness in it: light and shadow keep
    the hue of a thing. In sixteen logos and emoji, 0.03 parts two browns of one edge, and 0.07 joins red and pink."""

    name_vividness: float = 1.5
    """Weight of the difference in chroma where a colour gets a name: #ea7600 is a dark orange, and no brown of nearly
    its lightness."""

    gray_chroma: float = 0.02
    """Chroma in OKLab below which a colour is a grey: the least difference that one sees."""

    rounded_pixels_max: int = 1_000_000
    """Most pixels of an enlarged picture whose JPEG is undone. Each of two rounds takes 0.8 s of CPU time and 150 MB
    for so many."""


DRAWING = DrawingConstants()
