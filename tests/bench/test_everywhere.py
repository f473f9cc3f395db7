"""Programs that people open our files in next draw them as resvg does, and take their shapes and pens.

Programs are looked for in the system, and in the folder WARPVEC_PROGRAMS, which `bench/everywhere.py` can fill.
"""

from __future__ import annotations

import os
import shutil
import sys
from pathlib import Path

import pytest
from everywhere import decibels
from everywhere_files import FILES, SHARP, by_color
from everywhere_programs import MOST_USED, PROGRAMS, has_packages, is_there
from importers import IMPORTERS, file_for, imported, verdict, wanted

from warpvec.purposes.table import PURPOSES
from warpvec.purposes.texts import text_for

pytestmark = pytest.mark.slow

ENVIRONMENT = Path(os.environ.get("WARPVEC_PROGRAMS", sys.prefix))


@pytest.mark.longest_wait(600)
@pytest.mark.parametrize("name", MOST_USED)
def test_a_program_draws_our_files_as_resvg_does(name: str, tmp_path: Path) -> None:
    pytest.importorskip("pathops")
    if not is_there(name, ENVIRONMENT):
        pytest.skip(f"{name} is not installed")
    for title in SHARP:
        text = FILES[title]()
        made = text_for(text, PURPOSES[PROGRAMS[name].purpose]).text
        found = decibels(name, made, tmp_path, ENVIRONMENT, text)
        assert found is not None and found > 39.0, title  # Qt draws curved strokes in steps: 39.8


@pytest.mark.longest_wait(600)
@pytest.mark.parametrize("name", ["vpype", "svg2vectordrawable", "FontForge", "ezdxf"])
def test_a_program_imports_our_shapes(name: str, tmp_path: Path) -> None:
    pytest.importorskip("pathops")
    pytest.importorskip("shapely")
    importer, text = IMPORTERS[name], by_color()
    is_found = has_packages(importer.kind, importer.requirement, ENVIRONMENT)
    if not is_found or (name == "FontForge" and shutil.which("fontforge") is None):
        pytest.skip(f"{name} is not installed")
    found = imported(name, file_for(importer, text, tmp_path), tmp_path, ENVIRONMENT)
    assert set(verdict(found, wanted(text, importer.has_loops), importer).values()) <= {"right", "-"}
