"""Check that a change to the code leaves every drawing and every JSON report the same.

Record the outputs before the change, and compare them after it, on the same machine:

    python bench/same_output.py record before.json
    python bench/same_output.py compare before.json

Some two dozen short commands cover both renderers, every policy, flat art, transparency, palettes, levels, goals,
resume, refine and batch; together they take a minute. A drawing must have the same bytes. The settings in metadata and
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
    "eval": ["eval", "photo.png", "exact.svg", "--json"],
    "eval foreign": ["eval", "photo.png", "foreign.svg", "--json"],
    "lod": ["lod", "levels.svg", "--levels", "0-1", "-o", "lower.svg", "--list", "--image", "photo.png", "--json"],
    "view": ["view", "exact.svg", "--image", "photo.png", "--report", "view.html"],
    "batch": ["batch", "photos", "svgs", "--jobs", "2", "--quiet", "--curves", "16", "--iterations", "40", *_PHOTO],
}  # fmt: skip
"""Name -> arguments of ``warpvec``, in the order of the runs; some commands read the files of earlier ones."""

EXIT_CODES = {"batch": 1}
"""Name -> expected exit code of the commands whose code is not 0. One photo of the batch is broken."""

# Keys of JSON reports that differ from run to run.
_TIMES = ("seconds", "elapsed")
# An SVG of another program: CSS, transforms, group opacity, strokes and an even-odd fill.
_FOREIGN = """<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 150 100"><style>.a{fill:#c52}</style>
<rect width="150" height="100" fill="#432"/><g transform="translate(60 50) scale(1.5)"><circle class="a" r="25"/>
<path d="M0 0h20v10a5 5 0 0 1-20 0z" stroke="red" fill="rgb(20,40,90)"/></g><g opacity=".5"><ellipse cx="90" cy="40"
rx="20" ry="9"/><path fill-rule="evenodd" d="M100 60h30v30h-30zM110 70h9v9h-9z"/></g></svg>"""


def main() -> int:
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
        "--skip", action="append", default=[], choices=COMMANDS, metavar="COMMAND",
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
    return outputs


def run_command(words: list[str], folder: Path, exit_code: int = 0) -> dict[str, Any]:
    """Run ``warpvec`` with the arguments ``words``; return its exit code, its report and the files that it wrote.

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
    (folder / "foreign.svg").write_text(_FOREIGN)
    (folder / "photos").mkdir()
    for number in range(3):
        photo.crop((40 * number, 0, 40 * number + 60, 60)).save(folder / "photos" / f"{number}.png")
    (folder / "photos" / "broken.png").write_bytes(b"no picture")


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
