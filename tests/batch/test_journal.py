"""Records of a batch: complete lines whatever happens, one for each photo, the same in both files."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from pathlib import Path

import pytest

from warpvec.batch.folders import LocalFolder, open_folder
from warpvec.batch.journal import CSV_NAME, JSON_NAME, Journal, Record
from warpvec.errors import InputError

SETTINGS = {"curves": 8, "time_budget": None, "lr_points": 0.012}
DONE = Record(
    input="b/é.png", output="b/é.svg", curves=8, bytes=1234, psnr=27.5, ssim=0.75, seconds=1.5, attempts=2, key="0f",
    settings=SETTINGS,
)  # fmt: skip
FAILED = Record(input="a.png", output="a.svg", error='no "image", two\nlines', settings=SETTINGS)


def _lines(folder: Path) -> list[dict[str, object]]:
    return [json.loads(line) for line in (folder / JSON_NAME).read_text().splitlines()]


def _cells(folder: Path) -> list[dict[str, str]]:
    with (folder / CSV_NAME).open(newline="", encoding="utf-8", errors="surrogateescape") as file:
        return list(csv.DictReader(file))


def test_each_record_is_a_line_at_once_and_read_again(tmp_path: Path) -> None:
    journal = Journal(LocalFolder(tmp_path))
    for record in (DONE, FAILED):
        journal.add(record)
    assert [line["input"] for line in _lines(tmp_path)] == ["b/é.png", "a.png"]
    first, second = _cells(tmp_path)
    assert (first["psnr"], first["bytes"], first["attempts"], first["error"]) == ("27.5", "1234", "2", "")
    assert "settings" not in first
    assert (second["psnr"], second["error"]) == ("", FAILED.error.replace("\n", r"\n"))
    again = Journal(LocalFolder(tmp_path))
    assert (again.get("b/é.png", "b/é.svg"), again.get("a.png", "a.svg")) == (DONE, FAILED)
    assert again.get("c.png", "a.svg") is None


def test_the_last_line_of_a_photo_counts_and_stays_alone(tmp_path: Path) -> None:
    journal = Journal(LocalFolder(tmp_path))
    mended = Record(input="a.png", output="a.svg", curves=1, key="1", settings=SETTINGS)
    for record in (DONE, FAILED, mended):
        journal.add(record)
    assert len(_lines(tmp_path)) == len(_cells(tmp_path)) == 3
    journal.close()
    assert [line["input"] for line in _lines(tmp_path)] == ["a.png", "b/é.png"]
    assert [line["error"] for line in _cells(tmp_path)] == ["", ""]


@pytest.mark.parametrize("cut", [1, 20, 200])
def test_half_a_line_of_a_killed_batch_is_cut_off(tmp_path: Path, cut: int) -> None:
    journal = Journal(LocalFolder(tmp_path))
    for record in (DONE, FAILED):
        journal.add(record)
    for name in (JSON_NAME, CSV_NAME):
        path = tmp_path / name
        path.write_bytes(path.read_bytes()[:-cut])
    again = Journal(LocalFolder(tmp_path))
    assert (again.get("b/é.png", "b/é.svg"), again.get("a.png", "a.svg")) == (DONE, None)
    again.add(FAILED)
    assert [line["input"] for line in _lines(tmp_path)] == [line["input"] for line in _cells(tmp_path)]
    assert [line["input"] for line in _lines(tmp_path)] == ["b/é.png", "a.png"]


def test_a_line_that_only_one_file_has_comes_back(tmp_path: Path) -> None:
    journal = Journal(LocalFolder(tmp_path))
    journal.add(DONE)
    (tmp_path / CSV_NAME).unlink()
    Journal(LocalFolder(tmp_path))
    assert [line["input"] for line in _cells(tmp_path)] == ["b/é.png"]


@pytest.mark.parametrize("start", ["=", "+", "-", "@"])
def test_no_text_of_the_csv_is_a_formula(tmp_path: Path, start: str) -> None:
    name = f"{start}1+1.png"
    journal = Journal(LocalFolder(tmp_path))
    journal.add(replace(DONE, input=name, psnr=-1.5))
    (cells,) = _cells(tmp_path)
    assert (cells["input"], cells["psnr"]) == (f"'{name}", "-1.5")
    journal.close()
    assert _cells(tmp_path) == [cells]
    assert Journal(LocalFolder(tmp_path)).get(name, DONE.output) is not None


@pytest.mark.parametrize(("name", "cell"), [("a;=1+1.png", "a;=1+1.png"), ("\t=1\x1b[31m.png", r"\t=1\x1b[31m.png")])
def test_a_text_is_one_quoted_cell_without_control_characters(tmp_path: Path, name: str, cell: str) -> None:
    Journal(LocalFolder(tmp_path)).add(replace(DONE, input=name))
    assert f'\n"{cell}",' in (tmp_path / CSV_NAME).read_text()


def test_a_name_with_line_breaks_stays_in_its_line(tmp_path: Path) -> None:
    Journal(LocalFolder(tmp_path)).add(replace(DONE, input="a\r\nb.png"))
    (cells,) = _cells(tmp_path)
    assert cells["input"] == r"a\r\nb.png" and len((tmp_path / CSV_NAME).read_bytes().splitlines()) == 2


def test_names_that_are_no_text_are_kept(tmp_path: Path) -> None:
    name = b"\xff.png".decode(errors="surrogateescape")
    Journal(LocalFolder(tmp_path)).add(Record(input=name, output="x.svg", settings={}))
    record = Journal(LocalFolder(tmp_path)).get(name, "x.svg")
    assert record is not None
    assert record.input == _cells(tmp_path)[0]["input"] == name


@pytest.mark.parametrize(
    "line",
    [
        "{}", "[1]", "nonsense", '{"input": "a", "output": "b", "settings": {}, "more": 1}', 10_000 * "[",
        '{"input": "a", "output": [], "settings": {}}', '{"input": 1, "output": "b", "settings": {}}',
        '{"input": "a", "output": "b", "settings": {}, "curves": true}',
        '{"input": "a", "output": "b", "settings": {}, "psnr": 1e999}',
        '{"input": "a", "output": "b", "settings": {"x": NaN}}',
    ],
)  # fmt: skip
def test_records_of_another_version_are_refused(tmp_path: Path, line: str) -> None:
    (tmp_path / JSON_NAME).write_text(line + "\n")
    with pytest.raises(InputError, match=f"{JSON_NAME}, got another in line 1"):
        Journal(LocalFolder(tmp_path))
    assert (tmp_path / JSON_NAME).read_text() == line + "\n"


def test_where_lines_cannot_be_added_the_files_are_written_whole(tmp_path: Path) -> None:
    pytest.importorskip("fsspec", reason="the extra cluster is not installed")
    journal = Journal(open_folder(f"file://{tmp_path}", "OUT_DIR"))
    journal.add(DONE)
    assert len(_lines(tmp_path)) == 1
    journal.add(FAILED)  # too soon after the first
    journal.close()
    assert len(_lines(tmp_path)) == len(_cells(tmp_path)) == 2
