"""Which formats of pictures are read right: files by real programs, each compared with the picture that it was made of.

A file is drawn right if no pixel is more than ``FAR`` levels off, refused if one line says so, and else wrong. What a
program that is not installed would write is left out. The programs: ImageMagick 6 (``convert``), netpbm, and the
packages Pillow, tifffile, imagecodecs, psd-tools, pillow-heif, OpenEXR and pyora.
"""

from __future__ import annotations

import argparse
import subprocess
import tempfile
from collections.abc import Callable, Iterator
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from warpvec.errors import InputError
from warpvec.image.read import read_image

Pixels = NDArray[np.uint8]

FAR = 24
"""Most levels that a lossy format may change a pixel by: the pictures are flat but for their edges on blocks of 8."""


class Format(NamedTuple):
    """A format, and what writes it.

    Attributes:
        name: of the format, as people call it.
        program: that writes the file.
        picture: one of `pictures`.
        write: makes the file at a path, of the picture and its PNG at another path.
    """

    name: str
    program: str
    picture: str
    write: Callable[[Path, Pixels, Path], object]


def pictures() -> dict[str, Pixels]:
    """Return pictures [32, 48, 3 or 4]: of colours, grey, black and white, and with alpha."""
    image = Image.new("RGB", (48, 32), (240, 240, 230))
    draw = ImageDraw.Draw(image)
    draw.rectangle((8, 8, 23, 23), fill=(200, 40, 40))
    draw.rectangle((24, 0, 39, 15), fill=(30, 90, 200))
    draw.rectangle((32, 24, 47, 31), fill=(20, 140, 70))
    colors = np.asarray(image)
    grey = np.repeat(np.asarray(image.convert("L"))[..., None], 3, 2)
    alpha = np.full((32, 48, 1), 255, np.uint8)
    alpha[:, :8] = 0
    return {
        "colours": colors, "grey": grey, "bilevel": np.where(grey > 128, 255, 0).astype(np.uint8),
        "alpha": np.dstack([colors, alpha]),
    }  # fmt: skip


def _convert(suffix: str, *options: str) -> Callable[[Path, Pixels, Path], object]:
    def write(path: Path, _: Pixels, png: Path) -> None:
        subprocess.run(["/usr/bin/convert", png, *options, f"{suffix}:{path}"], check=True, capture_output=True)

    return write


def _netpbm(program: str, *options: str) -> Callable[[Path, Pixels, Path], object]:
    def write(path: Path, _: Pixels, png: Path) -> None:
        pnm = subprocess.run(["pngtopnm", png], check=True, capture_output=True).stdout
        done = subprocess.run([program, *options], input=pnm, check=True, capture_output=True)
        path.write_bytes(done.stdout)

    return write


def _pillow(format: str, **options: Any) -> Callable[[Path, Pixels, Path], object]:
    def write(path: Path, pixels: Pixels, _: Path) -> None:
        Image.fromarray(pixels).save(path, format, **options)

    return write


def _tifffile(change: Callable[[Pixels], NDArray[Any]], **options: Any) -> Callable[[Path, Pixels, Path], object]:
    def write(path: Path, pixels: Pixels, _: Path) -> None:
        import_module("tifffile").imwrite(path, change(pixels), **options)

    return write


def _imagecodecs(name: str, **options: Any) -> Callable[[Path, Pixels, Path], object]:
    def write(path: Path, pixels: Pixels, _: Path) -> None:
        path.write_bytes(getattr(import_module("imagecodecs"), f"{name}_encode")(pixels, **options))

    return write


def _psd_tools(path: Path, pixels: Pixels, _: Path) -> None:
    import_module("psd_tools").PSDImage.frompil(Image.fromarray(pixels)).save(path)


def _heif(path: Path, pixels: Pixels, _: Path) -> None:
    import_module("pillow_heif").from_pillow(Image.fromarray(pixels)).save(path, quality=95)


def _exr(path: Path, pixels: Pixels, _: Path) -> None:
    exr, levels = import_module("OpenEXR"), pixels / 255
    light = np.where(levels <= 0.04045, levels / 12.92, ((levels + 0.055) / 1.055) ** 2.4).astype(np.float32)
    header = {"compression": exr.ZIP_COMPRESSION, "type": exr.scanlineimage}
    exr.File(header, {"RGB": light}).write(str(path))


def _ora(path: Path, pixels: Pixels, _: Path) -> None:
    project = import_module("pyora").Project.new(pixels.shape[1], pixels.shape[0])
    project.add_layer(Image.fromarray(pixels), "layer")
    project.save(str(path))


_MAGICK = "ImageMagick"

FORMATS = (
    Format("PNG", _MAGICK, "alpha", _convert("png")),
    Format("PNG, 16 bits", _MAGICK, "colours", _convert("png", "-depth", "16")),
    Format("JPEG", _MAGICK, "colours", _convert("jpg", "-quality", "95")),
    Format("JPEG, CMYK", _MAGICK, "colours", _convert("jpg", "-colorspace", "CMYK", "-quality", "95")),
    Format("GIF", _MAGICK, "alpha", _convert("gif")),
    Format("WebP", _MAGICK, "alpha", _convert("webp", "-define", "webp:lossless=true")),
    Format("BMP", _MAGICK, "colours", _convert("bmp3")),
    Format("BMP with alpha", _MAGICK, "alpha", _convert("bmp")),
    Format("TIFF, LZW", _MAGICK, "alpha", _convert("tiff", "-compress", "lzw")),
    Format("TIFF, CMYK", _MAGICK, "colours", _convert("tiff", "-colorspace", "CMYK")),
    Format("TIFF, fax", _MAGICK, "bilevel", _convert("tiff", "-monochrome", "-compress", "group4")),
    Format("TIFF, 16 bits, planar", "tifffile", "colours", _tifffile(
        lambda p: np.ascontiguousarray(p.transpose(2, 0, 1)).astype(np.uint16) * 257,
        photometric="rgb", planarconfig="separate")),
    Format("TIFF, float RGB", "tifffile", "colours", _tifffile(
        lambda p: (p / 255).astype(np.float32), photometric="rgb")),
    Format("TIFF, float grey", "tifffile", "grey", _tifffile(lambda p: (p[..., 0] / 255).astype(np.float32))),
    Format("PSD", _MAGICK, "colours", _convert("psd")),
    Format("PSD with alpha", _MAGICK, "alpha", _convert("psd")),
    Format("PSD with a layer", "psd-tools", "colours", _psd_tools),
    Format("PSB", _MAGICK, "colours", _convert("psb")),
    Format("PBM", _MAGICK, "bilevel", _convert("pbm")),
    Format("PBM, text", _MAGICK, "bilevel", _convert("pbm", "-compress", "none")),
    Format("PGM, 16 bits", _MAGICK, "grey", _convert("pgm", "-depth", "16")),
    Format("PGM, text", "netpbm", "grey", _netpbm("pnmtoplainpnm")),
    Format("PPM", _MAGICK, "colours", _convert("ppm")),
    Format("PAM with alpha", _MAGICK, "alpha", _convert("pam")),
    Format("ICO", _MAGICK, "alpha", _convert("ico")),
    Format("TGA", "netpbm", "colours", _netpbm("ppmtotga", "-rgb")),
    Format("TGA with alpha", "Pillow", "alpha", _pillow("TGA")),
    Format("PCX", _MAGICK, "colours", _convert("pcx")),
    Format("DDS", _MAGICK, "colours", _convert("dds", "-define", "dds:compression=none")),
    Format("JPEG 2000", _MAGICK, "colours", _convert("jp2", "-quality", "100")),
    Format("QOI", "imagecodecs", "alpha", _imagecodecs("qoi")),
    Format("AVIF", "Pillow", "alpha", _pillow("AVIF", quality=95, subsampling="4:4:4")),
    Format("HEIC", "pillow-heif", "colours", _heif),
    Format("JPEG XL", "imagecodecs", "colours", _imagecodecs("jpegxl", lossless=True)),
    Format("JPEG XR", "imagecodecs", "colours", _imagecodecs("jpegxr", level=1.0)),
    Format("SGI", _MAGICK, "colours", _convert("sgi")),
    Format("Sun raster", _MAGICK, "colours", _convert("sun")),
    Format("XBM", _MAGICK, "bilevel", _convert("xbm")),
    Format("XPM", _MAGICK, "colours", _convert("xpm")),
    Format("FITS", _MAGICK, "grey", _convert("fits")),
    Format("Radiance HDR", _MAGICK, "colours", _convert("hdr")),
    Format("MIFF", _MAGICK, "colours", _convert("miff")),
    Format("PDF", _MAGICK, "colours", _convert("pdf")),
    Format("PDF of a scan", "Pillow", "colours", _pillow("PDF", resolution=300.0, quality=95, subsampling=0)),
    Format("TIFF, CMYK with alpha", "tifffile", "colours", _tifffile(
        lambda p: np.dstack([255 - p, np.zeros_like(p[..., 0]), np.full_like(p[..., 0], 255)]),
        photometric="separated", extrasamples=["unassalpha"])),
    Format("OpenEXR", "OpenEXR", "colours", _exr),
    Format("OpenRaster", "pyora", "alpha", _ora),
)  # fmt: skip


def judged(format: Format, folder: Path) -> str | None:
    """Return "right", "wrong by N levels", or "refused" with the remedy; None if the program is not there."""
    pixels = pictures()[format.picture]
    png, path = folder / "picture.png", folder / "file"
    Image.fromarray(pixels).save(png)
    try:
        format.write(path, pixels, png)
    except (ImportError, FileNotFoundError, subprocess.CalledProcessError):
        return None
    try:
        found = read_image(path.read_bytes())
    except InputError as error:
        return f"refused: {error.remedy}"
    return _compared(found, pixels)


def _compared(found: NDArray[np.float32], pixels: Pixels) -> str:
    wanted = pixels.astype(float)
    if found.shape[:2] != wanted.shape[:2]:
        return f"wrong size: {found.shape[1]} x {found.shape[0]}"
    if found.shape[2] != wanted.shape[2]:
        return f"wrong: {found.shape[2]} channels of {wanted.shape[2]}"
    levels = found * 255.0
    if wanted.shape[2] == 4:
        levels, wanted = (each * (each[..., 3:] > 127) for each in (levels, wanted))
    off = float(np.abs(levels - wanted).max())
    return "right" if off <= FAR else f"wrong by {off:.0f} levels"


def rows() -> Iterator[tuple[Format, str]]:
    """Yield each format that can be written here, and the judgement."""
    for format in FORMATS:
        with tempfile.TemporaryDirectory() as folder:
            found = judged(format, Path(folder))
        if found is not None:
            yield format, found


def main() -> None:
    """Print the table, and how many formats are drawn right."""
    argparse.ArgumentParser(description=__doc__).parse_args()
    print("| format | written by | read |\n|---|---|---|")
    found = list(rows())
    for format, words in found:
        print(f"| {format.name} | {format.program} | {words} |")
    right = sum(words == "right" for _, words in found)
    wrong = sum(words.startswith("wrong") for _, words in found)
    print(f"\n{right} of {len(found)} right, {wrong} wrong, {len(found) - right - wrong} refused")


if __name__ == "__main__":
    main()
