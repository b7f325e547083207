"""From CVAT's boxes, of videos and of pictures, to a reading."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from typing import Final

import numpy as np
import pandas as pd

from nvcore.findings import Finding
from nvcore.inputs.readers.base import (
    Lines,
    Reading,
    ReadOptions,
    SourceFile,
    best_overlaps,
    conversion_text,
    joined_findings,
    warning,
)
from nvcore.inputs.readers.cvat.xml import CvatContent
from nvcore.inputs.readers.meaning.attributes import attributes_of_boxes, is_ambiguous
from nvcore.inputs.readers.meaning.categories import concerns_objects, free_labels
from nvcore.inputs.readers.meaning.classes import choose_classes
from nvcore.inputs.readers.meaning.labels import labelled
from nvcore.inputs.readers.meaning.values import levels_of_numbers

CORNERS = ["x0", "y0", "x1", "y1"]
_SAME_OBJECT: Final = 0.7
"""IoU from which on an outline is taken for the object of a box of its label. (Our choice.)"""


def boxes_reading(
    boxes: pd.DataFrame,
    declared: Iterable[str],
    files: Sequence[SourceFile],
    options: ReadOptions,
    recordings: pd.DataFrame,
    images: pd.DataFrame | None,
    *,
    facts: Sequence[str],
    findings: Sequence[Finding],
) -> Reading:
    """The reading: classes sorted, rotated boxes made upright, the conversion in words.

    Parameters
    ----------
    boxes
        `CvatContent.boxes` of all files, those that are visible, with recording, track and file.
    declared
        Labels that the files declare.
    files, options
        As a reader gets them.
    recordings, images, findings
        As in `Reading`.
    facts
        Further parts of the conversion.
    """
    column = {str(name): values.to_numpy() for name, values in boxes.items()}
    label = column["label"]
    lines = Lines(files, column["file"], column["line"])
    choice = choose_classes(label, free_labels({*label, *declared}, options), options, lines)
    codes, labels = labelled(label, choice.keep & ~choice.ignore, options.objects)
    is_truth = options.role == "truth"
    sides = _upright(boxes[CORNERS].to_numpy(), column["rotation"])
    is_double = _is_double(boxes.assign(**dict(zip("xywh", sides, strict=True))))
    keep = choice.keep & ~is_double
    n_rotated = int((keep & (np.nan_to_num(column["rotation"]) != 0)).sum())
    n_outlines = int((keep & column["is_outline"]).sum())
    n_doubles = int((choice.keep & is_double).sum())
    upright = lines.boxes(
        sides,
        keep=keep,
        recording=column["recording"],
        frame=column["frame"],
        score=column["score"],
        track=column["track"],
        ignore=(choice.ignore | column["ignore"]) & is_truth,
        occlusion=levels_of_numbers(column["occluded"]),
        label=codes,
    )
    texts, ambiguous = _attributes(column["attributes"][keep], lines[keep], is_truth)
    attributes = attributes_of_boxes(upright, texts)
    ignoring = "attributes such as ignore or iscrowd = ignore; occluded = partial occlusion"
    steps = [
        "corners to width and height (0-based, continuous)",
        *facts,
        choice.fact,
        ignoring if is_truth else "",
        "other attributes as classes of encounters" if attributes is not None else "",
        f"{n_rotated} rotated boxes replaced by the upright box around them" if n_rotated else "",
        f"{n_outlines} polygons, ellipses or masks replaced by the box around them"
        if n_outlines
        else "",
        f"{n_doubles} polygons, ellipses or masks on a box of the same label left out"
        if n_doubles
        else "",
    ]
    return Reading(
        boxes=upright,
        recordings=recordings,
        conversion=conversion_text(steps),
        images=images,
        findings=(*joined_findings(findings), *choice.findings, *ambiguous),
        attributes=attributes,
        labels=labels,
        left_out=choice.left_out,
        layout="corners",
    )


def _is_double(boxes: pd.DataFrame) -> np.ndarray:
    """Whether each row is the outline of an object that has a box, too; bool, shape (n,)."""
    is_outline = boxes["is_outline"].to_numpy(copy=True)
    drawn, outlines = boxes[~is_outline], boxes[is_outline]
    overlap = best_overlaps(outlines, drawn, on=("recording", "frame", "label"))
    is_outline[is_outline] = overlap >= _SAME_OBJECT
    return is_outline


def _attributes(
    texts: np.ndarray, lines: Lines, is_truth: bool
) -> tuple[np.ndarray, list[Finding]]:
    """Classes named by the annotators of the truth, and a warning where a line has several boxes.

    Attributes are found again by the line of the box.
    """
    if not is_truth:
        return np.full(len(texts), "", dtype=object), []
    is_shared = is_ambiguous(lines.file, lines.line, texts)
    findings = lines.finding(
        is_shared,
        "shared-line",
        "Boxes with different attributes stand in one line of the file: their attributes are left "
        "out.",
        "Write each box in a line of its own, as xmllint formats XML.",
        role="truth",
    )
    return np.where(is_shared, "", texts), findings


def _upright(corners: np.ndarray, rotation: np.ndarray) -> np.ndarray:
    """x, y, w, h of the upright box around each rotated one, shape (4, n)."""
    x0, y0, x1, y1 = corners.T
    # numbers near the largest float pass through as infinite, the dataset reports them
    with np.errstate(invalid="ignore", over="ignore"):
        width, height = x1 - x0, y1 - y0
        cosine = np.abs(np.cos(np.radians(rotation)))
        sine = np.abs(np.sin(np.radians(rotation)))
        wide = width * cosine + height * sine
        high = width * sine + height * cosine
        x, y = (x0 + x1 - wide) / 2, (y0 + y1 - high) / 2
    is_upright = np.nan_to_num(rotation) == 0
    return np.where(is_upright, (x0, y0, width, height), (x, y, wide, high))


def other_shapes(content: CvatContent, file: SourceFile, options: ReadOptions) -> list[Finding]:
    """Return a warning of pedestrians drawn as lines, points and other shapes without a box."""
    shapes = [shape for shape in content.other_shapes if concerns_objects(shape[1], options)]
    if not shapes:
        return []
    kinds = Counter(kind for kind, _, _ in shapes)
    listed = ", ".join(sorted(kinds))
    kind, label, line = shapes[0]
    return [
        warning(
            "no-box",
            len(shapes),
            options.objects.say("{Many} drawn as ") + f"{listed} were left out.",
            "Draw boxes, polygons, ellipses or masks in CVAT and export again.",
            role=options.role,
            file=file.name,
            example=f"line {line}: {kind} of {label}",
        )
    ]
