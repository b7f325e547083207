"""CVAT for images XML 1.1: boxes by picture."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pandas as pd

from nvcore.common.errors import FormatError
from nvcore.common.findings import Finding
from nvcore.dataset.schema import NO_TRACK
from nvcore.inputs.readers.base import (
    BOTH_ROLES,
    NO_FRAME,
    Format,
    NamedPictures,
    Reading,
    ReadOptions,
    Role,
    SourceFile,
    object_array,
    warning,
)
from nvcore.inputs.readers.cvat.content import (
    CvatContent,
    Owner,
    boxes_reading,
    other_shapes,
    read_cvat,
)
from nvcore.inputs.readers.meaning.frame_names import in_file, joined_named, named_pictures
from nvcore.inputs.readers.meaning.names import ONLY, recording_and_frame_of, recording_of
from nvcore.inputs.readers.meaning.values import recordings_with_sizes
from nvcore.inputs.readers.parse.xml import root_of

_ANNOTATION = re.compile(r"<mode>\s*annotation\s*</mode>")


def recognise(_name: str, head: str, _role: Role) -> bool:
    """Whether it is CVAT's XML with images, or with neither images nor tracks from pictures."""
    if root_of(head) != "annotations" or re.search(r"<track\s", head):
        return False
    return bool(re.search(r"<image\s", head) or _ANNOTATION.search(head))


def read(files: Sequence[SourceFile], options: ReadOptions) -> Reading:
    """Read CVAT for images files. Pictures without boxes are evaluated frames, too.

    Recording and frame come from the names of the pictures. If a name in a file has no number,
    the file is the recording and the ids of its pictures are the frames. Corners are 0-based and
    continuous.
    """
    tables, listed, named = [], [], []
    declared: list[str] = []
    findings: list[Finding] = []
    for number, file in enumerate(files):
        content = read_cvat(file, kind="image")
        recording, frame, odd, names = _places(content, file, options)
        named.append(names)
        owner = content.boxes["owner"].to_numpy()
        tables.append(
            content.boxes.assign(
                recording=recording[owner], frame=frame[owner], track=NO_TRACK, file=number
            )
        )
        declared += content.declared
        pictures = content.owner_table.assign(recording=recording, frame=frame, file=file.name)
        listed.append(pictures)
        findings += [*odd, *other_shapes(content, file, options)]
    pictures = pd.concat(listed, ignore_index=True)
    _check_doubles(pictures)
    ids = pictures["number"].to_numpy()
    if pictures["number"].duplicated().any():
        ids = np.arange(len(pictures))
    recordings, odd_sizes = recordings_with_sizes(
        pictures,
        options.role,
        lambda row: (pictures["file"].iloc[row], f"line {pictures['line'].iloc[row]}: "),
    )
    findings += odd_sizes
    reading = boxes_reading(
        pd.concat(tables, ignore_index=True),
        declared,
        files,
        options,
        recordings,
        pictures[["recording", "frame"]].assign(image_id=ids),
        facts=["recordings and frame numbers from the picture names"],
        findings=findings,
    )
    return replace(reading, named=joined_named(named))


def _places(
    content: CvatContent, file: SourceFile, options: ReadOptions
) -> tuple[np.ndarray, np.ndarray, list[Finding], NamedPictures]:
    """Return recordings and frames of pictures, with findings and names."""
    known = options.recordings
    fallback = recording_of(file.name, known)
    with in_file(file):
        named = named_pictures([owner.name for owner in content.owners], options)
    if named.strange >= 0 or options.frame_names == "order":
        strange = content.owners[max(0, named.strange)]
        return _places_by_id(content, strange, fallback, file, options)
    recordings = named.recording.copy()
    if not named.is_joined:
        for row, owner in enumerate(content.owners):
            # a bare name, frame_000012 from a video: the file is the recording
            if recordings[row] == ONLY and ONLY not in owner.name:
                recordings[row] = _task_recording(content, owner, fallback)
            elif recordings[row] not in known and fallback in known:
                recordings[row] = fallback
    pairs = zip(named.recording, recordings, strict=True) if named.rates else ()
    rates = {new: named.rates[old] for old, new in pairs if old in named.rates}
    table = named.table.assign(recording=recordings)
    return recordings, named.frame, [], replace(named, table=table, rates=rates)


def _places_by_id(
    content: CvatContent, strange: Owner, fallback: str, file: SourceFile, options: ReadOptions
) -> tuple[np.ndarray, np.ndarray, list[Finding], NamedPictures]:
    """Use the ids of pictures as frames, with a warning."""
    n_strange = sum(recording_and_frame_of(owner.name) is None for owner in content.owners)
    finding = warning(
        "picture-without-number",
        n_strange,
        "Names of pictures have no frame number: the ids of the pictures are taken as frames.",
        "Check that the pictures follow each other in time in the order of their ids.",
        role=options.role,
        file=file.name,
        example=f"line {strange.line}: {strange.name[:60]}",
    )
    recordings = [_task_recording(content, owner, fallback) for owner in content.owners]
    frames = np.array([owner.number for owner in content.owners], dtype=np.int64)
    names = [owner.name for owner in content.owners]
    table = pd.DataFrame({"recording": recordings, "frame": frames, "name": names})
    findings = [] if options.frame_names == "order" else [finding]
    return object_array(recordings), frames, findings, NamedPictures(table, "order")


def _task_recording(content: CvatContent, owner: Owner, fallback: str) -> str:
    """Return the file's recording, or the task's if the file has several tasks."""
    task = content.tasks.get(owner.task)
    if len(content.tasks) == 1 or task is None:
        return fallback
    return f"{task.stated or 'task'}-{task.key}"


def _check_doubles(pictures: pd.DataFrame) -> None:
    """Raise FormatError for the second picture of a frame."""
    double = pictures.duplicated(["recording", "frame"]) & (pictures["frame"] != NO_FRAME)
    if not double.any():
        return
    second = pictures[double].iloc[0]
    is_same = (pictures["recording"] == second["recording"]) & (
        pictures["frame"] == second["frame"]
    )
    first = pictures[is_same].iloc[0]
    raise FormatError(
        f"the picture is frame {second['frame']} of recording {second['recording']!r}, as is that "
        f"of {first['file']}, line {first['line']}; expected one picture per frame: name the "
        "pictures or their folders by the recordings",
        file=second["file"],
        line=int(second["line"]),
    )


FORMAT = Format("cvat-images", "CVAT for images XML 1.1", BOTH_ROLES, (".xml",), recognise, read)
