"""Checkpoints with arrays, numbers and settings replaced, and damaged archives: read, and resumed if they are accepted.

A change to a checkpoint is a path in its header ("state.population.age"), a kind of change and a value, so that the
corpus can hold it as a line of text: see `changed`.
"""

from __future__ import annotations

import io
import json
import struct
import tempfile
import zipfile
from copy import deepcopy
from dataclasses import replace
from functools import cache
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
from numpy.typing import NDArray
from torture_case import OK, Case, Wrong
from torture_changes import mutate

SETTINGS: dict[str, dict[str, Any]] = {
    "plain": {},
    "palette": {"colors": 3},
    "given palette": {"palette": "red,#123,#fff"},
    "opaque": {"opacity": "opaque"},
    "lod": {"lod": True},
    "area": {"z_order": "area", "flat": True},
    "growing": {"initial_curves": 2, "inflation_gap": 2, "recycle_gap": 2, "iterations": 8},
    "replacement": {"policy": "replacement", "replace_gap": 2, "iterations": 8},
    "gradients": {"gradients": 0.5, "iterations": 8},
    "splat": {"renderer": "splat", "samples": 8, "lines": 4},
    "sides": {"renderer": "splat", "path_model": "sides", "degree": 3, "samples": 8, "lines": 4},
    "nodes": {"recycle_gap": 6, "iterations": 56, "xing_weight": 0.5},
    "short file": {"minify": True, "recycle_gap": 6, "iterations": 56},
    "transparent": {"gradients": 0.5, "iterations": 8},
    "given paths": {"gradients": 0.6, "iterations": 8},
}
"""Fits whose states differ in what they hold."""

DRAWING = """<svg xmlns="http://www.w3.org/2000/svg" width="32" height="24"><defs>
<linearGradient id="a" gradientUnits="userSpaceOnUse" x1="2" x2="20"><stop stop-color="#fff"/><stop offset=".4"
stop-color="#f00"/><stop offset="1" stop-color="#00f" stop-opacity=".5"/></linearGradient>
<radialGradient id="b" gradientUnits="userSpaceOnUse" cx="9" cy="9" r="8"><stop stop-color="#0f0"/><stop offset="1"
stop-color="#00f"/></radialGradient><filter id="f"><feGaussianBlur stdDeviation="1.5"/></filter></defs>
<rect x="1" y="2" width="20" height="9" rx="2" fill="url(#a)"/><circle cx="9" cy="9" r="6" fill="url(#b)"/>
<path d="M3 20C9 12 18 12 29 20" fill="none" stroke="#123" stroke-width="2"/>
<ellipse cx="24" cy="12" rx="5" ry="3" fill="#a4c" filter="url(#f)"/>
<path d="M2 2H30V22H2zM5 5V19H27V5z" fill-rule="evenodd" fill="#345"/></svg>"""
"""What the fit of "given paths" starts with: forms and a stroke, which become outlines, gradients, and a hole."""

NEW_FIELDS = ("forms", "strokes", "softness", "stops", "is_open", "__tensor__", "layers", "kind", "x")
"""Fields that are added to a part of a state: those of scenes that no fit has, and others."""

VALUES: tuple[Any, ...] = (
    None, True, False, 0, 1, -1, 3, 8, 9, 2**31, 2**63 - 1, 2**63, -(2**63), 10**40, 0.5, -0.5, 1e308, float("nan"),
    float("inf"), "", "x", "cpu", "cuda", [], [0], [[]], [None], [{}], {}, {"a": 1}, {"__tensor__": 0},
    {"__tensor__": 99}, {"__tensor__": -1}, {"__tensor__": "0"}, {"__tensor__": None}, {"__tensor__": {}},
)  # fmt: skip
"""What a number, a text or an array in the header is replaced by."""

ADDED: tuple[Any, ...] = tuple(
    {name: {"__tensor__": number} for name in names}
    for names in (("kind", "numbers"), ("width", "cap", "join", "miter_limit"), ("deviation",), ("count", "offset"))
    for number in (0, 1, 5)
)
"""Values of fields that are added, with arrays that others refer to as well."""

ARRAY_CHANGES = (
    "empty", "half", "one less", "one more", "twice", "flat", "new axis", "no axis", "swapped", "nan", "inf", "huge",
    "tiny", "negative", "least", "most", "zero", "float64", "float16", "int32", "int64", "uint8", "bool", "complex64",
    "text", "bytes", "time", "big-endian", "other values", "one value",
)  # fmt: skip
"""What is done to an array."""


def case(chance: Random) -> Case:
    """Return the reading and resuming of one checkpoint."""
    name = chance.choice(list(SETTINGS))
    if chance.random() < 0.2:
        data = _damaged_archive(chance, checkpoint_of(name))
        return Case(f"{name}, damaged archive", lambda folder: check(data, folder, name), data)
    header, arrays = unpacked(checkpoint_of(name))
    changes = []
    for _ in range(chance.choice([1, 1, 1, 2, 4])):
        path = chance.choice(paths(header))
        if chance.random() < 0.1:
            path = f"{path}.{chance.choice(NEW_FIELDS)}"
            changes.append((path, "added", chance.choice([*VALUES, *ADDED])))
            changed(header, arrays, *changes[-1])
            continue
        is_array = _is_array(_at(header, path)) and chance.random() < 0.9
        change = chance.choice(ARRAY_CHANGES) if is_array else chance.choice(["value", "value", "value", "missing"])
        value = None if is_array else chance.choice(VALUES)
        changes.append((path, change, value))
        changed(header, arrays, path, change, value)
    data = packed(header, arrays)
    return Case(f"{name}, {changes}"[:200], lambda folder: check(data, folder, name), data)


def check(data: bytes, folder: Path, name: str) -> str:
    """Read a checkpoint, and continue its fit if it is accepted.

    Raises:
        Wrong: the fit ends with a file that is not finite.
    """
    from warpvec.fit.checkpoint import read_checkpoint
    from warpvec.modes.choice import draw_picture
    from warpvec.modes.photo import Photo
    from warpvec.modes.request import Request

    path = folder / "fit.ckpt"
    path.write_bytes(data)
    checkpoint = read_checkpoint(path)
    drawing = draw_picture(Request.of(photo(name), _config(name)), Photo(resume=checkpoint))
    if "nan" in drawing.text.partition("<metadata")[0] or not np.isfinite(drawing.scene.segments.numpy()).all():
        raise Wrong("a file of points that are not finite")
    return OK


@cache
def photo(name: str) -> NDArray[np.float32]:
    """Return the picture of a fit, [24, 32, 3], or with alpha [24, 32, 4] for the one that is called transparent."""
    return np.random.default_rng(0).random((24, 32, 4 if name == "transparent" else 3), np.float32)


def _start(name: str) -> Any:
    """Return the scene that a fit starts with, as `warpvec refine` gives it to a fit, or None."""
    if name != "given paths":
        return None
    from warpvec.geometry.scene import over_white
    from warpvec.svg.read import read_svg
    from warpvec.svg.stroke_outlines import without_strokes

    scene = over_white(without_strokes(read_svg(DRAWING).scene.outlined()))
    return replace(scene, gradients=replace(scene.gradients, stops=None), softness=None)


@cache
def checkpoint_of(name: str) -> bytes:
    """Return the bytes of a checkpoint of a fit with ``SETTINGS[name]``, which has one more iteration to do."""
    import torch

    from warpvec.fit.checkpoint import Checkpoint, write_checkpoint
    from warpvec.fit.loop import fit
    from warpvec.fit.state import Saving, digest

    config, target = _config(name), torch.from_numpy(photo(name))
    states: list[dict[str, Any]] = []
    saving = Saving(config.iterations - 1, lambda state: states.append(deepcopy(state)))
    fit(target, config, None, start=_start(name), saving=saving)
    state = _without_times(states[0])
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "fit.ckpt"
        write_checkpoint(path, Checkpoint(config, digest(target), state))
        return path.read_bytes()


def _without_times(state: dict[str, Any]) -> dict[str, Any]:
    """Return the state of a fit with other numbers in place of the seconds that it took, which differ each time."""
    history = [{**record, "seconds": number / 1000} for number, record in enumerate(state["history"])]
    return {**state, "seconds": 0.5, "first_seconds": 0.25, "history": history}


def _config(name: str) -> Any:
    from warpvec.config.presets import make_config

    return make_config("default", **{"mode": "photo", "curves": 8, "iterations": 3, "threads": 1, **SETTINGS[name]})


def unpacked(data: bytes) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """Return the header and the arrays of a checkpoint."""
    with np.load(io.BytesIO(data), allow_pickle=False) as archive:
        arrays = {name: archive[name] for name in archive.files}
    return json.loads(arrays.pop("header").tobytes()), arrays


def packed(header: dict[str, Any], arrays: dict[str, NDArray[Any]]) -> bytes:
    """Undo `unpacked`."""
    stream = io.BytesIO()
    np.savez_compressed(stream, header=np.frombuffer(json.dumps(header).encode(), np.uint8), **arrays)
    return stream.getvalue()


def paths(value: Any, before: str = "") -> list[str]:
    """Return the paths of everything in a header, with dots between the names."""
    if not isinstance(value, dict) or _is_array(value):
        return [before.rpartition(".")[0] if before.endswith(".") else before]
    found = [path for name, item in value.items() for path in paths(item, f"{before}{name}.")]
    return [*found, before[:-1]] if before else found


def changed(header: dict[str, Any], arrays: dict[str, NDArray[Any]], path: str, change: str, value: Any) -> None:
    """Change the array or the value at ``path`` in place: one of `ARRAY_CHANGES`, "value", "missing" or "added"."""
    *parents, name = path.split(".")
    place = _at(header, ".".join(parents)) if parents else header
    if change == "added" and isinstance(place, dict):
        place[name] = value
        return
    if not isinstance(place, dict) or name not in place:  # an earlier change took it away
        return
    if change == "value":
        place[name] = value
    elif change == "missing":
        del place[name]
    elif _is_array(place[name]) and (key := f"array_{place[name]['__tensor__']}") in arrays:
        arrays[key] = _changed_array(arrays[key], change)


def _at(header: dict[str, Any], path: str) -> Any:
    value: Any = header
    for name in path.split("."):
        value = value.get(name) if isinstance(value, dict) else None
    return value


def _is_array(value: Any) -> bool:
    return isinstance(value, dict) and "__tensor__" in value


def _changed_array(array: NDArray[Any], change: str) -> NDArray[Any]:
    kept = np.array(array)
    last = kept.shape[-1] if kept.ndim else 1
    numbers = {"nan": np.nan, "inf": np.inf, "huge": 1e30, "tiny": 1e-40, "negative": -1, "zero": 0}
    shapes = {
        "empty": lambda: kept[..., :0] if kept.ndim else np.empty(0, kept.dtype),
        "half": lambda: kept[..., : last // 2] if kept.ndim else kept,
        "one less": lambda: kept[: len(kept) - 1] if kept.ndim else np.empty(0, kept.dtype),
        "one more": lambda: np.concatenate([kept, kept[:1]]) if kept.ndim else np.stack([kept, kept]),
        "twice": lambda: np.concatenate([kept, kept], -1) if kept.ndim else np.stack([kept, kept]),
        "flat": lambda: kept.reshape(-1),
        "new axis": lambda: kept[None],
        "no axis": lambda: np.zeros((), kept.dtype),
        "swapped": lambda: np.asfortranarray(kept.T),
        "text": lambda: np.full(kept.shape, "x"),
        "bytes": lambda: np.full(kept.shape, b"x"),
        "time": lambda: np.zeros(kept.shape, "M8[s]"),
        "big-endian": lambda: kept.astype(kept.dtype.newbyteorder(">")),
        "other values": lambda: np.random.default_rng(0).integers(0, 99, kept.shape).astype(kept.dtype),
    }
    if change in shapes:
        made: NDArray[Any] = shapes[change]()
        return made
    if change in numbers:
        with np.errstate(all="ignore"):
            kept[...] = np.array(numbers[change]).astype(kept.dtype)
    elif change in ("least", "most"):
        limits = np.iinfo(kept.dtype) if kept.dtype.kind in "iu" else np.finfo(kept.dtype)
        kept[...] = limits.min if change == "least" else limits.max
    elif change == "one value":
        if kept.size:
            kept.flat[kept.size // 2] = np.array(np.nan if kept.dtype.kind == "f" else 99).astype(kept.dtype)
    else:
        return kept.astype(change)
    return kept


def _damaged_archive(chance: Random, data: bytes) -> bytes:
    kind = chance.choice(["bytes", "bytes", "claim", "pickle", "members", "stored", "deep"])
    if kind == "bytes":
        return mutate(data, chance, [data])
    header, arrays = unpacked(data)
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", chance.choice([zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED])) as archive:
        for name, array in {"header": np.frombuffer(json.dumps(header).encode(), np.uint8), **arrays}.items():
            member = io.BytesIO()
            is_chosen = chance.random() < 0.2
            np.save(member, array.astype(object) if is_chosen and kind == "pickle" else array, allow_pickle=True)
            written = member.getvalue()
            if name == "header" and kind == "deep":
                written = _member(_deep_header(chance))
            if is_chosen and kind == "claim":
                written = _claiming(chance, written, array)
            if is_chosen and kind == "stored":
                written = mutate(written, chance, [written])
            label = f"../{name}" if is_chosen and kind == "members" else f"{name}.npy"
            archive.writestr(zipfile.ZipInfo(label), written)
        if kind == "members":
            archive.writestr(zipfile.ZipInfo("big.npy"), bytes(chance.choice([0, 10**6, 2**27])))
    return stream.getvalue()


def _deep_header(chance: Random) -> bytes:
    depth, (opening, closing) = chance.choice([100, 1000, 10**5]), chance.choice([("[", "]"), ('{"a":', "}")])
    return (opening * depth + "1" + closing * depth * chance.choice([0, 1])).encode()


def _member(data: bytes) -> bytes:
    stream = io.BytesIO()
    np.save(stream, np.frombuffer(data, np.uint8))
    return stream.getvalue()


def _claiming(chance: Random, written: bytes, array: NDArray[Any]) -> bytes:
    """Return a member of an archive whose header states another shape, an absurd one among them."""
    shape = chance.choice(["(99999999999,)", "(2, -1)", "(1e9,)", "(0,)", "()", "(1,) * 99", "(2**62, 4)", "[3]", "x"])
    text = f"{{'descr': '{array.dtype.str}', 'fortran_order': {chance.choice([False, True, 3])}, 'shape': {shape}, }}"
    head = text.encode().ljust(117) + b"\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(head)) + head + written[128:]
