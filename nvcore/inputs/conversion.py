"""Convert any readable input to plain CSV, Parquet, COCO or MOTChallenge."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np

from nvcore.common.arguments import PathLike, called_with
from nvcore.common.errors import InputError, MissingFactError
from nvcore.common.findings import Finding, Remedy, Step
from nvcore.inputs.evaluated_frames import frames_by_recording, infer_frames, own_frames
from nvcore.inputs.facts import objects_named, size_from
from nvcore.inputs.files.find import find_files
from nvcore.inputs.files.pipes import pipes_kept
from nvcore.inputs.load import read_options, read_source
from nvcore.inputs.readers import NOTHING
from nvcore.inputs.readers.base import Format, Reading, Role, SourceFile
from nvcore.inputs.session import Source
from nvcore.inputs.session.arguments import ConvertArguments
from nvcore.inputs.writers import format_by_name, write, write_frame_lists
from nvcore.settings.objects import PEDESTRIAN, Objects

DETECTIONS: Final = Step(Remedy.OPTION, "detections", "role")


@dataclass(frozen=True)
class Conversion:
    """Result of `convert`: the files that were written.

    Attributes
    ----------
    files
        Files with the boxes.
    frame_files
        Lists of evaluated frames, if they were requested.
    n_boxes, n_frames
        Number of boxes and evaluated frames in the files. Detections have no frames.
    conversion
        Description of the conversion.
    findings
        Oddities of the input.
    warnings
        Sentences about facts that the written files cannot hold.
    steps
        Suggested fixes for the warnings.
    """

    files: tuple[Path, ...]
    frame_files: tuple[Path, ...]
    n_boxes: int
    n_frames: int
    conversion: str
    findings: tuple[Finding, ...]
    warnings: tuple[str, ...]
    steps: tuple[Step, ...] = ()


@called_with(ConvertArguments)
@pipes_kept()
def convert(arguments: ConvertArguments) -> Conversion:
    """Write any readable input as CSV, Parquet, COCO or MOTChallenge, as ``nvcore convert`` does.

    Parameters
    ----------
    source
        The input: a file, folder or glob, or a `Source` that says how to read it.
    target
        File to write, or a folder for several recordings of MOTChallenge.
    to
        ``csv``, ``parquet``, ``coco`` or ``mot``. None: by the ending of the target's name.
    frames_out
        Place for the evaluated frames of the truth: a file, or a folder if the recordings differ in
        them.
    size
        Size of pictures (px) whose size is not in the files.
    objects
        Kind of objects in the boxes. None: pedestrians.

    Raises
    ------
    InputError
        If a file cannot be read or written, or the content of the input is ambiguous.

    Examples
    --------
    >>> convert("truth.json", "truth.csv", "csv").files  # doctest: +SKIP
    (PosixPath('truth.csv'),)
    """
    source, truth = arguments.source, arguments.truth
    source = Source(str(source)) if isinstance(source, PathLike) else source
    truth = Source(str(truth)) if isinstance(truth, PathLike) else truth
    target, role, force = Path(arguments.target), arguments.role, arguments.force
    to = arguments.to or format_by_name(target)
    frames_out = None if arguments.frames_out is None else Path(arguments.frames_out)
    size = size_from(arguments.size)
    objects = objects_named(arguments.objects) or PEDESTRIAN
    kind: Role = "detections" if role == "detections" else "truth"
    if frames_out is not None and kind == "detections":
        raise InputError("a list of evaluated frames is for ground truth; these are detections")
    inputs: list[Path] = []
    of_truth = None
    if truth is not None:
        inputs += [file.path for file in find_files(truth, Path.cwd(), "truth")[0]]
        of_truth = read_source(truth, role="truth", size=size, objects=objects)
    files, source_format = _files_of(source, kind, is_guess=role is None)
    inputs += [file.path for file in files]
    if role is None and _has_scores(files, source_format, source, size, objects):
        raise InputError(
            "this has scores, as detections have and ground truth has not: say which of them it is",
            file=source.path[0],
            steps=(DETECTIONS, replace(DETECTIONS, value="truth")),
        )
    reading = read_source(source, role=kind, size=size, truth=of_truth, objects=objects)
    reading, warnings = _with_size(reading, size)
    frames, lost = None, ""
    if kind == "truth":
        try:
            frames, lost = _evaluated_frames(reading, to)
        except MissingFactError as error:  # frame numbers such as times: boxes can be written
            if to == "coco" or frames_out is not None:
                raise
            warnings.append(str(error))
    outputs = write(
        reading, to, target, role=kind, truth=of_truth, objects=objects, inputs=inputs, force=force
    )
    steps = []
    if frames is not None and to == "coco":
        warnings += (unknown := _unknown_sizes(reading))
        steps += [Step(Remedy.SIZE)] * len(unknown)
    elif lost:
        warnings.append(lost)
        steps += [Step(Remedy.OPTION, "", "frames_out")] * (frames_out is None)
    lists: list[Path] = []
    if frames is not None and frames_out is not None:
        lists = write_frame_lists(frames, frames_out, inputs=[*inputs, *outputs], force=force)
    return Conversion(
        files=tuple(outputs),
        frame_files=tuple(lists),
        n_boxes=len(reading.boxes),
        n_frames=sum(map(len, (frames or {}).values())),
        conversion=reading.conversion,
        findings=reading.findings,
        warnings=tuple(warnings),
        steps=tuple(steps),
    )


def _files_of(source: Source, role: Role, *, is_guess: bool) -> tuple[list[SourceFile], Format]:
    """Find the files of the input and their format, or explain how to convert detections."""
    try:
        return find_files(source, Path.cwd(), role)
    except InputError:
        if is_guess and _are_detections(source):
            raise InputError(
                "this holds detections, not ground truth", file=source.path[0], steps=(DETECTIONS,)
            ) from None
        raise


def _are_detections(source: Source) -> bool:
    """Whether the files contain detections."""
    try:
        return find_files(source, Path.cwd(), "detections")[1] is not NOTHING
    except InputError:
        return False


def _has_scores(
    files: list[SourceFile],
    source_format: Format,
    source: Source,
    size: tuple[int, int] | None,
    objects: Objects,
) -> bool:
    """Whether files of ground truth, read as detections, have scores other than 0 and 1.

    In MOTChallenge's column of scores, these two mark rows to ignore and rows to count.
    """
    if "detections" not in source_format.roles:
        return False
    options = read_options(source, "detections", size, None, objects)
    try:
        scores = source_format.read(files, options).boxes["score"].dropna()
    except InputError:  # reported when they are read as ground truth
        return False
    return bool((~scores.isin([0, 1, -1])).any())


def _with_size(reading: Reading, size: tuple[int, int] | None) -> tuple[Reading, list[str]]:
    """Fill in unknown picture sizes, and warn about recordings with another size."""
    if size is None:
        return reading, []
    table = reading.recordings.copy()
    sides = ["width", "height"]
    is_unknown = ~(table[sides] > 0).all(axis=1)
    table.loc[is_unknown, sides] = [float(side) for side in size]
    n_others = int((table[sides].to_numpy() != size).any(axis=1).sum())
    text = (
        f"the data say another size than the given one for {n_others} of {len(table)} "
        "recordings; theirs is written"
    )
    return replace(reading, recordings=table), [text] * (n_others > 0)


def _unknown_sizes(reading: Reading) -> list[str]:
    """Warn about recordings of unknown size, if there are any."""
    n_unknown = int((~(reading.recordings[["width", "height"]] > 0).all(axis=1)).sum())
    text = (
        f"the image size of {n_unknown} of {len(reading.recordings)} recordings is not known, and "
        "their images have no width and height, which many tools want"
    )
    return [text] * (n_unknown > 0)


def _evaluated_frames(reading: Reading, to: str) -> tuple[dict[str, np.ndarray], str]:
    """Return evaluated frames by recording, and a warning if boxes do not determine them.

    Raises
    ------
    MissingFactError
        See `own_frames`.
    """
    listed = own_frames(reading, reading.recordings["name"])
    frames = {name: numbers for name, (numbers, _) in listed.items() if len(numbers)}
    boxed = frames_by_recording(reading.boxes)
    again = {name: infer_frames(numbers)[0] for name, numbers in boxed.items()}
    is_same = [np.array_equal(frames.get(name, ()), again.get(name, ())) for name in listed]
    n_frames, n_again = (sum(map(len, every.values())) for every in (frames, again))
    n_empty = sum(len(np.setdiff1d(own, boxed.get(name, ()))) for name, own in frames.items())
    why = (
        f"{n_empty} of {n_frames} evaluated frames have no box"
        if n_empty
        else f"the {n_frames} evaluated frames do not follow one another"
    )
    text = (
        f"{why}, and {to} cannot list frames: read back by itself, {n_again} frames are evaluated"
    )
    return frames, "" if all(is_same) else text
