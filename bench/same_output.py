"""Check that a change to the code leaves every drawing and every JSON report the same.

Record the outputs before the change, and compare them after it, on the same machine:

    python bench/same_output.py record before.json
    python bench/same_output.py compare before.json

Some fifty short commands and a few jobs of the page cover both renderers, every policy, flat art, black and white art,
transparency, palettes, levels, goals, resume, refine, placeholders and batch. Together they take five minutes. A
drawing must have the same bytes. The settings in metadata and
the JSON reports must have the same keys and values, except for times. If the change removes a setting on purpose, name
it with ``--without``, and also ``bytes``, ``gzip_bytes`` and ``prefix_bytes``, because the metadata get shorter. If it
changes the output of a command on purpose, name the command with ``--skip``. If a command ends with another exit code
than it should, the comparison stops there, because two equal failures would count as equal outputs.
"""

from __future__ import annotations

import argparse
import gzip
import hashlib
import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from PIL import Image, ImageDraw

_PHOTO = ["--mode", "photo"]
_SHORT = ["--iterations", "120", "--curves", "48", *_PHOTO, "--json"]

COMMANDS: dict[str, list[str]] = {
    "exact": ["run", "photo.png", "exact.svg", *_SHORT],
    "seed": ["run", "photo.png", "seed.svg", *_SHORT, "--seed", "7", "--segments", "3", "--precision", "1"],
    "splat": ["run", "photo.png", "splat.svg", "--preset", "paper", "--curves", "12", "--iterations", "12", "--samples",
              "8", "--lines", "4", "--inflation-gap", "3", "--json"],
    "splat cubics": ["run", "photo.png", "splat-cubics.svg", "--renderer", "splat", "--curves", "20", "--iterations",
                     "30", "--samples", "8", "--lines", "4", "--covariance-gradient", "--json"],
    "replacement": ["run", "photo.png", "replacement.svg", "--preset", "bezier-splatting", "--curves", "16",
                    "--iterations", "60", "--samples", "8", "--lines", "4", "--replace-gap", "5", "--json"],
    "flat": ["run", "photo.png", "flat.svg", *_SHORT, "--flat", "--lr-decay", "steps", "--backdrop", "white"],
    "area order": ["run", "photo.png", "area.svg", *_SHORT, "--z-order", "area"],
    "levels": ["run", "photo.png", "levels.svg", *_SHORT, "--lod"],
    "transparent": ["run", "logo.png", "logo.svg", *_SHORT],
    "background": ["run", "logo.png", "logo-white.svg", *_SHORT, "--background", "white"],
    "palette": ["run", "photo.png", "palette.svg", *_SHORT, "--palette", "#123,#c84,#fff"],
    "colors": ["run", "photo.png", "colors.svg", *_SHORT, "--colors", "6", "--opacity", "free"],
    "opaque": ["run", "photo.png", "opaque.svg", *_SHORT, "--opaque", "--min-area", "30"],
    "bytes": ["run", "photo.png", "bytes.svg", "--iterations", "120", *_PHOTO, "--max-bytes", "6000", "--json"],
    "gzip bytes": ["run", "photo.png", "bytes.svgz", "--iterations", "120", *_PHOTO, "--max-bytes", "2k", "--json"],
    "checkpoint": ["run", "photo.png", "checkpointed.svg", *_SHORT, "--checkpoint", "fit.npz", "--every", "70"],
    "resume": ["run", "photo.png", "resumed.svg", "--resume", "fit.npz", "--json"],
    "settings": ["run", "photo.png", "settings.svg", *_SHORT, "--write-config", "settings.toml", "--fit-size", "100"],
    "frames": ["run", "photo.png", "frames.svg", *_SHORT, "--save-frames", "frames", "--every", "60", "--report",
               "frames.html"],
    "flat art": ["run", "logo.png", "flat-art.svg", "--mode", "flat", "--size", "30mm", "--json"],
    "mono": ["run", "logo.png", "mono.svg", "--mode", "mono", "--background", "white", "--json"],
    "refine": ["refine", "photo.png", "refined.svg", "--from", "exact.svg", "--curves", "60", "--iterations", "80",
               "--json"],
    "refine foreign": ["refine", "photo.png", "foreign-refined.svg", "--from", "foreign.svg", "--iterations", "40",
                       "--json"],
    "gradients": ["run", "photo.png", "gradients.svg", *_SHORT, "--gradients", "0.5"],
    "auto gradients": ["run", "photo.png", "auto-gradients.svg", *_SHORT, "--gradients", "auto"],
    "minified": ["run", "photo.png", "minified.svg", *_SHORT, "--minify"],
    "minified levels": ["run", "photo.png", "minified-levels.svg", *_SHORT, "--minify", "--lod", "--units", "8"],
    "trimmed": ["run", "photo.png", "trimmed.svg", *_SHORT, "--trim", "--no-metadata", "--size", "50mm"],
    "psnr": ["run", "photo.png", "psnr.svg", "--iterations", "120", *_PHOTO, "--target-psnr", "24", "--json"],
    "psnr and bytes": ["run", "photo.png", "psnr-bytes.svg", "--iterations", "120", *_PHOTO, "--target-psnr", "22",
                       "--max-bytes", "9k", "--json"],
    "psnr of replacement": ["run", "photo.png", "psnr-fixed.svg", "--iterations", "60", "--target-psnr", "20",
                            "--recycle-gap", "0", "--json"],
    "as many as pay": ["run", "photo.png", "auto.svg", "--iterations", "80", *_PHOTO, "--curves", "auto", "--json"],
    "bytes of levels": ["run", "photo.png", "bytes-levels.svg", "--iterations", "80", "--lod", "--max-bytes", "9000",
                        "--json"],
    "translucent bytes": ["run", "logo.png", "logo-bytes.svg", "--iterations", "80", *_PHOTO, "--max-bytes", "3000",
                          "--json"],
    "auto mode": ["run", "drawing.png", "auto-mode.svg", "--json", "--save-frames", "drawing-frames", "--every", "4"],
    "auto mode of a photo": ["run", "photo.png", "auto-photo.svg", "--iterations", "60", "--json"],
    "flat detail": ["run", "drawing.png", "detail.svg", "--mode", "flat", "--detail", "0.4", "--json"],
    "flat jpeg": ["run", "drawing.jpg", "jpeg.svg", "--mode", "flat", "--json"],
    "flat colors": ["run", "drawing.png", "flat-colors.svg", "--mode", "flat", "--colors", "3", "--json"],
    "flat palette": ["run", "drawing.png", "flat-palette.svg", "--mode", "flat", "--palette", "red,#123,#fff",
                     "--opaque", "--json"],
    "flat without gradients": ["run", "drawing.png", "flat-plain.svg", "--mode", "flat", "--gradients", "0",
                               "--curves", "6", "--min-area", "20", "--json"],
    "cutout": ["run", "drawing.png", "cutout.svg", "--cutout", "--json"],
    "flat minified": ["run", "drawing.png", "flat-minified.svg", "--mode", "flat", "--minify", "--json"],
    "flat bytes": ["run", "drawing.png", "flat-bytes.svg", "--mode", "flat", "--max-bytes", "500", "--json"],
    "flat psnr": ["run", "drawing.png", "flat-psnr.svg", "--mode", "flat", "--target-psnr", "30", "--json"],
    "mono threshold": ["run", "drawing.png", "mono-threshold.svg", "--threshold", "90", "--minify", "--json"],
    "mono bytes": ["run", "drawing.png", "mono-bytes.svg", "--mode", "mono", "--max-bytes", "250", "--json"],
    "placeholder": ["run", "photo.png", "placeholder.svg", "--placeholder", "--json"],
    "placeholder bytes": ["run", "drawing.png", "-", "--placeholder", "--max-bytes", "700", "--quiet"],
    "refine drawing": ["refine", "drawing.png", "refined-drawing.svg", "--from", "auto-mode.svg", "--json"],
    "refine foreign drawing": ["refine", "drawing.png", "refined-by-hand.svg", "--from", "by-hand.svg", "--json"],
    "refine free": ["refine", "drawing.png", "refined-free.svg", "--from", "by-hand.svg", "--free", "--opaque",
                    "--iterations", "60", "--json"],
    "refine gradients": ["refine", "drawing.png", "refined-gradients.svg", "--from", "by-hand.svg", "--gradients",
                         "auto", "--iterations", "90", "--json"],
    "refine nothing": ["refine", "drawing.png", "as-read.svg", "--from", "by-hand.svg", "--iterations", "0", "--json"],
    "refine many": ["refine", "photo.png", "refined-many.svg", "--from", "exact.svg", "--iterations", "50", "--json"],
    "refine minified": ["refine", "photo.png", "refined-minified.svg", "--from", "minified.svg", "--iterations", "40",
                        "--write-config", "refine.toml", "--json"],
    "refine to bytes": ["refine", "photo.png", "refined-bytes.svg", "--from", "exact.svg", "--iterations", "80",
                        "--max-bytes", "7k", "--json"],
    "eval": ["eval", "photo.png", "exact.svg", "--json"],
    "eval foreign": ["eval", "photo.png", "foreign.svg", "--json"],
    "lod": ["lod", "levels.svg", "--levels", "0-1", "-o", "lower.svg", "--list", "--image", "photo.png", "--json"],
    "view": ["view", "exact.svg", "--image", "photo.png", "--report", "view.html"],
    "batch": ["batch", "photos", "svgs", "--jobs", "2", "--quiet", "--curves", "16", "--iterations", "40", *_PHOTO],
}  # fmt: skip
"""Name -> arguments of ``warpvec``, in the order of the runs; some commands read the files of earlier ones."""

PAGE_JOBS: dict[str, dict[str, Any]] = {
    "page photo": {"picture": "photo.png", "settings": {"mode": "photo", "curves": 12}},
    "page photo further": {
        "picture": "photo.png", "settings": {"mode": "photo", "curves": 30}, "start": "exact.svg", "done_share": 0.9,
    },
    "page drawing": {"picture": "drawing.png", "settings": {}},
    "page other detail": {"picture": "drawing.png", "settings": {"detail": 0.5}},
    "page bytes": {"picture": "photo.png", "settings": {"max_bytes": 2000}},
    "page edited": {
        "picture": "drawing.png", "settings": {}, "start": "by-hand.svg", "locked": (1,), "keeps_paths": True,
    },
    "page erased": {
        "picture": "photo.png", "settings": {"mode": "photo"}, "start": "exact.svg", "erased": "hole.svg",
        "filled": "hole.svg", "keeps_paths": True,
    },
}  # fmt: skip
"""Name -> fields of a job of the page of ``warpvec app``; pictures and drawings by their file names."""

EXIT_CODES = {"batch": 1}
"""Name -> expected exit code of the commands whose code is not 0. One photo of the batch is broken."""

# Keys of JSON reports that differ from run to run.
_TIMES = ("seconds", "elapsed")
# An SVG of another program: CSS, transforms, group opacity, strokes and an even-odd fill.
_FOREIGN = """<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 150 100"><style>.a{fill:#c52}</style>
<rect width="150" height="100" fill="#432"/><g transform="translate(60 50) scale(1.5)"><circle class="a" r="25"/>
<path d="M0 0h20v10a5 5 0 0 1-20 0z" stroke="red" fill="rgb(20,40,90)"/></g><g opacity=".5"><ellipse cx="90" cy="40"
rx="20" ry="9"/><path fill-rule="evenodd" d="M100 60h30v30h-30zM110 70h9v9h-9z"/></g></svg>"""
# A drawing of the picture that `_draw_picture` makes, with wrong places and colours, for `refine` to mend.
_BY_HAND = """<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 160 120"><title>by hand</title>
<path fill="#fff" d="M0 0h160v120h-160z"/><path fill="#1a2a5a" d="M22 21h60v76h-60z"/>
<path fill="#d64" d="M101 22c23 1 39 17 39 39s-17 39-40 38s-38-18-38-39s18-38 39-38z"/>
<path fill="#fed" d="M99 44c9 0 17 7 17 16s-7 17-16 17s-16-8-16-17s6-16 15-16z"/></svg>"""
# Part of the photo, for the page to take out.
_HOLE = """<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 150 100">
<path d="M60 40h20v15h-20z"/><path d="M90 20h10v10h-10z"/></svg>"""


def main() -> int:
    """Record the outputs, or compare them with those of a file; return the exit code."""
    options = _parse_options()
    with tempfile.TemporaryDirectory() as folder:
        found = record(Path(folder))
    if options.action == "record":
        options.file.write_text(json.dumps(found, indent=1, sort_keys=True))
        return 0
    before = {name: output for name, output in json.loads(options.file.read_text()).items() if name not in options.skip}
    differences = [
        f"{name}: {place}"
        for name, output in before.items()
        for place in differing(output, found.get(name), options.without)
    ]
    print("\n".join(differences) or f"{len(before)} commands: no difference")
    return int(bool(differences))


def _parse_options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("action", choices=["record", "compare"])
    parser.add_argument("file", type=Path, help="JSON file of the recorded outputs")
    parser.add_argument("--without", action="append", default=[], metavar="KEY", help="ignore this key; repeatable")
    parser.add_argument(
        "--skip", action="append", default=[], choices=[*COMMANDS, *PAGE_JOBS], metavar="COMMAND",
        help=f"do not compare this command; repeatable; one of: {', '.join(COMMANDS)}",
    )  # fmt: skip
    return parser.parse_args()


def record(folder: Path) -> dict[str, Any]:
    """Run every command in ``folder``; return the outputs by name."""
    _make_inputs(folder)
    outputs: dict[str, Any] = {}
    for name, words in COMMANDS.items():
        print(f"warpvec {' '.join(words)}", file=sys.stderr)
        outputs[name] = run_command(words, folder, EXIT_CODES.get(name, 0))
    return {**outputs, **_run_page_jobs(folder)}


def run_command(words: list[str], folder: Path, exit_code: int = 0) -> dict[str, Any]:
    """Run ``warpvec`` with the arguments ``words``. Return the exit code, the report and the files.

    Raises:
        SystemExit: the command ends with another code than ``exit_code``.
    """
    known = {path: path.stat().st_mtime_ns for path in folder.rglob("*")}
    done = subprocess.run(
        [sys.executable, "-m", "warpvec", *words], cwd=folder, capture_output=True, text=True, check=False
    )
    if done.returncode != exit_code:
        raise SystemExit(f"exit code must be {exit_code}, got {done.returncode}; it printed:\n{done.stderr}")
    written = [p for p in sorted(folder.rglob("*")) if p.is_file() and known.get(p) != p.stat().st_mtime_ns]
    return {
        "exit code": done.returncode,
        "report": _plain(json.loads(done.stdout)) if done.stdout.startswith(("{", "[")) else done.stdout,
        "files": {str(path.relative_to(folder)): _content(path) for path in written},
    }


def _run_page_jobs(folder: Path) -> dict[str, Any]:
    """Do every job of the page as its worker process does, one after another; return the facts by name."""
    from types import SimpleNamespace

    from warpvec.app.messages import FitJob
    from warpvec.app.settings import FitSettings
    from warpvec.app.work import Worker

    mailbox: Any = SimpleNamespace(
        check=lambda: None, has_signal=lambda: False, hold=lambda: None
    )  # nobody stops a job
    reports: list[Any] = []
    worker = Worker(mailbox, reports.append, threads=None)
    outputs = {}
    for name, fields in PAGE_JOBS.items():
        print(f"job of the page: {name}", file=sys.stderr)
        texts = {key: (folder / fields[key]).read_text() for key in ("start", "erased", "filled") if key in fields}
        plain = {key: fields[key] for key in ("locked", "keeps_paths", "done_share") if key in fields}
        picture, settings = (folder / fields["picture"]).read_bytes(), FitSettings(fields["settings"])
        found = worker.do(FitJob(1, picture, fields["picture"], settings, **texts, **plain))
        mode = [report.facts for report in reports if report.kind == "mode"][-1]
        drawing = {"files": {"drawing.svg": _svg_content(found.pop("svg").encode())}}
        outputs[name] = {"report": _plain(found), "mode": mode, **drawing}
    return outputs


def differing(before: Any, after: Any, without: list[str], place: str = "") -> list[str]:
    """List the places where two recorded outputs differ, ignoring the keys ``without``."""
    if not isinstance(before, dict) or not isinstance(after, dict):
        return [] if before == after else [f"{place}: {str(before)[:60]} -> {str(after)[:60]}"]
    keys = [key for key in sorted({*before, *after}) if key not in without]
    return [line for key in keys for line in differing(before.get(key), after.get(key), without, f"{place}/{key}")]


def _make_inputs(folder: Path) -> None:
    """Write the photos and the SVG that the commands read."""
    import skimage

    photo = Image.open(Path(skimage.__file__).parent / "data" / "coffee.png").convert("RGB").resize((150, 100))
    photo.save(folder / "photo.png")
    logo = Image.new("RGBA", (80, 64))
    ImageDraw.Draw(logo).ellipse((8, 6, 70, 58), fill=(200, 60, 30, 255), outline=(20, 30, 90, 128), width=5)
    logo.save(folder / "logo.png")
    picture = _draw_picture()
    picture.save(folder / "drawing.png")
    picture.save(folder / "drawing.jpg", quality=75)
    for name, text in {"foreign.svg": _FOREIGN, "by-hand.svg": _BY_HAND, "hole.svg": _HOLE}.items():
        (folder / name).write_text(text)
    (folder / "photos").mkdir()
    for number in range(3):
        photo.crop((40 * number, 0, 40 * number + 60, 60)).save(folder / "photos" / f"{number}.png")
    (folder / "photos" / "broken.png").write_bytes(b"no picture")


def _draw_picture() -> Image.Image:
    """Return flat art with overlapping shapes, a hole, a thin stroke, corners and a gradient, 160 x 120 pixels."""
    scale = 4  # drawn larger, so that its edges are smooth
    stroke = (10, 110, 90, 104, 150, 112)
    picture = Image.new("RGB", (160 * scale, 120 * scale), "white")
    pen = ImageDraw.Draw(picture)
    for row in range(76 * scale):
        shade = row / (76 * scale)
        color = (round(20 + 60 * shade), round(40 + 90 * shade), round(90 + 100 * shade))
        pen.line((20 * scale, 22 * scale + row, 80 * scale, 22 * scale + row), fill=color)
    pen.ellipse((60 * scale, 20 * scale, 140 * scale, 100 * scale), fill=(210, 90, 60))
    pen.ellipse((84 * scale, 44 * scale, 116 * scale, 76 * scale), fill="white")
    pen.line([scale * place for place in stroke], fill="black", width=2 * scale)
    pen.polygon([(130 * scale, 8 * scale), (154 * scale, 12 * scale), (146 * scale, 34 * scale)], fill=(240, 200, 40))
    return picture.resize((160, 120), Image.Resampling.BOX)


def _plain(value: Any) -> Any:
    """Drop the times of a report, and turn its lists into dictionaries, so that every value has a key."""
    if isinstance(value, list):
        return {str(index): _plain(item) for index, item in enumerate(value)}
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items() if key not in _TIMES}
    return value


def _content(path: Path) -> Any:
    """Return the content of a file to compare, in a form that depends on its suffix."""
    data = path.read_bytes()
    match path.suffix:
        case ".svg":
            return _svg_content(data)
        case ".svgz":
            return _svg_content(gzip.decompress(data))
        case ".jsonl":
            return _records_content(data)
        case ".toml":
            return dict(line.split(" = ") for line in data.decode().splitlines()[1:])
        case ".html":
            return _page_content(data)
        case ".npz" | ".csv":
            return None  # they hold times; only their existence is compared
    return _digest(data)


def _svg_content(data: bytes) -> dict[str, Any]:
    """Return a digest of the drawing, and the settings in its metadata."""
    text = data.decode()
    found = re.search("<metadata>(.*?)</metadata>", text)
    settings = json.loads(found[1]) if found else {}
    return {"drawing": _digest(re.sub("<metadata>.*?</metadata>", "", text).encode()), "settings": settings}


def _records_content(data: bytes) -> dict[str, Any]:
    """Return the records of a batch by input, without their keys, which are digests of all settings."""
    records = [_plain(json.loads(line)) for line in data.decode().splitlines()]
    return {record["input"]: {key: value for key, value in record.items() if key != "key"} for record in records}


def _page_content(data: bytes) -> dict[str, Any]:
    """Return the data in an HTML page, without the drawing, which is compared as a file, and the rendered figures."""
    found = re.search(r'id="data">(.*?)</script>', data.decode(), re.DOTALL)
    page_data = _plain(json.loads(found[1])) if found else {}
    return {key: value for key, value in page_data.items() if key not in ("svg", "figures")}


def _digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()[:16]


if __name__ == "__main__":
    sys.exit(main())
