"""Which segments make up each loop, and which loops each path."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import InitVar, dataclass
from functools import cached_property

import torch
from torch import Tensor

from warpvec.errors import InputError


@dataclass(frozen=True, eq=False)
class Structure:
    """R segments in L closed loops in N paths.

    The segments of a loop are consecutive rows, and the last one ends where the first one begins. The loops of a path
    are consecutive too. A loop that runs the other way inside another one is a hole (the non-zero rule).

    Attributes:
        loop_first_segment: first row of each loop [L + 1] (int32); the last entry is R.
        path_first_loop: first loop of each path [N + 1] (int32); the last entry is L.
        is_line: rows that are straight lines [R] (bool), whose handles lie at thirds; None if there are none.
        is_open: loops that are open lines [L] (bool), of which the last row is only the end; None if there are none.
            Only stroked paths have any.
        uniform_count: S if every path is one loop of S curved segments, else None. It saves reading device memory.
        check: whether to check the values, which reads device memory; False is for those that must be right.

    Raises:
        InputError: the arrays have other types or shapes, or do not divide the rows into ranges that are not empty.
    """

    loop_first_segment: Tensor
    path_first_loop: Tensor
    is_line: Tensor | None = None
    uniform_count: int | None = None
    is_open: Tensor | None = None
    check: InitVar[bool] = True

    def __post_init__(self, check: bool) -> None:
        if not check:
            return
        segments, loops, count = self.loop_first_segment, self.path_first_loop, self.uniform_count
        _check_starts("loop_first_segment", segments)
        _check_starts("path_first_loop", loops)
        if int(loops[-1]) != len(segments) - 1:
            rule = f"must end with the number of loops, {len(segments) - 1}"
            raise InputError("path_first_loop", rule, str(int(loops[-1])), "check its last entry")
        _check_mask("is_line", self.is_line, int(segments[-1]), "segment")
        _check_mask("is_open", self.is_open, len(segments) - 1, "loop")
        if count is not None and not bool((segments.diff() == count).all() & (loops.diff() == 1).all()):
            raise InputError("uniform_count", "must be that of the one loop of every path", str(count), "leave it out")

    @staticmethod
    def uniform(path_count: int, segment_count: int, device: torch.device | str = "cpu") -> Structure:
        """Return the structure of paths of one loop each, all of ``segment_count`` curved segments."""
        loops = torch.arange(path_count + 1, dtype=torch.int32, device=device)
        return Structure(loops * segment_count, loops, None, segment_count, check=False)

    @staticmethod
    def of_loops(
        segment_counts: Sequence[Sequence[int]], is_line: Tensor | None = None, is_open: Tensor | None = None
    ) -> Structure:
        """Return the structure of paths whose loops have these numbers of segments.

        Raises:
            InputError: a path has no loop, a loop has no segment, or a mask has another length.
        """
        counts = [count for path in segment_counts for count in path]
        if not all(segment_counts) or min(counts, default=1) < 1:
            raise InputError("structure", "must have a loop in each path and a segment in each loop", str(counts))
        _check_length("is_line", is_line, sum(counts), "segment")
        _check_length("is_open", is_open, len(counts), "loop")
        loops = _starts(torch.tensor([len(path) for path in segment_counts], dtype=torch.int64))
        return Structure(_starts(torch.tensor(counts, dtype=torch.int64)), loops, is_line, None, is_open, check=False)

    @property
    def path_count(self) -> int:
        """Number of paths."""
        return len(self.path_first_loop) - 1

    @property
    def loop_count(self) -> int:
        """Number of loops."""
        return len(self.loop_first_segment) - 1

    @property
    def lines(self) -> Tensor:
        """Which rows are straight lines [R] (bool)."""
        if self.is_line is not None:
            return self.is_line
        return torch.zeros(self.segment_count, dtype=torch.bool, device=self.loop_first_segment.device)

    @property
    def end_rows(self) -> Tensor:
        """Which rows are only the end of an open line [R] (bool)."""
        found = torch.zeros(self.segment_count, dtype=torch.bool, device=self.loop_first_segment.device)
        if self.is_open is not None:
            found[self.loop_first_segment[1:].long()[self.is_open] - 1] = True
        return found

    @property
    def line_ends(self) -> Tensor:
        """Which nodes are the start or the end of an open line [R] (bool)."""
        ends = self.end_rows
        return ends | ends[self.segment_previous.long()]

    @property
    def segment_count(self) -> int:
        """Number of segments of all paths, R."""
        # torch.compile cannot trace a cached property before it has a value.
        return self._last_segment if self.uniform_count is None else self.path_count * self.uniform_count

    @cached_property
    def _last_segment(self) -> int:
        return int(self.loop_first_segment[-1])

    @cached_property
    def path_first_segment(self) -> Tensor:
        """First row of each path [N + 1] (int32); the last entry is R."""
        return self.loop_first_segment[self.path_first_loop.long()]

    @cached_property
    def segment_path(self) -> Tensor:
        """Path of each row [R] (int32)."""
        paths = torch.arange(self.path_count, dtype=torch.int32, device=self.path_first_loop.device)
        return paths.repeat_interleave(self.path_first_segment.diff().long(), output_size=self.segment_count)

    @cached_property
    def segment_next(self) -> Tensor:
        """Row that follows each row in its loop [R] (int32)."""
        following = torch.arange(1, self.segment_count + 1, dtype=torch.int32, device=self.loop_first_segment.device)
        following[self.loop_first_segment[1:].long() - 1] = self.loop_first_segment[:-1]
        return following

    @cached_property
    def segment_previous(self) -> Tensor:
        """Row that each row follows in its loop [R] (int32)."""
        previous = torch.arange(-1, self.segment_count - 1, dtype=torch.int32, device=self.loop_first_segment.device)
        previous[self.loop_first_segment[:-1].long()] = self.loop_first_segment[1:] - 1
        return previous

    def to(self, device: torch.device | str) -> Structure:
        """Return the structure in the memory of ``device``."""
        if self.loop_first_segment.device == torch.device(device):
            return self
        is_line, is_open = (None if mask is None else mask.to(device) for mask in (self.is_line, self.is_open))
        arrays = (self.loop_first_segment.to(device), self.path_first_loop.to(device), is_line)
        return Structure(*arrays, self.uniform_count, is_open, check=False)._of(self.segment_count)

    def select(self, rows: Tensor) -> tuple[Structure, Tensor]:
        """Return the structure of the paths ``rows`` (indices or a mask [N]), in that order, and their segments' rows.

        The rows of the segments [R'] are int64.
        """
        rows = rows.nonzero().flatten() if rows.dtype == torch.bool else rows
        if self.uniform_count is not None:
            structure = Structure.uniform(len(rows), self.uniform_count, self.loop_first_segment.device)
            first = rows[:, None] * self.uniform_count
            return structure, (first + torch.arange(self.uniform_count, device=rows.device)).flatten()
        loop_counts = self.path_first_loop.diff().long()[rows]
        loops = _ranges(self.path_first_loop[:-1].long()[rows], loop_counts)
        segment_counts = self.loop_first_segment.diff().long()[loops]
        segments = _ranges(self.loop_first_segment[:-1].long()[loops], segment_counts)
        is_line, is_open = _chosen(self.is_line, segments), _chosen(self.is_open, loops)
        starts = (_starts(segment_counts), _starts(loop_counts))
        return Structure(*starts, is_line, None, is_open, check=False)._of(len(segments)), segments

    def prefix(self, count: int) -> Structure:
        """Return the structure of the first ``count`` paths; equal counts give the same object."""
        if count not in self._prefixes:
            rows = torch.arange(count, device=self.loop_first_segment.device)
            self._prefixes[count] = self.select(rows)[0]
        return self._prefixes[count]

    @cached_property
    def _prefixes(self) -> dict[int, Structure]:
        return {}

    def joined(self, other: Structure) -> Structure:
        """Return the structure of these paths and, after them, those of ``other``."""
        device = self.loop_first_segment.device
        if self.uniform_count is not None and self.uniform_count == other.uniform_count:
            return Structure.uniform(self.path_count + other.path_count, self.uniform_count, device)
        segments = torch.cat([self.loop_first_segment, other.loop_first_segment[1:] + self.segment_count])
        loops = torch.cat([self.path_first_loop, other.path_first_loop[1:] + self.loop_count])
        is_line = _both(self.is_line, other.is_line, (self.segment_count, other.segment_count))
        is_open = _both(self.is_open, other.is_open, (self.loop_count, other.loop_count))
        joined = Structure(segments, loops, is_line, None, is_open, check=False)
        return joined._of(self.segment_count + other.segment_count)

    def _of(self, segment_count: int) -> Structure:
        """Return this structure, whose number of segments need then not be read from a device."""
        vars(self)["_last_segment"] = segment_count
        return self


def _check_starts(name: str, first: Tensor) -> None:
    """Refuse ``first`` unless it holds the starts of consecutive ranges, and the end of the last."""
    if first.dtype != torch.int32 or first.dim() != 1 or not len(first):
        found = f"{list(first.shape)} of {str(first.dtype).removeprefix('torch.')}"
        raise InputError(name, "must be a list of int32 with at least one entry", found, "convert it with .int()")
    if int(first[0]) != 0 or not bool((first.diff() > 0).all()):
        listed = ", ".join(map(str, first[:5].tolist())) + (", ..." if len(first) > 5 else "")
        raise InputError(name, "must begin with 0 and increase", listed, "check the lengths of its ranges")


def _check_mask(name: str, mask: Tensor | None, count: int, owner: str) -> None:
    if mask is not None and (mask.dtype != torch.bool or tuple(mask.shape) != (count,)):
        found = f"{list(mask.shape)} of {str(mask.dtype).removeprefix('torch.')}"
        raise InputError(name, f"must be {count} entries of bool", found, f"make it one entry a {owner}")


def _check_length(name: str, mask: Tensor | None, count: int, owner: str) -> None:
    if mask is not None and len(mask) != count:
        found = f"{len(mask)} for {count} {owner}s"
        raise InputError(name, f"must have an entry for each {owner}", found, "check its length")


def _chosen(mask: Tensor | None, rows: Tensor) -> Tensor | None:
    return None if mask is None else mask[rows]


def _both(first: Tensor | None, second: Tensor | None, counts: tuple[int, int]) -> Tensor | None:
    """Return two masks of ``counts`` entries as one; None stands for a mask of False."""
    if first is None and second is None:
        return None
    device = next(mask.device for mask in (first, second) if mask is not None)
    masks = zip((first, second), counts, strict=True)
    empty = (torch.zeros(n, dtype=torch.bool, device=device) if mask is None else mask for mask, n in masks)
    return torch.cat(list(empty))


def _starts(counts: Tensor) -> Tensor:
    """Return the start of each of consecutive ranges of ``counts`` [K] entries, and the end of the last (int32)."""
    return torch.nn.functional.pad(counts.cumsum(0), (1, 0)).int()


def _ranges(first: Tensor, counts: Tensor) -> Tensor:
    """Return first[0], first[0] + 1, ... for counts[0] entries, then the same for the next (int64)."""
    ends = counts.cumsum(0)
    total = int(ends[-1]) if len(ends) else 0
    shift = (first - ends + counts).repeat_interleave(counts, output_size=total)
    return torch.arange(total, device=first.device) + shift
