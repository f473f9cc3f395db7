"""Levels of detail: kept layers keep their bytes, and each prefix of the layers is a picture."""

from __future__ import annotations

import gzip
import json
import re
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result
from commands import assert_refused, invoke
from PIL import Image
from svg_files import make_scene

from warpvec.cli.commands.lod import lod
from warpvec.errors import InputError
from warpvec.svg.layers import parse_levels, prefixes, read_layers, select_levels
from warpvec.svg.measure import draw, file_quality
from warpvec.svg.read import read_svg
from warpvec.svg.write import write_svg

NS = 'xmlns="http://www.w3.org/2000/svg"'
TEXT = write_svg(make_scene(30, size=(96, 64)), 96, 64, title="a > b", metadata={"curves": 30})


def layer(level: int) -> str:
    """Return the group of one level in ``TEXT``, with its lines."""
    found = re.search(rf'<g id="layer-\d+-generation-{level}".*?</g>\n', TEXT, re.DOTALL)
    assert found is not None
    return found[0]


def refusal(function, *arguments) -> str:
    with pytest.raises(InputError) as caught:
        function(*arguments)
    return str(caught.value)


def test_the_layers_are_where_the_text_has_them():
    layers = read_layers(TEXT)
    assert [found.level for found in layers] == [0, 1, 2]
    assert [TEXT.encode()[found.start : found.stop].decode() for found in layers] == [layer(k) for k in range(3)]
    assert [found.painted_count for found in layers] == [10, 10, 10]


@pytest.mark.parametrize("levels", [{0}, {1}, {0, 2}, {0, 1, 2}, set()])
def test_kept_layers_keep_their_bytes(levels):
    expected = TEXT
    for level in {0, 1, 2} - levels:
        expected = expected.replace(layer(level), "")
    assert select_levels(TEXT, levels) == expected
    assert select_levels(gzip.compress(TEXT.encode()), levels) == expected


def test_prefixes_grow_to_the_whole_file():
    found = list(prefixes(TEXT))
    assert [level for level, _ in found] == [0, 1, 2]
    assert [len(read_svg(text).scene) for _, text in found] == [10, 20, 30]
    assert found[-1][1] == TEXT


def test_layers_of_one_level_go_together():
    text = TEXT.replace("generation-2", "generation-0")
    assert [len(read_svg(prefix).scene) for _, prefix in prefixes(text)] == [20, 30]


@pytest.mark.parametrize(
    ("content", "kept"),
    [
        ("<g><path/></g><g><g/></g><path/>", "<g><path/></g><path/>"),
        ("\n  <g/>\n\t<g a='/>'/>\r\n  <path/>\n", "\n  <g/>\n  <path/>\n"),
        ("<g/><g id='\u00e9 > \"'></g >\n<g/>", "<g/>\n<g/>"),
        ("<!-- <g> --><g/>x <g><![CDATA[</g>]]></g> y", "<!-- <g> --><g/>x  y"),
        ("<svg><g/></svg><g/><g/><svg/>", "<svg><g/></svg><g/><svg/>"),
        ('<g/><x:g xmlns:x="http://x"/><g/>', '<g/><x:g xmlns:x="http://x"/>'),
    ],
)
def test_groups_at_the_top_are_the_levels_of_other_files(content, kept):
    text = f"\ufeff<?xml version='1.0'?><svg {NS}>{content}</svg>"
    levels = {found.level for found in read_layers(text)} - {1}
    assert select_levels(text, levels) == text.replace(content, kept)


@pytest.mark.parametrize(
    ("text", "levels"),
    [
        ("2", {2}), ("0-3", {0, 1, 2, 3}), ("-3", {0, 1, 2, 3}), ("3-", {3, 5, 6}), ("0, 5-6", {0, 5, 6}),
        ("0-6", {0, 1, 2, 3, 5, 6}), ("5-5", {5}),
    ],
)  # fmt: skip
def test_levels_are_named_like_pages_to_print(text, levels):
    assert parse_levels(text, [0, 1, 2, 3, 5, 6]) == levels


@pytest.mark.parametrize("text", ["", "-", "a", "1,,2", "1--2", "-1-2", "1.5", "\u0662", "9" * 5000])
def test_text_that_is_not_a_list_of_levels_is_refused(text):
    assert "levels must be like 2, 0-3" in refusal(parse_levels, text, [0, 1, 2])


@pytest.mark.parametrize("text", ["3", "0,7-9", "2-1", "0-3", "-3"])
def test_levels_that_the_file_does_not_have_are_refused(text):
    assert f"got {text.split(',')[-1]!r}; choose from 0, 1, 2" in refusal(parse_levels, text, [0, 1, 2])


def test_a_file_without_groups_has_no_levels():
    assert "group its paths" in refusal(list, prefixes(f"<svg {NS}><path/></svg>"))


def run(*arguments: object) -> Result:
    """Run the command without the handler that prints its errors in one line."""
    return CliRunner().invoke(lod, [str(argument) for argument in arguments])


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "drawing.svg"
    path.write_text(TEXT)
    return path


def test_some_levels_are_written_to_a_file(file, tmp_path):
    for name in ("small.svg", "small.svgz"):
        assert run(file, "--levels", "0-1", "-o", tmp_path / name).exit_code == 0
        data = (tmp_path / name).read_bytes()
        text = gzip.decompress(data) if name.endswith("z") else data
        assert text.decode() == TEXT.replace(layer(2), "")


def test_some_levels_are_written_to_stdout_alone(file):
    result = run(file, "--levels", "1", "-o", "-", "--list")
    assert result.stdout == TEXT.replace(layer(0), "").replace(layer(2), "")
    assert "level" in result.stderr


def test_split_writes_a_file_for_each_prefix(file, tmp_path):
    result = run(file, "--split")
    names = [tmp_path / f"drawing-level-{level}.svg" for level in range(3)]
    assert result.stdout.split() == [str(name) for name in names]
    assert [name.read_text() for name in names] == [text for _, text in prefixes(TEXT)]
    assert len(list(tmp_path.iterdir())) == 4


def test_the_list_has_paths_bytes_and_psnr_of_each_prefix(file, tmp_path):
    photo = tmp_path / "photo.png"
    Image.fromarray(draw(TEXT)).save(photo)
    rows = json.loads(run(file, "--image", photo, "--json").stdout)
    texts = [text for _, text in prefixes(TEXT)]
    counts = [(row["level"], row["paths"], row["prefix_paths"]) for row in rows]
    assert counts == [(0, 10, 10), (1, 10, 20), (2, 10, 30)]
    assert [row["prefix_bytes"] for row in rows] == [len(text.encode()) for text in texts]
    pixels = np.asarray(Image.open(photo), np.float32) / 255
    assert [row["prefix_psnr"] for row in rows[:2]] == [file_quality(text, pixels)["psnr"] for text in texts[:2]]
    assert rows[2]["prefix_psnr"] is None
    table = run(file, "--image", photo).stdout.splitlines()
    assert len(table) == 4 and "PSNR" in table[0] and table[3].endswith("inf dB")
    assert "PSNR" not in run(file).stdout


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--levels", "0"], "--levels must be given with -o"),
        (["-o", "a.svg"], "-o must be given with --levels"),
        (["--levels", "9", "-o", "a.svg"], "levels must name levels of the file, got '9'"),
        (["--levels", "0", "-o", "a.png"], "must end in .svg"),
        (["--levels", "0", "-o", "nowhere/a.svg"], "existing folder"),
        (["--image", "nowhere.png"], "nowhere.png"),
    ],
)
def test_mistakes_are_refused_and_nothing_is_written(file, tmp_path, monkeypatch, arguments, words):
    monkeypatch.chdir(tmp_path)
    result = run(file, *arguments)
    assert isinstance(result.exception, InputError)
    assert words in str(result.exception)
    assert list(tmp_path.iterdir()) == [file]


def test_the_command_is_one_of_warpvec(file):
    assert_refused(invoke("lod", file, "--levels", "x", "-o", "a.svg"), "levels must be like")
    assert_refused(invoke("lod", file.with_name("none.svg")), "none.svg")
