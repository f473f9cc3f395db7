"""What a batch remembers: a line for each image, in JSON to go on from and in CSV for people.

While a batch runs, each image that ends adds a line to both files. The last line of an image counts, half a line at
the end, of a batch that was killed, does not. When a batch begins and ends both files are written anew, with one line
for each image; so they agree, whatever happened in between.
"""

from __future__ import annotations

import csv
import io
import json
import time
from dataclasses import asdict, dataclass, fields
from typing import Any

from warpvec.batch.folders import Folder
from warpvec.errors import InputError

JSON_NAME, CSV_NAME = "batch.jsonl", "batch.csv"

# Where lines cannot be added, the files are written anew, at most so often; a batch that is killed loses as much.
_REWRITE_SECONDS = 5.0


@dataclass(frozen=True, kw_only=True)
class Record:
    """How an image ended.

    Attributes:
        input, output: names in the two folders.
        curves, bytes: of the SVG text. These and the rest, but for error and attempts, are of the file that is there.
        psnr, ssim: of the file as resvg draws it; psnr in dB, None where it has no error.
        seconds: from reading the photo to the file that is written.
        error: why the last batch made no file, in one line, be there one from before or none; None if it made one.
        attempts: how many times the last batch began the image.
        key: digest of the photo and the settings; None where there is no file.
        settings: those of the fit, and the background; where there is no file, those that failed.
    """

    input: str
    output: str
    curves: int | None = None
    bytes: int | None = None
    psnr: float | None = None
    ssim: float | None = None
    seconds: float | None = None
    error: str | None = None
    attempts: int = 1
    key: str | None = None
    settings: dict[str, Any]


_FIELDS = tuple(field.name for field in fields(Record))


class Journal:
    """The records in ``folder``, which is nobody else's until :meth:`close`."""

    def __init__(self, folder: Folder) -> None:
        self._folder = folder
        text = folder.read(JSON_NAME).decode() if folder.exists(JSON_NAME) else ""
        # What follows the last line break is half a line.
        records = [_parse(line, number) for number, line in enumerate(text.split("\n")[:-1], 1)]
        self._records = {record.output: record for record in records}
        self._written = -float("inf")
        if text:
            self._rewrite()

    def get(self, output: str) -> Record | None:
        """The last record of a file."""
        return self._records.get(output)

    def add(self, record: Record) -> None:
        """Keep ``record``, on the disk when this returns."""
        self._records[record.output] = record
        if self._folder.appends:
            header = "" if self._folder.exists(CSV_NAME) else _csv_text([_FIELDS])
            self._folder.append(JSON_NAME, _json_line(record).encode())
            self._folder.append(CSV_NAME, _encode_csv(header + _csv_text([_csv_cells(record)])))
        elif time.monotonic() - self._written > _REWRITE_SECONDS:
            self._rewrite()

    def close(self) -> None:
        """Leave one line for each image, in the order of their names."""
        if self._records:
            self._rewrite()

    def _rewrite(self) -> None:
        records = sorted(self._records.values(), key=lambda record: record.input)
        self._folder.write(JSON_NAME, "".join(map(_json_line, records)).encode())
        self._folder.write(CSV_NAME, _encode_csv(_csv_text([_FIELDS, *map(_csv_cells, records)])))
        self._written = time.monotonic()


def _parse(line: str, number: int) -> Record:
    try:
        return Record(**json.loads(line))
    except (TypeError, ValueError) as error:
        rule = f"OUT_DIR must have records of this version in {JSON_NAME}, got another in line {number}"
        raise InputError(f"{rule} ({error}); move the file away, or choose another folder") from error


def _json_line(record: Record) -> str:
    return json.dumps(asdict(record), allow_nan=False) + "\n"


def _csv_cells(record: Record) -> list[Any]:
    return [*(getattr(record, name) for name in _FIELDS[:-1]), json.dumps(record.settings)]


def _csv_text(lines: list[Any]) -> str:
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(lines)
    return text.getvalue()


def _encode_csv(text: str) -> bytes:
    """File names need not be text: what is none comes out as it went in."""
    return text.encode(errors="surrogateescape")
