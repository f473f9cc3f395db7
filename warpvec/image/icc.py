"""Convert images with ICC profiles to sRGB."""

from __future__ import annotations

from io import BytesIO

from PIL import Image, ImageCms


def to_srgb(image: Image.Image) -> Image.Image:
    """Return the colours of an 8-bit image in sRGB, mode RGB without alpha, using its ICC profile if it is valid."""
    try:
        profile = ImageCms.ImageCmsProfile(BytesIO(image.info["icc_profile"]))
        mode = _profile_mode(image.mode, profile.profile.xcolor_space)
        if mode is None:
            return image.convert("RGB")
        # The default intent, perceptual, is what browsers use; Little CMS falls back if the profile has no table for
        # it. It samples profiles without a matrix on a coarse grid: off by 10 levels in the darks of a linear grey.
        flags = ImageCms.Flags.NOOPTIMIZE if mode == "L" else ImageCms.Flags.HIGHRESPRECALC
        transform = ImageCms.buildTransform(profile, ImageCms.createProfile("sRGB"), mode, "RGB", flags=flags)
        return transform.apply(image.convert(mode))
    except (KeyError, OSError, ImageCms.PyCMSError):
        # No profile or a damaged one: take it as sRGB, as viewers do.
        return image.convert("RGB")


def _profile_mode(image_mode: str, space: str) -> str | None:
    """Return the mode that a profile of colour space ``space`` takes, None if it does not fit the image."""
    if image_mode == "CMYK":
        return "CMYK" if space.strip() == "CMYK" else None
    if space.strip() == "GRAY":
        return "L" if image_mode in ("1", "L", "LA") else None
    # Grey with an RGB profile is common, because tools drop channels and keep the profile: v means (v, v, v).
    return "RGB" if space.strip() == "RGB" else None
