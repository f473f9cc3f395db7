"""Options of a fit: the settings they lead to, files of settings that are read and written, and mistakes."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import pytest
from commands import assert_refused, invoke, write_photo

from warpvec.cli.options import OPTIONS, file_options, requested
from warpvec.config.fit_config import FitConfig
from warpvec.config.presets import make_config
from warpvec.config.setting import settings_of
from warpvec.drawing.file_options import FileOptions
from warpvec.errors import InputError
from warpvec.goals.goal import Goal, make_goal
from warpvec.modes import choice
from warpvec.modes.request import Request

Asked = list[tuple[FitConfig, Goal]]


class Seen(Exception):
    """Raised where the fit would start."""


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> Asked:
    """Return the list of settings and goals that commands ask for. No fit is made."""
    found: Asked = []

    def record(request: Request, *_: Any) -> None:
        found.append((request.settings, request.goal))
        raise Seen

    monkeypatch.setattr(choice, "draw_picture", record)
    return found


@pytest.fixture
def photo(tmp_path: Path) -> Path:
    return write_photo(tmp_path)


def _run(photo: Path, *options: object, out: str = "out.svg") -> None:
    result = invoke("run", photo, photo.with_name(out), *options)
    assert "Seen" in result.stderr, result.output


def test_options_become_settings_and_a_goal() -> None:
    given: dict[str, Any] = {"curves": None, "seed": 3, "max_bytes": 5000, "gzip": None, "target_psnr": None}
    config, goal = requested({**given, "preset": "draft"})
    assert goal == make_goal(max_bytes=5000)
    assert config == make_config("draft", seed=3, curves=config.curves, minify=True)
    assert requested({"preset": "default", "curves": 7}) == (FitConfig(curves=7), make_goal())
    assert requested({"preset": "default", "curves": "auto"})[1] == make_goal(auto=True)
    assert requested({"preset": "default", "curves": 7, "target_psnr": 30.0})[0].curves == 7


@pytest.mark.parametrize(
    ("name", "remedy"),
    [
        ("curvs", "did you mean curves?"),
        ("opaque", "give opacity='opaque'"),
        ("tempo", "see warpvec.FitConfig for the names"),
    ],
)
def test_unknown_settings_in_python_come_with_a_remedy(name: str, remedy: str) -> None:
    with pytest.raises(InputError) as refusal:
        make_config(**{name: 1})
    assert str(refusal.value) == f"{name} is not a setting; {remedy}"


@pytest.mark.parametrize(
    ("options", "config", "goal"),
    [
        (["--opaque"], {"opacity": "opaque"}, make_goal()),
        (["--opacity", "opaque"], {"opacity": "opaque"}, make_goal()),
        (["--colors", "16", "--min-area", "2.5"], {"colors": 16, "opacity": "opaque", "min_area": 2.5}, make_goal()),
        (["--colors", "16", "--opacity", "free"], {"colors": 16, "opacity": "free"}, make_goal()),
        (["--colors", "0"], {}, make_goal()),
        (["--palette", "#123,#ABCDEF"], {"palette": "#112233,#abcdef"}, make_goal()),
        (["--palette", "red, Blue"], {"palette": "#ff0000,#0000ff"}, make_goal()),
        (["--max-bytes", "80k"], {"curves": 16384, "minify": True}, make_goal(max_bytes=80_000)),
        (["--max-bytes", "80k", "--curves", "99"], {"curves": 99, "minify": True}, make_goal(max_bytes=80_000)),
        (["--max-bytes", "80k", "--no-minify"], {"curves": 16384}, make_goal(max_bytes=80_000)),
        (["--max-bytes", "9k", "--gzip"], {"curves": 16384, "minify": True}, make_goal(max_bytes=9_000, gzip=True)),
        (
            ["--target-psnr", "28", "--time-budget", "9"],
            {"curves": 16384, "time_budget": 9.0},
            make_goal(target_psnr=28.0),
        ),
        (["--target-ssim", "0.8"], {"curves": 16384}, make_goal(target_ssim=0.8)),
        (["--curves", "auto"], {"curves": 16384}, make_goal(auto=True)),
    ],
)
def test_options_reach_the_fit(
    photo: Path, asked: Asked, options: list[str], config: dict[str, Any], goal: Goal
) -> None:
    _run(photo, *options)
    assert asked == [(make_config(**config), goal)]


def test_svgz_counts_bytes_after_gzip(photo: Path, asked: Asked) -> None:
    _run(photo, "--max-bytes", "9k", out="out.SVGZ")
    _run(photo, out="out.svgz")
    assert [goal for _, goal in asked] == [make_goal(max_bytes=9_000, gzip=True), make_goal(gzip=True)]


# files of settings


@pytest.mark.parametrize(
    "options",
    [
        [],
        ["--preset", "paper", "--no-interior-gradient", "--seed", "9"],
        ["--preset", "bezier-splatting", "--curves", "33"],
        ["--max-bytes", "80k"],
        ["--max-bytes", "80k", "--gzip", "--curves", "900"],
        ["--curves", "auto", "--target-psnr", "27.5"],
        ["--opaque", "--palette", "#123,#456", "--time-budget", "12.5", "--threads", "1", "--one-generation"],
        ["--colors", "8", "--lr-points", "1e-7", "--min-area", "3"],
        ["--colors", "8", "--opacity", "free", "--trim", "--no-metadata", "--size", "90mm"],
        ["--mode", "flat", "--detail", "0.3", "--cutout"],
        ["--threshold", "128"],
    ],
)
@pytest.mark.parametrize("out", ["out.svg", "out.svgz"])
def test_a_written_file_leads_to_the_same_fit(photo: Path, asked: Asked, options: list[str], out: str) -> None:
    settings = photo.with_name("settings.toml")
    _run(photo, *options, "--write-config", settings, out=out)
    _run(photo, "--config", settings, out=out)
    assert asked[0] == asked[1]
    again = photo.with_name("again.toml")
    _run(photo, "--config", settings, "--write-config", again, out=out)
    assert again.read_bytes() == settings.read_bytes()
    stated = tomllib.loads(settings.read_text(encoding="utf-8"))
    # The goal decides the number of paths.
    assert ("curves" in stated) is ("--max-bytes" not in options or "--curves" in options)
    assert set(stated) <= {"preset", "background", *OPTIONS}
    file_names = {"size", "trim", "no_metadata"}
    assert {name for name in file_names if stated.get(name)} == (file_names if "--trim" in options else set())


def test_the_command_line_overrides_the_file(photo: Path, asked: Asked) -> None:
    settings = photo.with_name("settings.toml")
    settings.write_text(
        'curves = 40\nlr-points = 0.5\npreset = "draft"\none-generation = true\nopaque = true\nmax-bytes = "9k"'
    )
    _run(photo, "--config", settings)
    _run(photo, "--curves", "50", "--no-one-generation", "--preset", "best", "--opacity", "free", "--config", settings)
    goal = make_goal(max_bytes=9_000)
    first = make_config("draft", curves=40, lr_points=0.5, one_generation=True, opacity="opaque", minify=True)
    second = make_config("best", curves=50, lr_points=0.5, opacity="free", minify=True)
    assert asked == [(first, goal), (second, goal)]


def test_colors_on_the_command_line_make_paths_opaque_whatever_the_file_says(photo: Path, asked: Asked) -> None:
    settings = photo.with_name("settings.toml")
    settings.write_text('opacity = "free"\ncolors = 8')
    for options in (["--colors", "3"], ["--colors", "3", "--opacity", "free"], [], ["--colors", "0"]):
        _run(photo, "--config", settings, *options)
    assert [config.opacity for config, _ in asked] == ["opaque", "free", "free", "free"]


def test_the_background_is_written_too(photo: Path, asked: Asked) -> None:
    settings = photo.with_name("settings.toml")
    _run(photo, "--background", "#fff", "--write-config", settings)
    assert tomllib.loads(settings.read_text())["background"] == "#fff"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("tempo = 3", ["tempo in", "settings.toml", "must be the name of an option of this command"]),
        ("curves = 12.7", ["--curves must be a whole number or auto, got '12.7'"]),
        ("curves = true", ["--curves must be a whole number or auto, got 'True'"]),
        ("seed = 0.5", ["--seed must be a whole number, got '0.5'"]),
        ("min-area = true", ["--min-area must be a number, got 'True'"]),
        ("curves = 0", ["--curves must be", "got 0"]),
        ("one-generation = 7", ["one_generation in", "must be true or false, got 7"]),
        ('opaque = "yes"', ["opaque in", "must be true or false, got 'yes'"]),
        ("palette = 5", ["--palette must be colours", "or a file of them, got '5'"]),
        ('max-bytes = "80 apples"', ["--max-bytes must be a size such as", "'80 apples'"]),
        ('preset = "fast"', ["--preset must be one of", "'fast'"]),
        ('config = "a.toml"', ["config in", "must be the name of an option"]),
        ("help-all = true", ["help_all in", "must be the name of an option"]),
        ("curves = ", ["--config must be a TOML file"]),
    ],
)
def test_mistakes_in_a_file_are_reported_in_one_line(photo: Path, text: str, words: list[str]) -> None:
    settings = photo.with_name("settings.toml")
    settings.write_text(text)
    assert_refused(invoke("run", photo, photo.with_name("out.svg"), "--config", settings), *words)
    assert not photo.with_name("out.svg").exists()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--max-bytes", "0"], ["--max-bytes must be a size", "'0'"]),
        (["--target-psnr", "300"], ["--target-psnr must", "300"]),
        (["--target-ssim", "1"], ["--target-ssim must be above 0 and at most 0.999, got 1"]),
        (["--target-ssim", "0.8", "--target-psnr", "30"], ["--target-ssim must not be given with --target-psnr"]),
        (["--colors", "257"], ["--colors must be", "from 0 to 256"]),
        (["--colors", "3", "--palette", "#123"], ["--colors must be 0 with a palette"]),
        (["--palette", "#12345"], ["--palette must be colours"]),
        (["--palette", "red,crimsn"], ["--palette must be colours", "or a file of them, got 'red,crimsn'", "neither"]),
        (["--opacity", "0.5"], ["--opacity must be one of free, common, opaque"]),
        (["--min-area", "-1"], ["--min-area must be"]),
        (["--opaque", "--opacity", "free"], ["--opaque must not be given with --opacity free; leave one of them out"]),
        (["--gzip"], ["--gzip must come with --max-bytes; add --max-bytes or leave --gzip out"]),
        (["--gzip", "--target-psnr", "30"], ["--gzip must come with --max-bytes"]),
        (["--policy", "replacement", "--max-bytes", "5k"], ["--policy must be scaffolding to meet a goal"]),
        (["--preset", "bezier-splatting", "--curves", "auto"], ["--policy must be scaffolding", "'replacement'"]),
        (["--write-config", "missing/a.toml"], ["--write-config must be in an existing folder"]),
        (["--config", "missing.toml"], ["--config must be a TOML file", "missing.toml"]),
    ],
)
def test_wrong_options_are_reported_in_one_line(photo: Path, options: list[str], words: list[str]) -> None:
    written = [] if "--write-config" in options else ["--write-config", photo.with_name("a.toml")]
    # The photo does not exist: these are reported before it is read.
    assert_refused(invoke("run", photo.with_name("none.png"), photo.with_name("out.svg"), *options, *written), *words)
    assert [path.name for path in photo.parent.iterdir()] == ["photo.png"]


def test_opaque_twice_is_no_contradiction(photo: Path, asked: Asked) -> None:
    _run(photo, "--opaque", "--opacity", "opaque")
    assert asked[0][0].opacity == "opaque"
    settings = photo.with_name("settings.toml")
    settings.write_text('opaque = true\nopacity = "free"')
    result = invoke("run", photo, photo.with_name("out.svg"), "--config", settings)
    assert_refused(result, "--opaque must not be given with --opacity free")


@pytest.mark.parametrize(
    ("text", "palette"),
    [
        ("sky: #ABC, sea: #001122;", "#aabbcc,#001122"),
        ("# warm\nred\n#00f  # cold\nwhite\n", "#ff0000,#0000ff,#ffffff"),
        ("red, #00f; white", "#ff0000,#0000ff,#ffffff"),
        ("red #00f white", "#ff0000,#0000ff,#ffffff"),
        ("red #e6194b\ngreen #3cb44b", "#e6194b,#3cb44b"),
        ("My palette\nsky #abc", "#aabbcc"),
        ("GIMP Palette\nName: red\n#\n255 0 0 #ff0000\n0 0 255 Blue", "#ff0000"),
    ],
)
def test_a_palette_may_be_a_file(photo: Path, asked: Asked, text: str, palette: str) -> None:
    colors = photo.with_name("colors.txt")
    colors.write_text(text)
    _run(photo, "--palette", colors)
    assert asked[0][0].palette == palette


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("red, green and #12345678", ["--palette must be a file of colours such as red and #a0b1c2, got 'and' in "]),
        ("red\ncrimsn\n#00f", ["got 'crimsn' in ", "colors.txt", "; correct the word"]),
        ("#fff\n#12345", ["got '#12345' in "]),
        ("255 0 0", ["--palette must be a file with colours such as #a0b1c2", "colors.txt"]),
        ("", ["--palette must be a file with colours such as #a0b1c2", "colors.txt"]),
    ],
)
def test_a_palette_file_with_a_wrong_word_or_no_colours_is_refused(photo: Path, text: str, words: list[str]) -> None:
    colors = photo.with_name("colors.txt")
    colors.write_text(text)
    assert_refused(invoke("run", photo, photo.with_name("out.svg"), "--palette", colors), *words)


def test_file_options_come_from_the_command_line_or_a_file(photo: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[FileOptions] = []

    def record(request: Request, *_: Any) -> None:
        seen.append(request.encoding.options)
        raise Seen

    monkeypatch.setattr(choice, "draw_picture", record)
    settings = photo.with_name("settings.toml")
    settings.write_text("no-metadata = true\ntrim = true\nsize = '3 cm'")
    for options in ([], ["--trim"], ["--no-metadata", "--size", "200%"], ["--config", settings]):
        _run(photo, *options)
    both = FileOptions(no_metadata=True, trim=True, size="3cm")
    assert seen == [FileOptions(), FileOptions(trim=True), FileOptions(no_metadata=True, size="200%"), both]
    assert file_options(dict.fromkeys(settings_of(FileOptions))) == FileOptions()
