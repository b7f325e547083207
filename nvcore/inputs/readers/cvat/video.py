"""CVAT for video XML 1.1: tracks of boxes, with or without boxes between keyframes."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from nvcore.common.findings import Finding, Remedy, Step
from nvcore.inputs.readers.base import (
    BOTH_ROLES,
    Format,
    Lines,
    Reading,
    ReadOptions,
    Role,
    SourceFile,
    image_list,
    object_array,
    recordings_table,
    warning,
)
from nvcore.inputs.readers.cvat.content import (
    CORNERS,
    CvatContent,
    CvatTask,
    boxes_reading,
    other_shapes,
    read_cvat,
)
from nvcore.inputs.readers.meaning.names import recordings_of
from nvcore.inputs.readers.meaning.values import MAX_FRAMES
from nvcore.inputs.readers.parse.xml import root_of


@dataclass(frozen=True)
class FilledTracks:
    """Rows of all tracks, sorted by track and frame, including those between keyframes.

    Attributes
    ----------
    left, right
        Input rows before and after each row, int64, shape (m,). Equal for input rows.
    share
        Position between left (0) and right (1), float64, shape (m,). 0 for input rows.
    frame
        Frame of each row, int64, shape (m,).
    gaps
        Input rows before missing frames that were not filled, because the boxes around them are
        not both keyframes, int64.
    """

    left: np.ndarray
    right: np.ndarray
    share: np.ndarray
    frame: np.ndarray
    gaps: np.ndarray

    def between(self, values: np.ndarray) -> np.ndarray:
        """Interpolate values of the input rows linearly, shape (m, ...)."""
        share = self.share.reshape(-1, *[1] * (values.ndim - 1))
        with np.errstate(invalid="ignore", over="ignore"):
            moved = values[self.left] + share * (values[self.right] - values[self.left])
        return np.asarray(np.where(share == 0, values[self.left], moved))

    def angle_between(self, degrees: np.ndarray) -> np.ndarray:
        """Interpolate angles (degrees) of the input rows the shorter way round, shape (m,)."""
        with np.errstate(invalid="ignore"):
            turn = (degrees[self.right] - degrees[self.left] + 180) % 360 - 180
            moved = degrees[self.left] + self.share * turn
        return np.asarray(np.where(self.share == 0, degrees[self.left], moved))


def fill_between_keyframes(
    track: np.ndarray,
    frame: np.ndarray,
    outside: np.ndarray,
    keyframe: np.ndarray,
    step: np.ndarray,
    lines: Lines,
) -> FilledTracks:
    """Fill the frames between two keyframes of a track, from the first unless it is outside.

    Parameters
    ----------
    track, frame
        Number of the track and of the frame of each row, int64, shape (n,).
    outside
        Whether the object has left the picture at this row, bool, shape (n,).
    keyframe
        Whether an annotator drew the box, bool, shape (n,). Nothing is filled next to other boxes,
        since files with such boxes contain all frames.
    step
        Step between neighbouring frames, int64 >= 1, shape (n,).
    lines
        Lines of the rows.

    Raises
    ------
    FormatError
        If more than `MAX_FRAMES` rows would be filled, with the line before the longest gap.
    """
    order = np.lexsort((frame, track))
    left, right = order[:-1], order[1:]
    missing = np.maximum((frame[right] - frame[left] - 1) // step[left], 0)
    missing = np.where((track[left] == track[right]) & ~outside[left], missing, 0)
    fills = keyframe[left] & keyframe[right]
    n_filled = np.where(fills, missing, 0)
    if n_filled.sum(dtype=float) > MAX_FRAMES:
        row = int(left[np.argmax(n_filled)])
        raise lines.fault(
            row,
            f"expected keyframes near each other, found a gap after frame {frame[row]} that would "
            f"take more than {MAX_FRAMES} boxes to fill",
        )
    n_rows = np.append(n_filled, 0)[: len(order)] + 1
    keyframe_row = np.repeat(np.arange(len(order)), n_rows)
    # position of each row after its keyframe: 0 is the keyframe itself
    position = np.arange(len(keyframe_row)) - np.repeat(np.cumsum(n_rows) - n_rows, n_rows)
    start = order[keyframe_row]
    end = np.where(position > 0, order[np.minimum(keyframe_row + 1, len(order) - 1)], start)
    frames = frame[start] + position * step[start]
    length = np.maximum(frame[end] - frame[start], 1)
    return FilledTracks(
        left=start,
        right=end,
        share=(frames - frame[start]) / length,
        frame=frames,
        gaps=left[(missing > 0) & ~fills],
    )


_INTERPOLATION = re.compile(r"<mode>\s*interpolation\s*</mode>")


def recognise(_name: str, head: str, _role: Role) -> bool:
    """Whether it is CVAT's XML with tracks, or with neither tracks nor images from a video."""
    if root_of(head) != "annotations" or re.search(r"<image\s", head):
        return False
    return bool(re.search(r"<track\s", head) or _INTERPOLATION.search(head))


def read(files: Sequence[SourceFile], options: ReadOptions) -> Reading:
    """Read CVAT for video files, one recording each, or an export of a project with several.

    Frame numbers are those of the video, even if the task has only every n-th frame. Corners are
    0-based and continuous. Boxes marked as outside are dropped. Missing boxes between two
    keyframes are interpolated, as CVAT does. Size, start, stop and step of the task define the
    evaluated frames.
    """
    contents = [read_cvat(file, kind="track") for file in files]
    units = [
        (number, task) for number, content in enumerate(contents) for task in content.tasks.values()
    ]
    names, facts = _recordings(files, contents, units, options)
    by_task = {(number, task.key): name for (number, task), name in zip(units, names, strict=True)}
    tables, listed = [], []
    findings: list[Finding] = []
    for number, task in units:
        frames, odd = _frames_of(task, files[number], options)
        findings += odd
        listed += [] if frames is None else [frames]
    for number, (file, content) in enumerate(zip(files, contents, strict=True)):
        table, odd = _boxes_of(content, file, number, by_task, options)
        tables.append(table)
        findings += [*odd, *other_shapes(content, file, options)]
    boxes = pd.concat(tables, ignore_index=True)
    facts = [
        "frame numbers of the video kept (0-based)",
        "boxes marked outside left out",
        f"{boxes['is_filled'].sum()} boxes filled in between keyframes (linear)",
        *facts,
    ]
    images = None
    if len(listed) == len(units):
        images = image_list(names, listed)
        facts.append("evaluated frames from the task's size, start and step")
    recordings = recordings_table(
        names, width=[task.width for _, task in units], height=[task.height for _, task in units]
    )
    return boxes_reading(
        boxes,
        [label for content in contents for label in content.declared],
        files,
        options,
        recordings,
        images,
        facts=facts,
        findings=findings,
    )


def _recordings(
    files: Sequence[SourceFile],
    contents: Sequence[CvatContent],
    units: Sequence[tuple[int, CvatTask]],
    options: ReadOptions,
) -> tuple[list[str], list[str]]:
    """Return the recording of each task. Only an export of a project has several tasks."""
    paths, stated = [], []
    names = [task.stated for _, task in units]
    for (number, task), name in zip(units, names, strict=True):
        alone = len(contents[number].tasks) == 1
        if name is not None and not alone and names.count(name) > 1:
            name = f"{name}-{task.key}"
        own = name or f"task-{task.key}"
        paths.append(files[number].name if alone else f"{files[number].name}/{own}")
        stated.append(name if alone else own)
    return recordings_of(paths, options.recordings, stated=stated)


def _frames_of(
    task: CvatTask, file: SourceFile, options: ReadOptions
) -> tuple[np.ndarray | None, list[Finding]]:
    """Return the task's frames, or None if the file does not give them."""
    n_frames = task.n_frames
    if n_frames is not None and n_frames > MAX_FRAMES:
        raise file.fault(
            f"expected a task of at most {MAX_FRAMES} frames, found {n_frames}", task.line
        )
    if n_frames is None and task.size is not None:
        text = f"{task.size} frames, from {task.start} to {task.stop} by {task.step}"
        finding = warning(
            "frame-count",
            1,
            "Size, start, stop and step of the task do not agree: the evaluated frames are not "
            "taken from them.",
            "Say which frames are evaluated.",
            role=options.role,
            file=file.name,
            example=f"line {task.line}: {text}",
            steps=(Step(Remedy.FRAMES),),
        )
        return None, [finding]
    frames = task.start + task.step * np.arange(n_frames or 0, dtype=np.int64)
    return None if n_frames is None else frames, []


def _boxes_of(
    content: CvatContent,
    file: SourceFile,
    number: int,
    by_task: dict[tuple[int, str], str],
    options: ReadOptions,
) -> tuple[pd.DataFrame, list[Finding]]:
    """Return the boxes of one file, including those between keyframes."""
    tasks = [_task_of(content, owner.task, owner.line, file) for owner in content.owners]
    spans = [(t.start, t.step, -np.inf if t.last is None else t.last) for t in tasks]
    columns = {str(name): values.to_numpy() for name, values in content.boxes.items()}
    owner, frame, outside = columns["owner"], columns["frame"], columns["outside"]
    start, step, last = np.array(spans, dtype=float).reshape(-1, 3)[owner].T
    lines = Lines.of(file, columns["line"])
    filled = fill_between_keyframes(
        owner, frame, outside, columns["keyframe"], step.astype(np.int64), lines
    )
    corners = filled.between(content.boxes[CORNERS].to_numpy())
    recording = object_array([by_task[number, task.key] for task in tasks])
    left = filled.left
    boxes = content.boxes.iloc[left].assign(
        recording=recording[owner[left]],
        frame=filled.frame,
        track=content.owner_table["track"].to_numpy()[owner[left]],
        **dict(zip(CORNERS, corners.T, strict=True)),
        rotation=filled.angle_between(columns["rotation"]),
        file=number,
        is_filled=filled.share > 0,
    )
    rows = content.boxes.assign(start=start, step=step, last=last)
    return boxes[~boxes["outside"]], _findings(rows, lines, filled, content, options)


def _task_of(content: CvatContent, key: str, line: int, file: SourceFile) -> CvatTask:
    """Return the task of a track: the only one, or the one that the track names."""
    if len(content.tasks) == 1:
        return next(iter(content.tasks.values()))
    if key not in content.tasks:
        raise file.fault(
            f"expected one of the tasks {', '.join(list(content.tasks)[:10])} as task_id, "
            f"found {key[:60]!r}",
            line,
        )
    return content.tasks[key]


def _findings(
    rows: pd.DataFrame,
    lines: Lines,
    filled: FilledTracks,
    content: CvatContent,
    options: ReadOptions,
) -> list[Finding]:
    """Report frames off the step, gaps that were not filled, tracks without end, repeated ids."""
    owners = content.owner_table
    track = owners["track"].to_numpy()
    is_visible = ~rows["outside"]
    # CVAT writes no end for a box in one of the last two frames
    is_early = rows["frame"] < rows["last"] - rows["step"]
    by_track = rows.sort_values(["owner", "frame"], kind="stable")
    is_last = ~by_track.duplicated("owner", keep="last").sort_index()
    findings: list[Finding] = []
    for is_odd, code, message, advice, *steps in (
        (
            is_visible & ((rows["frame"] - rows["start"]) % rows["step"] != 0),
            "frame-beside-step",
            "Boxes lie in frames that the task, by its start and step, does not have.",
            "Check that the boxes carry frame numbers of the video, not of the task.",
        ),
        (
            rows.index.isin(filled.gaps),
            "track-with-gap",
            "Tracks miss frames beside boxes that are no keyframes; nothing was filled in (CVAT "
            "leaves out deleted frames).",
            "If the frames were deleted, leave them out of the evaluated frames.",
            Step(Remedy.FRAMES),
        ),
        (
            is_visible & is_early & is_last,
            "track-without-end",
            "Tracks stop before the last frame without a box marked outside; CVAT itself shows "
            "such a box up to the last frame, here the track ends with its last box.",
            "Mark the end of the tracks in CVAT, or export the task again.",
        ),
    ):
        findings += lines.finding(
            np.asarray(is_odd),
            code,
            message,
            advice,
            role=options.role,
            example=lambda row: (
                f"track {track[rows['owner'].iloc[row]]}, frame {rows['frame'].iloc[row]}"
            ),
            steps=tuple(steps),
        )
    # a file of several tasks may number the tracks of each
    is_double = owners.duplicated(["track", "task"]).to_numpy() & (track >= 0)
    return findings + Lines.of(lines.files[0], owners["line"].to_numpy()).finding(
        is_double,
        "track-id-twice",
        "Several tracks have the same id and count as one.",
        "Give every track an id of its own.",
        role=options.role,
        example=lambda owner: f"track {track[owner]}",
    )


FORMAT = Format("cvat-video", "CVAT for video XML 1.1", BOTH_ROLES, (".xml",), recognise, read)
