"""Say outlines and centre lines again, as lines, circular arcs and cubics that meet smoothly or in corners."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import torch

from warpvec.arrays import Floats, Mask
from warpvec.config.fit_config import FitConfig
from warpvec.flat.chains.chain import Chain
from warpvec.flat.chains.parts import LINE, rows_of
from warpvec.flat.chains.relations import find_relations
from warpvec.flat.chains.sketch import parted, sketch_of
from warpvec.flat.chains.solve import Sketch, solved
from warpvec.flat.chains.verdict import Verdict
from warpvec.flat.price import number_nats
from warpvec.flat.simplification.critic import Critic
from warpvec.geometry.bezier import whole_curves
from warpvec.geometry.scene import Scene
from warpvec.geometry.structure import Structure
from warpvec.watch.watch import Watch

TRIED = ((1.0, True), (1.0, False), (0.4, True))
"""Shares of the detail that are tried as the deviation of places, and whether with relations. What the picture refuses is
tried with the next."""

CURVES_MAX = 400
"""Most curves of a chain that is looked at: longer ones are no designer's."""


def with_chains(scene: Scene, critic: Critic, watch: Watch, detail: float = FitConfig.detail) -> Scene:
    """Return ``scene`` with chosen parts where the exact error hardly rises.

    Args:
        scene: a drawing of filled and stroked cubics, fitted to the picture. Its forms stay.
        critic: judges the changes against the picture.
        watch: the watch over the run. When it is over, nothing more is changed.
        detail: root mean square in pixels by which an outline may move, as the picture shows it.
    """
    verdict = Verdict(scene, critic, detail)
    left = _chains_of(scene)
    found: dict[int, tuple[Floats, Mask]] = {}
    for share, is_regular in TRIED:
        if not left or watch.is_over():
            break
        tried = found | _said(left, share * detail, number_nats(max(critic.image.shape[:2])), is_regular)
        while tried.keys() - found.keys():
            changed = np.isin(np.arange(scene.structure.loop_count), list(tried.keys() - found.keys()))
            refused = verdict.refused(with_rows(scene, tried), changed)
            if not refused.any():
                break
            tried = {loop: rows for loop, rows in tried.items() if not refused[loop]}
        found, left = tried, {loop: chain for loop, chain in left.items() if loop not in tried}
    return with_rows(scene, found) if found else scene


def _chains_of(scene: Scene) -> dict[int, Chain]:
    """Return the chain of each loop that has no form."""
    control, structure = whole_curves(scene).double().numpy(), scene.structure
    owner, forms = structure.segment_path.numpy(), scene.forms
    found = {}
    for loop, (start, stop) in enumerate(pairwise(structure.loop_first_segment.tolist())):
        is_open = structure.is_open is not None and bool(structure.is_open[loop])
        is_form = forms is not None and bool(forms.is_form[owner[start]])
        curves = control[start : stop - is_open]
        curves = curves[np.abs(np.diff(curves, axis=1)).max((1, 2), initial=0.0) > 1e-6]
        if not is_form and 0 < len(curves) <= CURVES_MAX:
            found[loop] = Chain.of(curves, not is_open)
    return found


def _said(chains: dict[int, Chain], spread: float, nats: float, is_regular: bool) -> dict[int, tuple[Floats, Mask]]:
    """Return the rows [S, 3, 2] of each of ``chains``, and which are lines [S]."""
    parts = [parted(chain, np.ones(len(chain.lengths)), spread, nats) for chain in chains.values()]
    sketch = sketch_of(parts, spread)
    solved(sketch)
    if is_regular:
        find_relations(sketch, spread)
        solved(sketch)
    return {loop: _rows(sketch, number) for number, loop in enumerate(chains)}


def _rows(sketch: Sketch, number: int) -> tuple[Floats, Mask]:
    """Return the rows of a chain of a sketch, and which are lines."""
    begin, end = sketch.ranges[number]
    rows = [rows_of(int(sketch.kind[part]), sketch.of(part)) for part in range(begin, end)]
    is_line = [np.full(len(own), sketch.kind[part] == LINE) for own, part in zip(rows, range(begin, end), strict=True)]
    if not sketch.chains[number].is_closed:
        rows.append(np.repeat(sketch.of(end - 1)[2:4][None, None], 3, 1))
        is_line.append(np.array([True]))
    return np.concatenate(rows), np.concatenate(is_line)


def with_rows(scene: Scene, loops: dict[int, tuple[Floats, Mask]]) -> Scene:
    """Return ``scene`` with other rows [S, 3, 2] for some loops, of which some are lines [S]."""
    structure = scene.structure
    sizes = structure.loop_first_segment.diff().tolist()
    rows, lines = (list(torch.split(values, sizes)) for values in (scene.segments, structure.lines))
    for loop, (segments, is_line) in loops.items():
        rows[loop], lines[loop] = torch.from_numpy(segments).to(scene.segments), torch.from_numpy(is_line)
    counts = [[len(each) for each in rows[a:b]] for a, b in pairwise(structure.path_first_loop.tolist())]
    parted = Structure.of_loops(counts, torch.cat(lines), structure.is_open)
    return replace(scene, segments=torch.cat(rows), structure=parted, forms=None).with_forms(scene.forms)
