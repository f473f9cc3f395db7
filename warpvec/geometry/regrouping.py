"""Build scenes anew from the loops of another one: other loops for each path, and other rows for some loops."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise

import torch
from torch import Tensor

from warpvec.geometry.scene import Scene
from warpvec.geometry.structure import Structure


def regrouped(
    scene: Scene,
    paths: Sequence[int],
    loops: Sequence[Sequence[int]],
    changed: Mapping[int, tuple[Tensor, Tensor]] | None = None,
) -> Scene:
    """Return a scene with a path for each of ``loops``, lists of numbers of loops of ``scene``.

    Args:
        scene: the scene.
        paths: the path of it that each looks like [N].
        loops: of each path, at least one.
        changed: other rows [S, 3, 2] for some loops, by their number in ``scene``, and which are lines [S].
    """
    structure = scene.structure
    sizes = structure.loop_first_segment.diff().tolist()
    rows, lines = (list(torch.split(values, sizes)) for values in (scene.segments, structure.lines))
    for loop, (segments, is_line) in (changed or {}).items():
        rows[loop], lines[loop] = segments.to(scene.segments), is_line
    order = [loop for each in loops for loop in each]
    is_open = None if structure.is_open is None else structure.is_open[order]
    counts = [[len(rows[loop]) for loop in each] for each in loops]
    chosen = scene.select(torch.tensor(paths, dtype=torch.int64))
    found = replace(
        chosen, forms=None, segments=torch.cat([rows[loop] for loop in order]),
        structure=Structure.of_loops(counts, torch.cat([lines[loop] for loop in order]), is_open),
    )  # fmt: skip
    return found.with_forms(chosen.forms)


def with_loops(scene: Scene, changed: Mapping[int, tuple[Tensor, Tensor]]) -> Scene:
    """Return ``scene`` with other rows [S, 3, 2] for some loops, by their number, and which are lines [S]."""
    own = [list(range(start, stop)) for start, stop in pairwise(scene.structure.path_first_loop.tolist())]
    return regrouped(scene, range(len(scene)), own, changed)
