"""Test that the sdist and the wheel contain what the checkout contains, and that the wheel works elsewhere."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from pathlib import Path

import pytest
from PIL import Image

import warpvec

ROOT = Path(__file__).resolve().parents[1]

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A wheel built from an sdist, which is built from a copy of the sources."""
    pytest.importorskip("build")
    copy, dist = tmp_path_factory.mktemp("sources") / "warpvec", tmp_path_factory.mktemp("dist")
    # A copy, because building writes folders beside the sources; symbolic links must survive.
    ignored = shutil.ignore_patterns(".*", "__pycache__", "*.egg-info", "build", "dist")
    shutil.copytree(ROOT, copy, symlinks=True, ignore=ignored)
    # No network is needed, because the back end is in the extra "test".
    command = [sys.executable, "-m", "build", "--no-isolation", "--outdir", str(dist), str(copy)]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    (path,) = dist.glob("*.whl")
    return path


@pytest.fixture(scope="module")
def site(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with only the unpacked wheel."""
    folder = tmp_path_factory.mktemp("site")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(folder)
    return folder


def _sources(folder: Path) -> dict[str, bytes]:
    paths = (path for path in sorted(folder.rglob("*.py")) if "kernels" not in path.relative_to(folder).parts)
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in paths}


@pytest.mark.parametrize(("packed", "source"), [("warpvec", "warpvec"), ("warpvec/kernels", "kernels")])
def test_the_wheel_contains_every_module_unchanged(site: Path, packed: str, source: str) -> None:
    expected = _sources(ROOT / source)
    assert len(expected) > 5
    assert _sources(site / packed) == expected


def test_the_wheel_contains_nothing_else(site: Path) -> None:
    assert sorted(path.name for path in site.iterdir()) == ["warpvec", f"warpvec-{warpvec.__version__}.dist-info"]
    others = {path.name for path in site.glob("warpvec/**/*") if path.is_file() and path.suffix != ".py"}
    folders = (f"{room}/assets/*" for room in ("app", "viewer"))
    kept = [
        path.name for pattern in (*folders, "inkscape/extension/*.inx") for path in (ROOT / "warpvec").glob(pattern)
    ]
    assert others == {"py.typed", "__init__.pyi", *kept}


def test_the_wheel_states_version_licence_and_command(site: Path) -> None:
    info = site / f"warpvec-{warpvec.__version__}.dist-info"
    metadata = (info / "METADATA").read_text(encoding="utf-8")
    assert f"\nVersion: {warpvec.__version__}\n" in metadata
    assert "\nLicense-Expression: Apache-2.0\n" in metadata
    assert (info / "licenses" / "LICENSE").read_bytes() == (ROOT / "LICENSE").read_bytes()
    assert "warpvec = warpvec.__main__:main" in (info / "entry_points.txt").read_text(encoding="utf-8")


def test_the_sdist_contains_the_kernels_once(wheel: Path) -> None:
    (path,) = wheel.parent.glob("*.tar.gz")
    with tarfile.open(path) as archive:
        names = [name.partition("/")[2] for name in archive.getnames()]
    assert {f"warpvec/kernels/{name}" for name in _sources(ROOT / "kernels")} <= set(names)
    assert not [name for name in names if name.startswith("kernels/")]


def _run_from(site: Path, folder: Path, *arguments: str) -> str:
    """Run Python in ``folder`` with the wheel first on its path and the current folder left out; return its output."""
    environment = {**os.environ, "PYTHONPATH": str(site)}
    command = [sys.executable, "-P", *arguments]
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=True).stdout


def test_the_installed_wheel_finds_its_own_kernels(site: Path, tmp_path: Path) -> None:
    code = "import warpvec.kernels.coverage as k, warpvec; print(k.__file__); print(warpvec.__file__)"
    lines = _run_from(site, tmp_path, "-c", code).splitlines()[-2:]
    expected = [site / "warpvec" / "kernels" / "coverage.py", site / "warpvec" / "__init__.py"]
    assert [Path(line) for line in lines] == expected


def test_the_installed_wheel_turns_a_photo_into_an_svg(site: Path, tmp_path: Path) -> None:
    Image.linear_gradient("L").resize((24, 16)).save(tmp_path / "photo.png")
    _run_from(site, tmp_path, "-m", "warpvec", "run", "photo.png", "out.svg", "--curves", "4", "--iterations", "10")
    assert (tmp_path / "out.svg").read_text(encoding="utf-8").endswith("</svg>\n")


def test_every_dependency_has_a_reason() -> None:
    text = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    for requirement in tomllib.loads(text)["project"]["dependencies"]:
        (line,) = (line for line in text.splitlines() if line.strip().startswith(f'"{requirement}"'))
        assert "# " in line, f"{requirement} has no reason beside it"


def test_the_kernels_are_a_link_in_the_checkout() -> None:
    link = ROOT / "warpvec" / "kernels"
    assert link.is_symlink()
    assert link.readlink() == Path("../kernels")
