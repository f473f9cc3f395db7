"""ICC profiles of images: their colours become sRGB."""

from __future__ import annotations

from io import BytesIO

from PIL import Image, ImageCms


def to_srgb(image: Image.Image) -> Image.Image:
    """The colour of an 8 bit image without its alpha, mode RGB, through its ICC profile if it has a usable one."""
    try:
        profile = ImageCms.ImageCmsProfile(BytesIO(image.info["icc_profile"]))
        mode = _profile_mode(image.mode, profile.profile.xcolor_space)
        if mode is None:
            return image.convert("RGB")
        # The default intent, perceptual, is what browsers use; a profile without its table falls back by itself.
        # Little CMS samples what is no matrix on a coarse grid: off by 10 levels in the darks of a linear grey.
        flags = ImageCms.Flags.NOOPTIMIZE if mode == "L" else ImageCms.Flags.HIGHRESPRECALC
        transform = ImageCms.buildTransform(profile, ImageCms.createProfile("sRGB"), mode, "RGB", flags=flags)
        return transform.apply(image.convert(mode))
    except (KeyError, OSError, ImageCms.PyCMSError):
        # No profile, or a damaged one: sRGB, as viewers do.
        return image.convert("RGB")


def _profile_mode(image_mode: str, space: str) -> str | None:
    """The mode in which the pixels enter a profile of colour space ``space``, None when it is not theirs."""
    if image_mode == "CMYK":
        return "CMYK" if space.strip() == "CMYK" else None
    if space.strip() == "GRAY":
        return "L" if image_mode in ("1", "L", "LA") else None
    # Grey with an RGB profile is common (tools drop the channels and keep the tag): v means (v, v, v).
    return "RGB" if space.strip() == "RGB" else None
