"""Videos of a fit: all frames in their size, and no file without frames or after an error."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from commands import QUICK, assert_refused, invoke, write_photo
from numpy.typing import NDArray
from PIL import Image
from stubs import stub_fit
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.errors import InputError
from warpvec.image import video
from warpvec.image.video import EXTENSIONS, FRAMES_PER_SECOND, Video, check_video
from warpvec.modes import photo as photo_mode
from warpvec.watch.progress import Progress
from warpvec.watch.watch import FitResult, Part

KINDS = [
    pytest.param(extension, marks=pytest.mark.skipif(missing, reason="needs imageio-ffmpeg, the extra video"))
    for extension in EXTENSIONS
    for missing in [extension == ".mp4" and find_spec("imageio_ffmpeg") is None]
]


def _read(path: Path) -> tuple[NDArray[np.uint8], float]:
    """Return the frames [n, h, w, 3] of a video and its frame rate."""
    if path.suffix == ".mp4":
        from imageio_ffmpeg import get_ffmpeg_exe

        command = [get_ffmpeg_exe(), "-i", path, "-f", "rawvideo", "-pix_fmt", "rgb24", "-"]
        run = subprocess.run(command, capture_output=True, check=True)
        facts = re.search(rb"Video: h264 .*, (\d+)x(\d+).*, ([\d.]+) fps", run.stderr)
        assert facts is not None
        return np.frombuffer(run.stdout, np.uint8).reshape(-1, int(facts[2]), int(facts[1]), 3), float(facts[3])
    with Image.open(path) as image:
        frames, durations = [], []
        for index in range(image.n_frames):
            image.seek(index)
            frames.append(np.asarray(image.convert("RGB")))
            durations.append(image.info["duration"])
        assert image.info["loop"] == 0
    return np.stack(frames), 1000 * len(durations) / sum(durations)


def _blocks(index: int, height: int = 36, width: int = 50) -> NDArray[np.float32]:
    """Return a grey image that is different for each frame: lighter, and with its block elsewhere."""
    image = np.full((height, width, 3), 0.2 + 0.04 * index, np.float32)
    image[: height // 2, 2 * index : 2 * index + 8] = 0.0
    return image


@pytest.mark.parametrize("extension", KINDS)
def test_a_video_has_every_frame(extension: str, tmp_path: Path) -> None:
    path = tmp_path / f"fit{extension}"
    with Video(str(path)) as film:
        for index in range(19):
            film.add(_blocks(index))
        film.finish()
    frames, rate = _read(path)
    assert frames.shape == (19, 36, 50, 3)
    assert rate == pytest.approx(FRAMES_PER_SECOND, rel=0.05)  # GIF counts in hundredths of a second
    for index, frame in enumerate(frames):
        assert np.abs(frame / 255.0 - _blocks(index)).mean() < 0.03
    assert os.listdir(tmp_path) == [path.name]


@pytest.mark.parametrize("extension", KINDS)
@pytest.mark.parametrize(("height", "width"), [(35, 51), (1, 1), (2, 33)])
def test_odd_sides_and_single_frames_are_playable(extension: str, height: int, width: int, tmp_path: Path) -> None:
    path = tmp_path / f"fit{extension}"
    with Video(str(path)) as film:
        film.add(np.full((height, width, 3), 0.5, np.float32))
        film.finish()
    if extension == ".mp4":
        frames, _ = _read(path)
        assert frames.shape == (1, height + height % 2, width + width % 2, 3)
    else:
        with Image.open(path) as image:
            assert image.size == (width, height)


def test_alpha_is_shown_over_white_and_overshoot_is_clipped(tmp_path: Path) -> None:
    path = tmp_path / "fit.gif"
    with Video(str(path)) as film:
        film.add(np.array([[[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.5], [1.5, -0.5, 0.0, 1.0]]], np.float32))
        film.add(np.zeros((1, 3, 4), np.float32))
        film.finish()
    frames, _ = _read(path)
    assert frames[0].tolist() == [[[255, 255, 255], [128, 128, 128], [255, 0, 0]]]


@pytest.mark.parametrize("extension", KINDS)
def test_memory_does_not_grow_with_the_number_of_frames(extension: str, tmp_path: Path) -> None:
    # In a process of its own, as the peak of this one is that of an earlier test. 160 frames are 92 MB of pixels.
    code = f"""if True:
        import resource
        import numpy as np
        from warpvec.image.video import Video
        peaks = []
        with Video({str(tmp_path / "fit")!r} + {extension!r}) as film:
            for index in range(160):
                film.add(np.full((400, 480, 3), index / 160, np.float32))
                peaks.append(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
            film.finish()
        print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - peaks[40])"""
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert int(run.stdout) < 40_000  # kB


def test_equal_frames_of_a_webp_keep_their_time(tmp_path: Path) -> None:
    path = tmp_path / "fit.webp"
    with Video(str(path)) as film:
        for index in range(17):
            film.add(_blocks(index // 16))
        film.finish()
    with Image.open(path) as image:
        durations = []
        for index in range(image.n_frames):
            image.seek(index)
            image.load()
            durations.append(image.info["duration"])
    assert durations[-1] == 83
    assert sum(durations) == 17 * 83


@pytest.mark.parametrize("error", [None, ValueError, KeyboardInterrupt])
def test_without_frames_or_after_an_error_there_is_no_file(tmp_path: Path, error: type[BaseException] | None) -> None:
    def film() -> None:
        with Video(str(tmp_path / "fit.gif")) as taken:
            if error is not None:
                taken.add(_blocks(0))
                raise error
            taken.finish()

    if error is None:
        film()
    else:
        with pytest.raises(error):
            film()
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize("extension", KINDS)
def test_a_video_that_cannot_be_written_leaves_the_older_one(
    extension: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / f"fit{extension}"
    path.write_bytes(b"older")

    def fail(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", fail)
    with Video(str(path)) as film:
        film.add(_blocks(0))
        with pytest.raises(OSError, match="No space"):
            film.finish()
    assert path.read_bytes() == b"older"
    assert os.listdir(tmp_path) == [path.name]


@pytest.mark.parametrize("name", ["fit.avi", "fit", "fit.png", ".gif", "missing/fit.gif"])
def test_other_names_are_refused(name: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="^video must ") as caught:
        check_video(str(tmp_path / name))
    assert "\n" not in str(caught.value)


def test_mp4_without_its_encoder_says_what_to_install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(video, "find_spec", lambda _: None)
    with pytest.raises(InputError, match="needs imageio-ffmpeg for MP4, .*; pip install 'warpvec\\[video\\]'"):
        check_video(str(tmp_path / "fit.MP4"))
    check_video(str(tmp_path / "fit.gif"))


# On the command line.


@pytest.fixture
def photo(tmp_path: Path) -> Path:
    return write_photo(tmp_path)


@pytest.mark.parametrize("extension", KINDS)
def test_run_films_the_fit(extension: str, photo: Path) -> None:
    path = photo.with_name(f"fit{extension}")
    result = invoke("run", photo, photo.with_name("out.svg"), "--curves", "8", "--iterations", "9", "--every", "2",
                    "--video", path, "--save-frames", photo.with_name("frames"), "-q")  # fmt: skip
    assert result.exit_code == 0, result.output
    frames, rate = _read(path)
    assert frames.shape[1:] == (32, 48, 3)
    # 2, 4, 6, 8 and the last; GIF and WebP show equal ones as one, for longer.
    assert round(len(frames) / rate * FRAMES_PER_SECOND) == 5
    with Image.open(photo.with_name("frames") / "frame-000009.png") as last:
        assert np.abs(frames[-1].astype(float) - np.asarray(last.convert("RGB"))).mean() < 12


def test_an_interrupted_fit_leaves_its_video_so_far(photo: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    real = Part.report

    def interrupt_at_six(part: Part, progress: Progress, **options: bool) -> None:
        real(part, progress, **options)
        if progress.iteration == 6:
            signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(Part, "report", interrupt_at_six)
    path, out = photo.with_name("fit.gif"), photo.with_name("out.svg")
    result = invoke("run", photo, out, "--curves", "8", "--iterations", "50", "--every", "2", "--video", path)
    assert result.exit_code == 130
    assert _read(path)[0].shape == (3, 32, 48, 3)
    assert out.exists()


def test_an_error_in_the_fit_leaves_no_video(photo: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(target: Tensor, config: FitConfig, part: Part, **_: object) -> FitResult:
        stub_fit(target, config, part)
        raise RuntimeError("the reactor is hot")

    monkeypatch.setattr(photo_mode, "fit", fail)
    result = invoke(
        "run", photo, photo.with_name("out.svg"), *QUICK, "--every", "1", "--video", photo.with_name("a.gif")
    )
    assert result.exit_code == 1
    assert "the reactor is hot" in result.output
    assert os.listdir(photo.parent) == ["photo.png"]


def test_a_wrong_name_is_refused_before_the_fit(photo: Path) -> None:
    result = invoke("run", photo, photo.with_name("out.svg"), *QUICK, "--video", photo.with_name("fit.avi"),
                    "--write-config", photo.with_name("settings.toml"))  # fmt: skip
    assert_refused(result, "--video must end in .mp4, .gif, .webp", "fit.avi")
    assert os.listdir(photo.parent) == ["photo.png"]
