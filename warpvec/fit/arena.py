"""Memory with room for paths that come and go, in which a recorded graph finds them without being recorded again.

A graph reads and writes fixed addresses, and launches fixed numbers of items. So the paths of a fit on a GPU lie at the
front of arrays that have room for more, and their number is on the device. Entries of the room draw nothing and are not
stepped: the paths after the last one have no segments, and the segments after the last one are those of one more path,
which lies off the canvas without an extent.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import torch
from torch import Tensor

from warpvec.fit.parametrization import PLANES
from warpvec.fit.recycling import Recycling, Sources
from warpvec.geometry.scene import Scene
from warpvec.geometry.side_opacity import SideOpacity
from warpvec.geometry.structure import Structure

OFF_CANVAS = -64.0
"""Both coordinates in pixels of segments that no path has: off every canvas."""

SEGMENT_ROOM = 1.125
"""Room for segments over the mean of the settings: paths of many are replaced by paths of few, and the other way round,
6 % at a time."""


class Held(NamedTuple):
    """The paths of a fit: the scene, and the parameters and averages that stand for it.

    Attributes:
        scene: N paths with R segments.
        rows: planes of segments [5, R, 2 M], colours [5, N, 3] and opacities [5, N, 1 or 3].
        segment_age: [R] int64.
        age: [N + 1 or more] int64, of the paths first, and of the background last.
    """

    scene: Scene
    rows: tuple[Tensor, ...]
    segment_age: Tensor
    age: Tensor


class Arena:
    """Memory for ``path_room`` paths of ``segment_room`` segments on ``device``.

    If paths are equal, the memory is a uniform scene: the room then has paths without an extent off the canvas.

    Attributes:
        padded: the whole memory as a scene.
        rows, segment_age, age: the whole memory of `Held`.
        counts: number of paths [1] (int32).
        path_room: paths that there is room for.
    """

    def __init__(self, held: Held, path_room: int, segment_room: int, is_equal: bool = False) -> None:
        scene, device = held.scene, held.scene.segments.device
        # The segments of the room are those of one more path, unless all paths are equal.
        paths, rows = path_room + (not is_equal), segment_room

        def blank(*shape: int, dtype: torch.dtype = torch.float32) -> Tensor:
            return torch.zeros(shape, dtype=dtype, device=device)

        self.path_room, self._segment_room = path_room, segment_room
        self._is_equal = is_equal
        widths = [values.shape[-1] for values in held.rows]
        self.rows = tuple(blank(PLANES, n, width) for n, width in zip((rows, paths, paths), widths, strict=True))
        self.segment_age, self.age = (blank(n, dtype=torch.int64) for n in (rows, paths + 1))
        self.counts = blank(1, dtype=torch.int32)
        names = ("loop_first_segment", "path_first_loop", "segment_path", "segment_next", "segment_previous")
        sizes = (paths + 1, paths + 1, rows, rows, rows)
        if is_equal:
            self._tables: dict[str, Tensor] = {}
            structure = Structure.uniform(paths, rows // paths, device)
        else:
            self._tables = {name: blank(n, dtype=torch.int32) for name, n in zip(names, sizes, strict=True)}
            self._tables["path_first_loop"].copy_(torch.arange(paths + 1))  # a loop a path
            first, loops = self._tables["loop_first_segment"], self._tables["path_first_loop"]
            structure = Structure(first, loops, check=False)
            # What these are made from changes in its memory, and so do they.
            vars(structure).update(self._tables, path_first_segment=first, _last_segment=rows)
        segments = blank(rows, *scene.segments.shape[1:])
        looks = (blank(paths, 3), blank(paths), scene.background, blank(paths, dtype=torch.int64))
        sides = None if scene.side_opacity is None else SideOpacity(blank(paths, 2))
        self.padded = Scene(segments, structure, *looks, scene.transparent, side_opacity=sides)
        self._recycling = Recycling(path_room, segment_room, device)

    @staticmethod
    def of_equal_paths(held: Held, path_room: int) -> Arena:
        """Return memory for ``path_room`` paths of as many segments as each path of the uniform scene has."""
        return Arena(held, path_room, path_room * held.scene.piece_count, is_equal=True)

    def has_room(self, scene: Scene) -> bool:
        """Return whether ``scene`` is plain, and small enough."""
        if self._is_equal and scene.structure.uniform_count != self.padded.structure.uniform_count:
            return False
        fits = len(scene) <= self.path_room and scene.structure.segment_count <= self._segment_room
        return fits and is_plain(scene)

    def can_add(self, scene: Scene, path_count: int, segment_count: int) -> bool:
        """Return whether `add` can put ``scene`` behind so many paths, of at most so many segments."""
        own, rows = self.padded.structure.uniform_count, scene.structure.segment_count
        is_equal = scene.structure.uniform_count is not None and own in (None, scene.structure.uniform_count)
        fits = path_count + len(scene) <= self.path_room and segment_count + rows <= self._segment_room
        return is_equal and fits and len(scene) > 0 and is_plain(scene)

    def take(self, held: Held) -> Held:
        """Copy the paths into this memory, and return them there."""
        scene, padded = held.scene, self.padded
        count, rows = len(scene), scene.structure.segment_count
        if not self._is_equal:  # else the structure of the whole memory stays
            self._follow(scene.structure)
        padded.segments[:rows] = scene.segments
        padded.segments[rows:] = OFF_CANVAS
        for name in ("color", "opacity"):
            getattr(padded, name)[:count] = getattr(scene, name)
        if padded.side_opacity is not None and scene.side_opacity is not None:
            padded.side_opacity.value[:count] = scene.side_opacity.value
        if padded.background is not scene.background:
            padded.background.copy_(scene.background)
        for own, values in zip(self.rows, held.rows, strict=True):
            own[:, : values.shape[1]] = values
        self.segment_age[:rows] = held.segment_age
        self.age[:count], self.age[-1:] = held.age[:count].clone(), held.age[-1:].clone()
        self.counts.fill_(count)
        return self._held(scene, scene.structure, scene.generation)

    def _held(self, scene: Scene, structure: Structure, generation: Tensor) -> Held:
        padded, count, rows = self.padded, structure.path_count, structure.segment_count
        color, opacity, background = padded.color[:count], padded.opacity[:count], padded.background
        found = replace(
            scene, segments=padded.segments[:rows], structure=structure, color=color, opacity=opacity,
            background=background, generation=generation,
            side_opacity=padded.side_opacity and SideOpacity(padded.side_opacity.value[:count]),
        )  # fmt: skip
        own_rows = zip(self.rows, (rows, count, count), strict=True)
        return Held(found, tuple(values[:, :n] for values, n in own_rows), self.segment_age[:rows], self.age)

    # Changes without a look of the host, which then does not know the number of segments

    def drop(self, count: int, cost: Tensor) -> Sources:
        """Take out the ``count`` paths of the lowest ``cost`` [N]; return what is where now."""
        sources = self._recycling.drop(count, cost, self.padded.structure, self.counts)
        self._move(sources, None)
        return sources

    def add(self, held: Held) -> Sources:
        """Put the paths of ``held``, all of as many segments, behind the others; there must be room for them."""
        count, rows = len(held.scene), held.scene.structure.segment_count
        sources = self._recycling.add(count, rows // count, self.padded.structure, self.counts)
        self._move(sources, held)
        return sources

    def _move(self, sources: Sources, new: Held | None) -> None:
        """Bring all values to their places; those of ``new`` paths follow the memory in ``sources``."""
        memory = _values(Held(self.padded, self.rows, self.segment_age, self.age))
        added = [None] * len(memory) if new is None else _values(new)
        blanks = [OFF_CANVAS, 0.0, 0.0] + [None] * (len(memory) - 3)
        for k, (values, more, blank) in enumerate(zip(memory, added, blanks, strict=True)):
            _gather(values, more, sources.segment if k < 3 else sources.path, blank)

    def found(self, scene: Scene, generation: Tensor) -> Held:
        """Return the paths here, of the kind of ``scene`` and with the ``generation`` [N]; the host reads R."""
        count, uniform_count = len(generation), self.padded.structure.uniform_count
        if uniform_count is not None:
            structure = Structure.uniform(count, uniform_count, self.counts.device)
        else:
            first, loops = (self._tables[name][: count + 1] for name in ("loop_first_segment", "path_first_loop"))
            structure = Structure(first.clone(), loops.clone(), check=False)
        return self._held(scene, structure, generation)

    def _follow(self, structure: Structure) -> None:
        """Write the tables of ``structure``, and those of the room behind it."""
        tables, count, rows = self._tables, structure.path_count, structure.segment_count
        tables["loop_first_segment"][:count] = structure.loop_first_segment[:-1]
        tables["loop_first_segment"][count:-1] = rows
        tables["loop_first_segment"][-1:] = self._segment_room
        rest = torch.arange(rows, self._segment_room, dtype=torch.int32, device=self.counts.device)
        behind = {
            "segment_path": torch.full_like(rest, self.path_room),
            "segment_next": rest.roll(-1),
            "segment_previous": rest.roll(1),
        }
        for name, values in behind.items():
            tables[name][:rows] = getattr(structure, name)
            tables[name][rows:] = values


def _values(held: Held) -> list[Tensor]:
    """Return the values of ``held`` by rows: three of segments, and then those of paths."""
    scene, planes = held.scene, [values.transpose(0, 1) for values in held.rows]
    sides = [] if scene.side_opacity is None else [scene.side_opacity.value]
    return [scene.segments, held.segment_age, planes[0], *planes[1:], held.age, scene.color, scene.opacity, *sides]


def _gather(memory: Tensor, new: Tensor | None, source: Tensor, blank: float | None = None) -> None:
    """Bring rows of ``memory`` and of ``new`` to the front of ``memory``; beyond these ``source`` means ``blank``."""
    rows = [memory[: len(source)], *([] if new is None else [new])]
    if blank is not None:
        rows.append(torch.full_like(memory[:1], blank))
    memory[: len(source)] = torch.cat(rows)[source]


def is_plain(scene: Scene) -> bool:
    """Return whether every path of ``scene`` is one loop of curves with a flat fill."""
    structure = scene.structure
    groups = (scene.gradients, scene.strokes, scene.forms, scene.softness)
    more = (*groups, structure.is_line, structure.is_open)
    return all(each is None for each in more) and structure.loop_count == structure.path_count
