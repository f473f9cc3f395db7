"""Commands with any options, values and files, run in the process of the worker."""

from __future__ import annotations

import os
import re
import sys
from functools import cache
from pathlib import Path
from random import Random

from torture_case import OK, REFUSED, Case, Wrong

BASE = (
    "--curves", "8", "--iterations", "3", "--threads", "1", "--fit-size", "32", "--samples", "8", "--lines", "4",
    "--segments", "4", "--initial-curves", "4", "--degree", "3", "--device", "cpu",
)  # fmt: skip
"""Options that keep a fit small; they come last on a command line, so that they hold."""

NAMES = (
    "mode", "detail", "cutout", "threshold", "size",
    "preset", "background", "curves", "max_bytes", "target_psnr", "gzip", "colors", "palette", "opacity", "opaque",
    "min_area", "lod", "trim", "no_metadata", "precision", "path_model", "segments", "degree", "backdrop", "iterations",
    "time_budget", "fit_size", "device", "threads", "seed", "renderer", "samples", "lines", "interior_gradient",
    "covariance_gradient", "policy", "z_order", "initial_curves", "growth", "inflation_gap", "shorten_gap",
    "initial_radius", "radius_decay", "prune_opacity", "compensate", "flat", "recycle_gap", "recycle_share",
    "recycle_until", "replace_gap", "lr_points", "lr_color", "lr_opacity", "lr_scale", "lr_decay", "lr_final",
    "color_parameter", "opacity_weight", "ssim_weight", "xing_weight", "bezier_weight",
)  # fmt: skip
"""Names of settings and goals."""

_FLAGS = frozenset({"gzip", "opaque", "trim", "no_metadata"})
_SWITCHES = frozenset(
    {"lod", "interior_gradient", "covariance_gradient", "shorten_gap", "compensate", "flat", "cutout"}
)

_VALUES = (
    "0", "1", "-1", "2", "3", "8", "0.5", "1.01", "-0", "1e-9", "1e3", "1e308", "1e309", "-1e308", "nan", "inf",
    "-inf", "", " ", "x", "auto", "none", "true", "1_000", "0x10", "1" * 400, "9223372036854775807",
    "9223372036854775808", "5%", "\ud800", "a\nb", "-", "--", "=", "red", "#123", "red,#123", "red,,", "free",
    "opaque", "white", "learned", "exact", "splat", "sides", "segments", "area", "creation", "replacement",
    "scaffolding", "cosine", "steps", "logit", "direct", "draft", "default", "best", "bezier-splatting", "cpu", "cuda",
    "cuda:0", "cuda:-1", "cpu:1", "20k", "1.5M", "30", "photo", "mono", "90mm", "200%",
)  # fmt: skip

_FILES = (
    "photo.png", "drawing.svg", "drawing.svgz", "cut.png", "empty", "folder", "missing.png", "-", "", ".", "/dev/null",
    "/dev/full", "out.svg", "out.svgz", "out.html", "out.png", "folder/out.svg", "missing/out.svg", "loop",
    "hidden/a.svg", "fit.ckpt", "settings.toml", "a\nb.svg", "-a.svg", "\udcff.svg", "x" * 255, "x" * 256,
    "../case/out.svg", "out.svg/a", "photo.png/", "=1+1.svg", "http://x.invalid/a.png", "s3://x/a.png", "~/a.svg",
    "%d.png", "out.gif", "out.pdf", "out.eps",
)  # fmt: skip

_COMMANDS: dict[str, tuple[int, tuple[str, ...]]] = {
    "run": (2, ("--report", "--video", "--save-frames", "--checkpoint", "--resume", "--write-config", "--config")),
    "refine": (3, ("--report", "--video", "--save-frames", "--write-config", "--config")),
    "eval": (2, ()),
    "view": (1, ("--image", "-o", "--history")),
    "lod": (1, ("--image", "-o", "--levels")),
    "info": (0, ()),
    "sample": (2, ()),
    "help": (1, ()),
}
"""Command -> number of its arguments, options that take a file."""


def case(chance: Random) -> Case:
    """Return one command line; the fits of it stay small."""
    name = chance.choices(list(_COMMANDS), [8, 4, 3, 3, 3, 1, 1, 1])[0]
    count, file_options = _COMMANDS[name]
    good = {
        "run": ["photo.png", "out.svg"],
        "refine": ["photo.png", "drawing.svg", "out.svg"],
        "view": ["drawing.svg", "-o", "page.html"],
    }
    good |= {"eval": ["photo.png", "drawing.svg"], "lod": ["drawing.svg"], "help": ["run"]}
    files = good.get(name, [])
    if chance.random() < 0.5:
        files[:count] = [
            chance.choice(_FILES) for _ in range(chance.choice([count, count, count, count + 1, max(count - 1, 0)]))
        ]
    words = [name, *files]
    for _ in range(chance.choice([0, 1, 1, 2, 3])):
        words += _option(chance, name, file_options)
    chance_of_streams = chance.random()
    if name in ("run", "refine"):
        words += BASE
    stdin = (b"", inputs()["photo.png"], inputs()["drawing.svg"], b"\0" * 1000)[int(4 * chance_of_streams)]
    return Case(f"{words}"[:300], lambda folder: check(words, folder, stdin), repr(words).encode())


def check(words: list[str], folder: Path, stdin: bytes = b"") -> str:
    """Run a command among files of all kinds."""
    write_inputs(folder)
    # A device that is always full is a full disk, which is no fault of the input.
    return invoked(words, stdin, (0, 1, 2) if "/dev/full" in words else (0, 2))


def value(chance: Random, name: str) -> str:
    """Return a value for the setting ``name``."""
    del name
    return chance.choice(_VALUES)


def invoked(words: list[str], stdin: bytes = b"", codes: tuple[int, ...] = (0, 2)) -> str:
    """Run ``warpvec`` in this process.

    Raises:
        Wrong: it ended with another exit code than ``codes``, or did not say in one line what is wrong.
    """
    from click.testing import CliRunner

    from warpvec.cli.main import main

    done = CliRunner().invoke(main, words, input=stdin)
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        raise done.exception
    if done.exit_code not in codes:
        raise Wrong(f"exit code {done.exit_code}: {done.stderr[-300:]!r}")
    if done.exit_code == 2:
        _check_message(done.stderr)
    return OK if done.exit_code == 0 else REFUSED


def _check_message(text: str) -> None:
    lines = text.splitlines()
    if not (lines and lines[-1].startswith("warpvec: error: ")) and "Usage:" not in text:
        raise Wrong(f"no line that says what is wrong: {text[-300:]!r}")
    if any(len(line) > 1000 for line in lines):
        raise Wrong(f"a message of {max(map(len, lines))} characters")
    if re.search(r"[\x00-\x08\x0e-\x1f\x7f]", text):
        raise Wrong(f"control characters in a message: {text[-300:]!r}")


def write_inputs(folder: Path) -> None:
    """Write files and folders that arguments may name, and go there."""
    for name, data in inputs().items():
        (folder / name).write_bytes(data)
    (folder / "folder").mkdir()
    (folder / "hidden").mkdir(0o000)
    (folder / "loop").symlink_to("loop")
    os.chdir(folder)


@cache
def inputs() -> dict[str, bytes]:
    """Return the files that arguments may name."""
    import gzip

    import torture_checkpoints as checkpoints
    import torture_image_files as images
    import torture_svg_files as svgs

    photo, drawing = images.seeds("png")[0], svgs.seeds()[0]
    return {
        "photo.png": photo, "cut.png": photo[:60], "empty": b"", "drawing.svg": drawing,
        "drawing.svgz": gzip.compress(drawing, mtime=0), "fit.ckpt": checkpoints.checkpoint_of("plain"),
        "settings.toml": b"curves = 8\n", "history.json": b"[]",
        "deep.json": b"[" * 10**5, "binary": b"\xff\0",
    }  # fmt: skip


def _option(chance: Random, command: str, file_options: tuple[str, ...]) -> list[str]:
    if file_options and chance.random() < 0.4:
        return [
            chance.choice(file_options),
            chance.choice([*_FILES, "history.json", "deep.json", "binary", "0-3", "2-"]),
        ]
    if command not in ("run", "refine") or chance.random() < 0.1:
        flags = [
            "--json",
            "--quiet",
            "-q",
            "--split",
            "--list",
            "--compile",
            "--help",
            "--help-all",
            "--x",
            "--debug",
            "-",
            "--",
        ]
        return [chance.choice(flags)]
    name = chance.choice(NAMES)
    option = "--" + name.replace("_", "-")
    if name in _FLAGS:
        return [option]
    if name in _SWITCHES:
        return [chance.choice([option, "--no-" + option[2:], option + "=1"])]
    return [f"{option}={value(chance, name)}"] if chance.random() < 0.7 else [option, value(chance, name)]


if __name__ == "__main__":
    sys.exit("a part of torture.py")
