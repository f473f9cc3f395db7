"""Compare the files that the page of `warpvec app` saves with those of `warpvec run`, and time its first frame.

A row tells for each picture after how many seconds of the processor its worker has the first frame, and for each format
whether the bytes and the warnings are the same.

    python bench/page_files.py PICTURE.png ... [--formats svg,png,pdf,dxf]
"""

from __future__ import annotations

import tempfile
import time
from pathlib import Path
from typing import Any

import click
from click.testing import CliRunner
from harness import markdown_table

from warpvec.app.export import encode
from warpvec.app.mailbox import Mailbox
from warpvec.app.messages import FitJob, Report
from warpvec.app.settings import FitSettings
from warpvec.app.work import Worker
from warpvec.cli.main import main as warpvec
from warpvec.image.read import read_image


class IdleMailbox(Mailbox):
    """A mailbox without messages."""

    def __init__(self) -> None:
        self._stops, self._number = {}, 0


class Page:
    """What a page gets of a picture that is dropped on it: the drawing, and the seconds until its first frame."""

    def __init__(self) -> None:
        self._start, self.first = 0.0, 0.0
        self._worker = Worker(IdleMailbox(), self._note, None)
        self._worker.warm_up()

    def _note(self, report: Report) -> None:
        if report.kind == "frame" and not self.first:
            self.first = time.process_time() - self._start

    def draw(self, path: Path) -> dict[str, Any]:
        """Return the facts of the drawing of the picture ``path``."""
        self._start, self.first = time.process_time(), 0.0
        return self._worker.do(FitJob(1, path.read_bytes(), path.stem, FitSettings({})))


def compared(path: Path, facts: dict[str, Any], kind: str, folder: Path) -> str:
    """Return "same", or what differs between the files of the page and of the command."""
    out, text, pixels = folder / f"{path.stem}.{kind}", facts["svg"], read_image(path)
    done = CliRunner().invoke(warpvec, ["run", str(path), str(out)])
    if done.exit_code:
        return done.stderr.strip().splitlines()[-1][:80]
    width = pixels.shape[1] if kind == "png" else None
    made = encode(text, kind, width, name=path.stem, transparent='<rect id="background"' not in text)
    kept = [f"not kept: {'; '.join(facts['not_kept'])}"] if facts["not_kept"] else []
    said = [line for line in done.stdout.splitlines() if line.startswith(("for ", "not kept"))]
    differing = [] if made.data == out.read_bytes() else ["other bytes"]
    return ", ".join(differing + ([] if sorted(said) == sorted(kept + made.losses) else ["other warnings"])) or "same"


@click.command()
@click.argument("pictures", nargs=-1, required=True, type=click.Path(exists=True, path_type=Path))
@click.option("--formats", default="svg,png,pdf,dxf", help="Formats that are compared.")
def main(pictures: tuple[Path, ...], formats: str) -> None:
    """Compare the files of the page with those of the command."""
    page, kinds, rows = Page(), formats.split(","), []
    with tempfile.TemporaryDirectory() as folder:
        for path in pictures:
            facts = page.draw(path)
            found = [compared(path, facts, kind, Path(folder)) for kind in kinds]
            rows.append([path.name, facts["mode"], facts["paths"], f"{page.first:.2f}", *found])
            click.echo(" ".join(map(str, rows[-1])), err=True)
    print(markdown_table(["picture", "mode", "paths", "first frame, CPU s", *kinds], rows))


if __name__ == "__main__":
    main()
