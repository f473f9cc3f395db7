"""The records of a batch: one line per photo, in JSON to continue from and in CSV for people.

In the CSV, a text that a spreadsheet would take for a formula has an apostrophe before it, and line breaks and other
control characters are escaped. All texts are in quotes, so that a text with a semicolon stays in its cell.

While a batch runs, each photo that ends adds a line to both files. The last line of a photo counts; an incomplete line
at the end, left by a batch that was killed, does not. When a batch begins and when it ends, both files are written
anew with one line per photo, so they agree whatever happened before.
"""

from __future__ import annotations

import csv
import io
import json
import re
import time
from dataclasses import asdict, dataclass, fields
from types import NoneType
from typing import Any

from warpvec.batch.folders import Folder
from warpvec.checks import in_one_line
from warpvec.errors import InputError

JSON_NAME, CSV_NAME = "batch.jsonl", "batch.csv"

# Where lines cannot be appended, shortest time between two rewrites. A batch that is killed loses at most as much.
_REWRITE_SECONDS = 5.0

_FORMULA_STARTS = ("=", "+", "-", "@")
"""A spreadsheet takes a text for a formula if it begins with one of these."""

# All but the characters in which Python keeps the bytes of a name that is no text.
_TEXT = re.compile("[^\udc80-\udcff]+")


@dataclass(frozen=True, kw_only=True)
class Record:
    """The end of the work on a photo.

    All fields except ``error`` and ``attempts`` describe the existing file, which may be from an earlier batch.

    Attributes:
        input, output: names in the two folders.
        mode: how the photo was vectorized: "photo", "flat" or "mono".
        curves: number of paths.
        bytes: size of the file.
        psnr, ssim: quality of the drawing's SVG as resvg draws it; psnr in dB, None if the drawing has no error.
        seconds: time from reading the photo until the file was written.
        losses: what of the photo the drawing could not keep, and what the file draws by other means, in words; None
            from earlier versions.
        error: the reason in one line why the last batch made no file; None if it made one.
        attempts: number of attempts of the last batch.
        key: digest of the photo and the settings; None if there is no file.
        settings: those of the fit, and the background; if there is no file, those that failed.
    """

    input: str
    output: str
    mode: str | None = None
    curves: int | None = None
    bytes: int | None = None
    psnr: float | None = None
    ssim: float | None = None
    seconds: float | None = None
    losses: str | None = None
    error: str | None = None
    attempts: int = 1
    key: str | None = None
    settings: dict[str, Any]


_TYPES: dict[str, set[type]] = {
    "input": {str}, "output": {str}, "mode": {str, NoneType}, "curves": {int, NoneType}, "bytes": {int, NoneType},
    "psnr": {float, int, NoneType}, "ssim": {float, int, NoneType}, "seconds": {float, int, NoneType},
    "losses": {str, NoneType}, "error": {str, NoneType}, "attempts": {int}, "key": {str, NoneType}, "settings": {dict},
}  # fmt: skip
"""The types that the fields of a record may have in JSON."""

_COLUMNS = tuple(field.name for field in fields(Record) if field.name != "settings")


class Journal:
    """The records in ``folder``, which nobody else may write until :meth:`close`."""

    def __init__(self, folder: Folder) -> None:
        self._folder = folder
        text = folder.read(JSON_NAME).decode(errors="replace") if folder.exists(JSON_NAME) else ""
        # After the last line break there can only be an incomplete line.
        records = [_parse(line, number) for number, line in enumerate(text.split("\n")[:-1], 1)]
        self._records: dict[tuple[str, str], Record] = {}
        self._inputs: dict[str, set[str]] = {}  # output -> the photos with a record of it
        for record in records:
            self._put(record)
        self._written = -float("inf")
        if text:
            self._rewrite()

    def get(self, input: str, output: str) -> Record | None:
        """Return the last record of a photo and its file."""
        return self._records.get((input, output))

    def add(self, record: Record) -> None:
        """Keep ``record``. It is on the disk when this returns, if lines can be appended."""
        self._put(record)
        if self._folder.can_append:
            header = [] if self._folder.exists(CSV_NAME) else [_COLUMNS]
            self._folder.append(JSON_NAME, _json_line(record).encode())
            self._folder.append(CSV_NAME, _csv([*header, _csv_cells(record)]))
        elif time.monotonic() - self._written > _REWRITE_SECONDS:
            self._rewrite()

    def close(self) -> None:
        """Write both files with one line per photo, sorted by name."""
        if self._records:
            self._rewrite()

    def _put(self, record: Record) -> None:
        inputs = self._inputs.setdefault(record.output, set())
        if record.error is None:  # a new file, which replaces that of any other photo
            for other in inputs - {record.input}:
                del self._records[other, record.output]
            inputs.clear()
        inputs.add(record.input)
        self._records[record.input, record.output] = record

    def _rewrite(self) -> None:
        records = sorted(self._records.values(), key=lambda record: record.input)
        self._folder.write(JSON_NAME, "".join(map(_json_line, records)).encode())
        self._folder.write(CSV_NAME, _csv([_COLUMNS, *map(_csv_cells, records)]))
        self._written = time.monotonic()


def _parse(line: str, number: int) -> Record:
    try:
        if "\ufffd" in line:  # `_json_line` writes ASCII only
            raise ValueError("bytes that are no text")
        record = Record(**json.loads(line))
        wrong = next((name for name, types in _TYPES.items() if type(getattr(record, name)) not in types), None)
        if wrong is not None:
            raise TypeError(f"{wrong} of a wrong type")
        _json_line(record)  # numbers that are not finite, and objects too deep, cannot be written again
        return record
    except (TypeError, ValueError, RecursionError) as error:
        value = f"another in line {number} ({error})"
        remedy = "move the file away, or choose another folder"
        raise InputError("OUT_DIR", f"must have records of this version in {JSON_NAME}", value, remedy) from error


def _json_line(record: Record) -> str:
    return json.dumps(asdict(record), allow_nan=False) + "\n"


def _csv_cells(record: Record) -> list[Any]:
    return [_as_text(getattr(record, name)) for name in _COLUMNS]


def _as_text(cell: object) -> Any:
    """Keep a text in one line, and a spreadsheet from taking it, such as the name "=1+1.png", for a formula."""
    if not isinstance(cell, str):
        return cell
    cell = _TEXT.sub(lambda found: in_one_line(found[0]), cell)
    return f"'{cell}" if cell.startswith(_FORMULA_STARTS) else cell


def _csv(rows: list[Any]) -> bytes:
    """Return the lines of ``rows``. File names that are not valid text are the bytes they were read from."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n", quoting=csv.QUOTE_NONNUMERIC).writerows(rows)
    return text.getvalue().encode(errors="surrogateescape")
