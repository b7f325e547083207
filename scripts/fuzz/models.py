"""Targets for archive-based model files, whose members are changed before repacking.

An input is a list of changes to the sample's model, one per line. A line for the JSON names a value
and gives its replacement as JSON, or nothing. A line for an array gives an offset and hexadecimal
bytes, after ``=`` to overwrite, after ``+`` to insert, or after ``-`` to remove:

    /settings/overlap [0.5]
    leaves 128=00000000000000f0
"""

from __future__ import annotations

import io
import json
import re
import zipfile
from collections.abc import Iterator
from functools import cache, partial
from pathlib import Path
from typing import Any, Final

import numpy as np

from nvcore.common.output.model_files import pack
from nvcore.subjects.detectors.icf import IcfDetector
from nvcore.subjects.detectors.icf.model import from_bytes, to_bytes
from nvcore.subjects.detectors.registry import SAMPLE_MODEL
from nvcore.subjects.driver.estimators import model_file as driver_file
from nvcore.subjects.driver.evaluation.estimator_report import render_estimator
from scripts.fuzz.target import mutated_text, target

_OF_JSON: Final = re.compile(rb"(/\S+) (.*)", re.DOTALL)
_OF_ARRAY: Final = re.compile(rb"(\w+) (\d{1,6})([=+-])((?:[0-9a-f]{2})*)")
_MOST_CHANGES: Final = 16


def changed(content: bytes, sample: Path) -> bytes:
    """Return a model file of the sample with changes, repacked."""
    members = dict(_sample_members(sample))
    about = json.loads(members["about"])
    texts: list[bytes] = []
    for line in content.split(b"\n")[:_MOST_CHANGES]:
        if match := _OF_JSON.fullmatch(line):
            holder, key = _place(about, match[1].decode("ascii", "replace").split("/")[1:])
            if holder is not None:
                holder[key] = f"changed {len(texts)}"
                texts.append(match[2])
        elif (match := _OF_ARRAY.fullmatch(line)) and match[1].decode() in members:
            name, start, new = match[1].decode(), int(match[2]), bytes.fromhex(match[4].decode())
            member = members[name]
            start %= len(member) + 1
            end = start if match[3] == b"+" else start + max(len(new), 1)
            members[name] = member[:start] + (b"" if match[3] == b"-" else new) + member[end:]
    text = json.dumps(about).encode()
    for number, new in enumerate(texts):
        text = text.replace(f'"changed {number}"'.encode(), new, 1)
    members["about"] = pack({"about": np.frombuffer(text, np.uint8)})
    with zipfile.ZipFile(io.BytesIO(members["about"])) as archive:
        members["about"] = archive.read("about.npy")
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, member in members.items():
            archive.writestr(f"{name}.npy", member)
    return packed.getvalue()


def changes(sample: Path) -> Iterator[bytes]:
    """Yield each JSON value unchanged and as a list, and each array changed in three places."""
    yield b""
    members = _sample_members(sample)
    lines = []
    for path, value in _values(json.loads(members["about"])):
        text = json.dumps(value)  # long values contain shorter ones that are yielded by themselves
        if len(text) < 100:  # the later line wins; the earlier one can be mutated away
            lines.append(f"{path} [{text}]\n{path} {text}")
    for start in range(0, len(lines), _MOST_CHANGES // 2):
        yield "\n".join(lines[start : start + _MOST_CHANGES // 2]).encode()
    for name, member in members.items():
        if name != "about":
            same = (f"{start}={member[start : start + 8].hex()}" for start in (10, 60, 128))
            yield "\n".join(f"{name} {part}" for part in same).encode()


@cache
def _sample_members(path: Path) -> dict[str, bytes]:
    """Return JSON and arrays of the sample's model as files."""
    with zipfile.ZipFile(path) as archive:
        members = {name.removesuffix(".npy"): archive.read(name) for name in archive.namelist()}
    stored = np.lib.format.read_array(io.BytesIO(members["about"]), allow_pickle=False)
    about = json.loads(stored.tobytes())
    if "settings" in about:  # all scales together take too long for one picture
        about["settings"]["scales"] = [1.0, 1.5]
    return members | {"about": json.dumps(about).encode()}


def _place(about: Any, path: list[str]) -> tuple[Any, Any]:
    """Return the container of a path's value, and its key there, or None if there is none."""
    holder: Any = None
    key: Any = None
    part: Any = about
    for name in path:
        holder, key = part, name
        if isinstance(part, list) and name.isdecimal() and int(name[:6]) < len(part):
            key = int(name[:6])
        elif not isinstance(part, dict):
            return None, None
        part = part.get(name) if isinstance(part, dict) else part[key]
    return holder, key


def _values(part: Any, path: str = "") -> Iterator[tuple[str, Any]]:
    """Yield every JSON value with its path."""
    for key, value in part.items() if isinstance(part, dict) else enumerate(part):
        yield f"{path}/{key}", value
        if isinstance(value, dict | list):
            yield from _values(value, f"{path}/{key}")


@cache
def _picture() -> np.ndarray:
    return np.random.default_rng(0).integers(0, 255, (44, 32), dtype=np.uint8)


@target(partial(changes, SAMPLE_MODEL), share=1.0, most_bytes=1024, mutate=mutated_text)
def detectors(content: bytes, _folder: Path) -> None:
    """Read a changed detector, check its round trip, and run it on a small picture."""
    model = from_bytes(changed(content, SAMPLE_MODEL), "model.npz")
    written = to_bytes(model)
    assert to_bytes(from_bytes(written, "again.npz")) == written, "another model"
    boxes = IcfDetector(model).detect(_picture())
    assert np.isfinite(boxes.score).all(), "scores that are no numbers"


@target(
    partial(changes, driver_file.SAMPLE_ESTIMATOR), share=1.0, most_bytes=1024, mutate=mutated_text
)
def estimators(content: bytes, _folder: Path) -> None:
    """Read a changed estimator, check its round trip, and compute estimates."""
    estimator = driver_file.from_bytes(changed(content, driver_file.SAMPLE_ESTIMATOR), "model.npz")
    written = driver_file.to_bytes(estimator)
    again = driver_file.from_bytes(written, "again.npz")
    assert driver_file.to_bytes(again) == written, "another estimator"
    render_estimator(estimator)
    features = np.linspace(0.0, 300.0, 80).reshape(10, 8)
    for interpolate in (False, True):
        estimates = estimator.estimate(features, np.arange(10.0), interpolate=interpolate)
        assert np.isfinite(estimates.detectability).all(), "estimates that are no numbers"
