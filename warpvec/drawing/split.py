"""Split a drawing into the parts that lie apart, such as the icons of a sheet: a drawing for each."""

from __future__ import annotations

import re
from dataclasses import replace
from itertools import pairwise

import numpy as np
import torch
from numpy.typing import NDArray
from scipy import ndimage
from scipy.cluster.hierarchy import fcluster, linkage
from scipy.spatial.distance import squareform

from warpvec.drawing.drawing import Drawing
from warpvec.drawing.encoding import flat_units
from warpvec.errors import InputError
from warpvec.geometry.regrouping import regrouped
from warpvec.geometry.scene import Scene
from warpvec.purposes.table import PURPOSES
from warpvec.purposes.texts import text_for
from warpvec.svg.measure import draw
from warpvec.svg.minify import write_minified
from warpvec.svg.write import write_svg

PIECES_MAX = 2000
"""Most pieces of a drawing that are sorted into parts: each two of them are compared."""

Integers = NDArray[np.int64]


def split_texts(drawing: Drawing) -> list[str]:
    """Return the text of an SVG for each part of ``drawing`` that lies apart, from top to bottom, without a canvas.

    What touches is one piece. Pieces are one part if the gap between them is of the narrow kind, as between the lines
    of an icon. Gaps are of two kinds where their widths differ most.

    A drawing in units of a grid has parts in these units, on canvases of whole ones.

    Raises:
        InputError: it has too many pieces.
    """
    scene, picture = replace(drawing.scene.cpu(), transparent=True, background=torch.zeros(3)), drawing.encoding.picture
    width, height = picture.width, picture.height
    shown = draw(write_svg(scene, width, height), width, height, transparent=True)[..., 3] > 0
    labels, count = ndimage.label(shown, np.ones((3, 3)))
    if count == 0:
        return []
    if count > PIECES_MAX:
        raise InputError("--split", f"must have a drawing of at most {PIECES_MAX:,} pieces", f"{count:,}")
    boxes = np.array([[[s.start, s.stop] for s in box] for box in ndimage.find_objects(labels)])
    part, (rows, columns) = _parts(boxes), _canvas(drawing)
    sides = boxes * [[rows], [columns]] / [[height], [width]]
    parted, owner = _parted(scene, part[_piece_of_loop(scene, labels)])
    texts = []
    for number in range(int(part.max()) + 1):
        own = np.flatnonzero(owner == number)
        top, left = np.floor(sides[part == number, :, 0].min(0)).astype(int).tolist()
        bottom, right = np.ceil(sides[part == number, :, 1].max(0)).astype(int).tolist()
        if len(own):
            moved = parted.select(torch.from_numpy(own)).scaled(columns / width, rows / height).moved(-left, -top)
            texts.append(_text(drawing, moved, right - left, bottom - top))
    return texts


def _parts(boxes: Integers) -> Integers:
    """Return the part of each piece [n] by the ``boxes`` of the pieces [n, 2, 2]: rows and columns, first and end."""
    if len(boxes) < 2:
        return np.zeros(len(boxes), np.int64)
    gaps = np.maximum(boxes[:, None, :, 0] - boxes[None, :, :, 1], boxes[None, :, :, 0] - boxes[:, None, :, 1])
    away = np.hypot(*np.maximum(gaps, 0).transpose(2, 0, 1)).astype(np.float64)
    tree = linkage(squareform(away, checks=False), "single")
    steps = np.diff(tree[:, 2], prepend=0.0)
    cut = tree[steps.argmax() - 1, 2] if steps.argmax() else 0.0
    found = fcluster(tree, cut, "distance")
    first = np.unique(found, return_index=True)[1]
    rank = np.empty(len(first), np.int64)
    rank[np.argsort(first)] = np.arange(len(first))
    return np.asarray(rank[found - 1])


def _piece_of_loop(scene: Scene, labels: Integers) -> Integers:
    """Return the piece [L] that the first point of each loop is in, or is nearest to, by its ``labels`` [h, w]."""
    height, width = labels.shape
    _, (rows, columns) = ndimage.distance_transform_edt(labels == 0, return_indices=True)
    starts = scene.segments[scene.structure.loop_first_segment[:-1].long(), 0].double().numpy()
    x, y = np.floor(starts).astype(np.int64).T
    x, y = x.clip(0, width - 1), y.clip(0, height - 1)
    return np.asarray(labels[rows[y, x], columns[y, x]] - 1)


def _parted(scene: Scene, part: Integers) -> tuple[Scene, Integers]:
    """Return ``scene`` with each path cut into those of one part, by the ``part`` of its loops [L], and their parts."""
    structure = scene.structure
    groups = []
    for path, (start, stop) in enumerate(pairwise(structure.path_first_loop.tolist())):
        own = part[start:stop]
        groups += [(path, number, start + np.flatnonzero(own == number)) for number in np.unique(own)]
    parted = regrouped(scene, [path for path, _, _ in groups], [loops.tolist() for _, _, loops in groups])
    return parted, np.array([number for _, number, _ in groups])


def _text(drawing: Drawing, scene: Scene, width: int, height: int) -> str:
    """Return the text of a part of a ``drawing`` on a canvas of its own, in units of `_canvas`."""
    encoding, picture = drawing.encoding, drawing.encoding.picture
    (rows, columns), stated = _canvas(drawing), encoding.sides if encoding.grid else None
    sides = encoding.options.sides(picture.width, picture.height) or stated
    if sides is not None:
        sides = _share(sides[0], width / columns), _share(sides[1], height / rows)
    is_exact = encoding.closes_exactly
    if encoding.is_minified:
        units, precision = (1, encoding.precision) if encoding.grid else (flat_units(encoding.settings), 0)
        sides, scene = sides or (str(width), str(height)), scene.scaled(units, units)
        size, keeps_layers = (units * width, units * height), encoding.keeps_layers
        text = write_minified(
            scene, *size, sides, precision=precision, keeps_layers=keeps_layers, closes_exactly=is_exact
        )
    else:
        precision, names = encoding.precision, encoding.layer_names
        text = write_svg(
            scene, width, height, precision=precision, sides=sides, layer_names=names, closes_exactly=is_exact
        )
    return text_for(text, PURPOSES[encoding.options.purpose]).text


def _canvas(drawing: Drawing) -> tuple[float, int]:
    """Return height and width of the whole in the units of parts: those of the grid, or pixels."""
    encoding = drawing.encoding
    return encoding.size if encoding.grid else (encoding.picture.height, encoding.picture.width)


def _share(side: str, share: float) -> str:
    """Return a ``share`` of a length with its unit."""
    found = re.fullmatch(r"([0-9.e+-]+)([a-z%]*)", side)
    assert found is not None
    return f"{float(found[1]) * share:.6g}{found[2]}"
