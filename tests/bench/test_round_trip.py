"""Test the comparison of SVGs with what is left of them after they are read and written."""

from __future__ import annotations

import json
from pathlib import Path

import round_trip
from click.testing import CliRunner
from svg_files import square_file

MASK = '<mask id="m"><rect width="9" height="64" fill="#fff"/></mask>'
LOST = MASK + '<rect width="30" height="30" mask="url(#m)"/><text/>'


def test_the_table_names_what_is_lost(tmp_path: Path) -> None:
    (tmp_path / "kept.svg").write_text(square_file('<path d="M5 5h40v50z"/>', 'viewBox="0 0 64 37.5"'))
    (tmp_path / "lost.svg").write_text(square_file(LOST))
    (tmp_path / "void.svg").write_text("no svg")
    result = CliRunner().invoke(round_trip.main, [str(tmp_path), "--sizes", "32,128"])
    assert result.exit_code == 0, result.output
    assert "1 of 3 files have at least 45 dB" in result.output
    assert "- mask: in 1 of the others" in result.output
    kept, lost, void = json.loads(result.output.splitlines()[-1])["trips"]
    assert min(kept["decibels"]) > 60 and kept["segments"] == kept["original_segments"]
    assert lost["remarks"] == ["1 mask: left out", "1 text: left out"] and not lost["is_closer"]
    assert void["decibels"] == [] and void["remarks"][0].startswith("refused: ")
