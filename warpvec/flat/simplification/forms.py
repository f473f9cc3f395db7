"""Find the outlines that are circles, ellipses and rectangles, and say so.

Only what the picture shows of an outline is evidence: a form completes what is hidden.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain, pairwise

import numpy as np
import torch

from warpvec.arrays import Mask
from warpvec.config.fit_config import FitConfig
from warpvec.flat.constants.simplification import SIMPLIFICATION
from warpvec.flat.simplification.accepted_changes import kept_loops
from warpvec.flat.simplification.critic import Critic
from warpvec.flat.simplification.form_candidates import Candidate, candidates, whole_canvas
from warpvec.flat.simplification.local_error import boxes_of
from warpvec.flat.simplification.outline_samples import OutlineSamples, segment_loops
from warpvec.geometry.forms.registry import OUTLINE, RECT, form_of
from warpvec.geometry.path_forms import Forms
from warpvec.geometry.regrouping import regrouped
from warpvec.geometry.scene import Scene
from warpvec.watch.decisions import Decision, are_wanted, box_of, note
from warpvec.watch.watch import Watch


def find_forms(
    scene: Scene, critic: Critic, watch: Watch, detail: float = FitConfig.detail, left: Mask | None = None
) -> Scene:
    """Return ``scene`` with forms where the exact error hardly rises.

    A part of a path becomes a path of its own if most parts of the path are forms.

    Args:
        scene: a scene of filled cubics without forms, fitted to the image.
        critic: judges the changes against the image.
        watch: the watch over the run. When it is over, the forms that are found so far must do.
        detail: root mean square in pixels by which an outline may move, as the picture shows it.
        left: paths [N] that are left as they are; None for none.
    """
    if not len(scene) or watch.is_over():
        return scene
    samples = critic.samples(scene)
    is_eligible = _separate_loops(scene, samples)
    if left is not None:
        is_eligible &= ~np.repeat(left, scene.structure.path_first_loop.diff().long().numpy())
    height, width = critic.image.shape[:2]
    offers = _offers(scene, samples, is_eligible, detail, (width, height))
    offered = {loop: list(found) for loop, found in offers if not watch.is_over()}
    if are_wanted():
        _note_others(scene, is_eligible, offered)
    found: dict[int, Candidate] = {}
    while offered := {loop: each for loop, each in offered.items() if each}:
        tried = {loop: each.pop(0) for loop, each in offered.items()}
        curves = {loop: each.curves for loop, each in tried.items()}
        kept = kept_loops(scene, curves, critic, samples, SIMPLIFICATION.regular_share * detail)
        found |= {loop: tried[loop] for loop in kept}
        offered = {loop: each for loop, each in offered.items() if loop not in kept}
    return _with_forms(scene, found)


def _note_others(scene: Scene, is_eligible: Mask, offered: dict[int, list[Candidate]]) -> None:
    """Note the loops that no form is tried for."""
    first = scene.structure.loop_first_segment.tolist()
    for loop, (start, stop) in enumerate(pairwise(first)):
        reason = "no form is near" if is_eligible[loop] else "it is a stroke, or meets a loop of its path"
        if not offered.get(loop):
            place, before = box_of(scene.segments[start:stop].double().numpy()), f"{stop - start} segments"
            note(Decision("forms", place, before, "form", None, None, is_taken=False, reason=reason))


def _offers(
    scene: Scene, samples: OutlineSamples, is_eligible: Mask, detail: float, size: tuple[int, int]
) -> Iterator[tuple[int, Iterator[Candidate]]]:
    """Yield each loop that may have a form, and these forms; ``size`` is the width and height of the picture."""
    seen = samples.visibility
    weights = np.where(seen < SIMPLIFICATION.hidden_visibility, 0.0, seen * samples.lengths)
    is_line = scene.structure.lines.numpy()
    for loop, (start, stop) in enumerate(pairwise(scene.structure.loop_first_segment.tolist())):
        if is_eligible[loop]:
            rows = slice(start, stop)
            around = [whole] if (whole := whole_canvas(samples.points[rows], size)) is not None else []
            yield loop, chain(around, candidates(samples.points[rows], weights[rows], is_line[rows], detail))


def _separate_loops(scene: Scene, samples: OutlineSamples) -> Mask:
    """Return which loops [L] lie apart from all others of their path: each could be a path of its own."""
    first = scene.structure.path_first_loop.tolist()
    low, high = boxes_of(samples.control, segment_loops(scene), scene.structure.loop_count)
    is_apart = np.ones(scene.structure.loop_count, np.bool_)
    for start, stop in pairwise(first):
        a, b = low[start:stop], high[start:stop]
        meet = ((a[:, None] <= b) & (a <= b[:, None])).all(2)
        is_apart[start:stop] = meet.sum(1) == 1
    return is_apart


def _with_forms(scene: Scene, found: dict[int, Candidate]) -> Scene:
    """Return ``scene`` with the forms that were ``found`` for loops; of paths of several loops, if they are most."""
    owners, loops, kinds = [], [], []
    for path, (start, stop) in enumerate(pairwise(scene.structure.path_first_loop.tolist())):
        own = _parted(found, start, stop)
        rest = [loop for loop in range(start, stop) if loop not in own]
        for part in ([rest] if rest else []) + [[loop] for loop in own]:
            owners.append(path)
            loops.append(part)
            kinds.append(own.get(part[0]))
    changed = {
        part[0]: (torch.from_numpy(form.curves), torch.tensor(form_of(form.kind).is_line))
        for part, form in zip(loops, kinds, strict=True)
        if form is not None
    }
    return regrouped(scene, owners, loops, changed).with_forms(forms_of(kinds)) if changed else scene


def _parted(found: dict[int, Candidate], start: int, stop: int) -> dict[int, Candidate]:
    """Return the forms of the loops of a path that become paths of their own."""
    own = {loop: found[loop] for loop in range(start, stop) if loop in found}
    if stop - start == 1:
        return own
    own = {loop: each for loop, each in own.items() if each.kind != RECT}  # four lines say as much
    return own if len(own) >= SIMPLIFICATION.form_split_min * (stop - start) else {}


def forms_of(kinds: list[Candidate | None]) -> Forms:
    """Return the forms of paths, of which each has one or none."""
    numbers = [OUTLINE if each is None else each.kind for each in kinds]
    parameters = np.stack([np.zeros(6) if each is None else each.parameters for each in kinds])
    return Forms(torch.tensor(numbers, dtype=torch.int32), torch.from_numpy(parameters).float())
