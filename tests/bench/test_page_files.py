"""The bench of the page's files sees when one differs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import page_files
import pytest
from click.testing import CliRunner
from PIL import Image

from warpvec.writers.saved import Saved

pytestmark = pytest.mark.slow


def test_files_are_the_same_until_one_is_changed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pixels = np.full((24, 32, 3), 255, np.uint8)
    pixels[6:18, 8:24] = (200, 40, 40)
    source = tmp_path / "logo.png"
    Image.fromarray(pixels).save(source)
    arguments = [str(source), "--formats", "svg,png"]
    assert "| same | same |" in CliRunner().invoke(page_files.main, arguments).stdout
    made = page_files.encode

    def changed(text: str, kind: str, *rest: object, **more: object) -> Saved:
        data, losses = made(text, kind, *rest, **more)  # type: ignore[arg-type]
        return Saved(data + b" ", losses) if kind == "svg" else Saved(data, ["for print: bands"])

    monkeypatch.setattr(page_files, "encode", changed)
    assert "| other bytes | other warnings |" in CliRunner().invoke(page_files.main, arguments).stdout
