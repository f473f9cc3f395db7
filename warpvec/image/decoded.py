"""State what was read of a picture file, and which of its pages."""

from __future__ import annotations

from typing import Any, NamedTuple

from numpy.typing import NDArray

from warpvec.errors import InputError


class Decoded(NamedTuple):
    """Samples of a picture file, and what else it says.

    Attributes:
        samples: an array that `warpvec.image.read.read_image` takes.
        unread: what of the file was left out, such as "all but page 2 of 3"; None for nothing.
        meters: width of what the picture shows in the world; None if the file does not state it.
    """

    samples: NDArray[Any]
    unread: str | None = None
    meters: float | None = None


def page_index(page: int | None, count: int) -> tuple[int, str | None]:
    """Return the index of a ``page``, which counts from 1, and what is left out, in words.

    Args:
        page: None for the first.
        count: pages of the file.

    Raises:
        InputError: the file does not have this page.
    """
    page = 1 if page is None else page
    if page > count:
        raise InputError("page", f"must be at most {count}, the pages of the file", str(page), "give another")
    return page - 1, f"all but page {page} of {count}" if count > 1 else None


def refuse_page(page: int | None) -> None:
    """Raise InputError if a ``page`` is asked for of what has no pages."""
    if page is not None:
        raise InputError(
            "page", "must be left out for a picture that is no TIFF or PDF file", str(page), "leave it out"
        )
