"""Read CVAT's XML into columns, and make a reading of them."""

from __future__ import annotations

import math
import re
from array import array
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Final, NamedTuple

import numpy as np
import pandas as pd

from nvcore.common.findings import Finding
from nvcore.dataset.schema import UNKNOWN_OCCLUSION
from nvcore.inputs.readers.base import (
    Lines,
    Reading,
    ReadOptions,
    SourceFile,
    best_overlaps,
    conversion_text,
    joined_findings,
    rows_finding,
)
from nvcore.inputs.readers.meaning.classes import (
    choose_classes,
    concerns_objects,
    labelled,
    rule_for,
)
from nvcore.inputs.readers.meaning.values import (
    attributes_of_boxes,
    class_of,
    is_ambiguous,
    joined_classes,
    level_of_words,
    levels_of_numbers,
)
from nvcore.inputs.readers.parse.xml import Element, file_stem, is_true, read_elements

CORNERS = ["x0", "y0", "x1", "y1"]
_SAME_OBJECT: Final = 0.7
"""IoU from which on an outline and a box of one label are the same object. (Our choice.)"""
IGNORE_ATTRIBUTES: Final = frozenset(
    {"ignore", "ignored", "iscrowd", "is_crowd", "crowd", "difficult", "dontcare", "don't care"}
)
"""Attributes that make a box an ignore region if they are true."""
SCORE_ATTRIBUTES: Final = frozenset({"score", "confidence", "conf"})
_OUTLINES: Final = frozenset({"polygon", "ellipse", "mask"})
"""Shapes that are represented by the box around them, as in COCO and YOLO."""
_COLUMNS = (
    *("owner", "frame", "x0", "y0", "x1", "y1", "rotation", "is_outline"),
    *("outside", "occluded", "keyframe", "ignore", "score", "line"),
)
_TYPES = dict.fromkeys(("owner", "frame", "line"), np.int64) | dict.fromkeys(
    ("is_outline", "outside", "keyframe", "ignore"), np.bool_
)
_TEXT_FACTS = {"id": "key", "name": "name", "source": "source"}
_FRAME_FACTS = {"size": "size", "start_frame": "start", "stop_frame": "stop"}
_TASK = re.compile(r"annotations/meta/(?:task|job|project/tasks/task)(?:/(?P<fact>.*))?")
_STEP = re.compile(r"\s*(?:step\s*=\s*(?P<step>[0-9]{1,9})\s*)?")


@dataclass
class CvatTask:
    """Facts of a task in the file: one video or one set of pictures.

    Attributes
    ----------
    key
        Number of the task in an export of a project; empty elsewhere.
    name, source
        Name of the task, file name of its video; empty where not given.
    width, height
        Size of the pictures, px; NaN where not given.
    start, step
        First frame and step between frames, in frame numbers of the video.
    stop, size
        Last frame and number of frames; None where not given.
    line
        Line of the task's description.
    """

    key: str = ""
    name: str = ""
    source: str = ""
    width: float = np.nan
    height: float = np.nan
    start: int = 0
    step: int = 1
    stop: int | None = None
    size: int | None = None
    line: int = 1

    @property
    def stated(self) -> str | None:
        """Name of the recording, as the task states it."""
        return file_stem(self.source) or self.name or None

    @property
    def n_frames(self) -> int | None:
        """Number of frames, or None if it is missing or contradictory."""
        spanned = None if self.stop is None else max((self.stop - self.start) // self.step + 1, 0)
        if self.size is None or spanned is None:
            return spanned if self.size is None else self.size
        return self.size if self.size == spanned else None

    @property
    def last(self) -> int | None:
        """Last frame, or None if it is not given."""
        if self.stop is None and self.size is not None:
            return self.start + self.step * (self.size - 1)
        return self.stop


class Owner(NamedTuple):
    """A track of a video, or a picture.

    Attributes
    ----------
    line
        Line of its element.
    task
        Key of its task, see `CvatTask`.
    track
        Id and label of a track; id -1 and empty for a picture.
    label
        See `track`.
    name, number, width, height
        Name, id and size of a picture. Empty, -1 and NaN for a track.
    """

    line: int
    task: str
    track: int = -1
    label: str = ""
    name: str = ""
    number: int = -1
    width: float = np.nan
    height: float = np.nan


@dataclass
class CvatContent:
    """Content of one file.

    Attributes
    ----------
    tasks
        Tasks by key.
    owners
        Tracks or pictures, in the order of the file, pictures without boxes too.
    boxes
        One row per box: owner (its position in `owners`), frame and line, int64; x0, y0, x1, y1
        (before it is rotated, px), rotation (clockwise about its middle, degrees), occluded (NaN:
        unknown) and score, float64; is_outline (the box around another shape), outside, keyframe
        and ignore, bool; label; attributes (classes named by the annotator), text.
    other_shapes
        (kind, label, line) of each shape without a box.
    declared
        Labels that the file declares.
    """

    tasks: dict[str, CvatTask] = field(default_factory=dict)
    owners: list[Owner] = field(default_factory=list)
    boxes: pd.DataFrame = field(default_factory=pd.DataFrame)
    other_shapes: list[tuple[str, str, int]] = field(default_factory=list)
    declared: list[str] = field(default_factory=list)

    @property
    def owner_table(self) -> pd.DataFrame:
        """The owners, one row each, with the fields of `Owner` as columns."""
        table = pd.DataFrame(self.owners, columns=list(Owner._fields))
        whole = dict.fromkeys(("line", "track", "number"), np.int64)
        return table.astype({**whole, "width": float, "height": float})


class _Parser:
    """Collector of the elements of one file."""

    def __init__(self, kind: str):
        self.kind = kind
        self.shapes = {f"annotations/{kind}/{tag}" for tag in ("box", *_OUTLINES)}
        self.content = CvatContent()
        self.values = array("d")
        self.labels: list[str] = []
        self.attributes: list[str] = []
        self.task: CvatTask | None = None
        self.source = ""
        self.owner: Element | None = None
        self.begin_shape(None)

    def take(self, element: Element) -> None:
        """Process an element at its end."""
        path, parent = element.path, element.parent
        outer, _, tag = path.rpartition("/")
        if path in self.shapes:
            self.take_shape(element)
        elif tag == "attribute" and outer in self.shapes:
            self.take_attribute(element)
        elif path.startswith("annotations/meta/"):
            self.take_meta(element)
        elif path == "annotations/image" or path == "annotations/track":
            if path != f"annotations/{self.kind}":
                other = "cvat-images" if self.kind == "track" else "cvat-video"
                raise element.fault(
                    f"expected <{self.kind}>, found <{element.tag}>: the file is {other}; give "
                    "that as its format"
                )
            if element is not self.owner:
                self.add_owner(element)
        elif (
            parent is not None
            and outer == f"annotations/{self.kind}"
            and tag != "tag"
            and element.attributes.get("outside") != "1"
        ):
            label = element.attributes.get("label", parent.attributes.get("label", ""))
            self.content.other_shapes.append((tag, label.strip(), element.line))

    def take_attribute(self, element: Element) -> None:
        """Apply an attribute to the shape that contains it."""
        assert element.parent is not None
        if element.parent is not self.shape:
            self.begin_shape(element.parent)
        name = element.attributes.get("name", "").strip().casefold()
        if name in IGNORE_ATTRIBUTES:
            self.is_ignored |= is_true(element.text)
        elif name == "occluded":
            self.is_occluded |= is_true(element.text)
        elif name == "occlusion":  # JAAD
            self.level = level_of_words(element.text)
        elif name in SCORE_ATTRIBUTES:
            self.score = element.number(element.text, name)
        else:
            self.classes.append(class_of(element.attributes.get("name", ""), element.text))

    def begin_shape(self, element: Element | None) -> None:
        """Start a shape without attributes."""
        self.shape = element
        self.is_ignored = self.is_occluded = False
        self.level, self.score = UNKNOWN_OCCLUSION, math.nan
        self.classes: list[str] = []

    def corners_of(self, element: Element) -> tuple[float, float, float, float]:
        """Return edges x0, y0, x1, y1 (px) of a box, or of the upright box around another shape."""

        def value(name: str) -> float:
            return element.number(element.attributes.get(name), name)

        if element.tag == "box":
            return value("xtl"), value("ytl"), value("xbr"), value("ybr")
        if element.tag == "mask":
            left, top = value("left"), value("top")
            return left, top, left + value("width"), top + value("height")
        if element.tag == "ellipse":
            x, y, across, down = map(value, ("cx", "cy", "rx", "ry"))
            turn = math.radians(value("rotation") % 360 if "rotation" in element.attributes else 0)
            wide = math.hypot(across * math.cos(turn), down * math.sin(turn))
            high = math.hypot(across * math.sin(turn), down * math.cos(turn))
            return x - wide, y - high, x + wide, y + high
        points = re.split("[,;]", self.text_of(element, "points"))
        edges = [element.number(text, "points") for text in points]
        if len(edges) % 2:
            raise element.fault("expected points x,y;x,y;..., found an odd number")
        return min(edges[::2]), min(edges[1::2]), max(edges[::2]), max(edges[1::2])

    def take_shape(self, element: Element) -> None:
        """Add a shape to the track or picture that contains it."""
        if element is not self.shape:
            self.begin_shape(element)
        assert element.parent is not None
        if element.parent is not self.owner:
            self.add_owner(element.parent)
        owner = self.content.owners[-1]
        get = element.attributes.get
        label, frame = owner.label, float(owner.number)
        if self.kind == "track":
            frame = element.whole_number(get("frame"), "frame")
        else:
            label = self.text_of(element, "label")
        occluded = 1.0 if self.is_occluded else element.number(get("occluded", ""), "occluded")
        occluded = occluded if self.level == UNKNOWN_OCCLUSION else float(self.level)
        self.values.extend(
            (
                len(self.content.owners) - 1,
                frame,
                *self.corners_of(element),
                element.number(get("rotation", "0"), "rotation") if element.tag == "box" else 0,
                element.tag != "box",
                is_true(get("outside")),
                occluded,
                is_true(get("keyframe", "1")),
                self.is_ignored,
                self.score,
                element.line,
            )
        )
        self.labels.append(label)
        self.attributes.append(joined_classes(self.classes) if self.classes else "")

    def add_owner(self, element: Element) -> None:
        """Add a track or a picture, at its end or at the first box in it."""
        self.owner = element
        get, line = element.attributes.get, element.line
        task, n_known = get("task_id", ""), len(self.content.owners)
        if self.kind == "track":
            track = element.whole_number(get("id", str(n_known)), "track id")
            owner = Owner(line, task, track=max(track, -1), label=self.text_of(element, "label"))
        else:
            owner = Owner(
                line,
                task,
                name=self.text_of(element, "name"),
                number=element.whole_number(get("id", str(n_known)), "image id"),
                width=element.number(get("width", ""), "width"),
                height=element.number(get("height", ""), "height"),
            )
        self.content.owners.append(owner)

    def text_of(self, element: Element, name: str) -> str:
        """Return a required attribute."""
        text = element.attributes.get(name)
        if text is None:
            raise element.fault(f"expected a {name} in <{element.tag}>, found none")
        return text.strip()

    def take_meta(self, element: Element) -> None:
        """Read an element of the file's header about labels or tasks."""
        if element.path == "annotations/meta/source":
            self.source = element.text
        elif element.path.endswith("/labels/label/name"):
            self.content.declared.append(element.text)
        match = _TASK.fullmatch(element.path)
        if match is None:
            return
        self.task = self.task or CvatTask()
        fact = match["fact"]
        if fact is None:  # the end of the task
            in_project = "/project/" in element.path
            self.task.line = element.line
            self.task.key = self.task.key if in_project else ""
            self.content.tasks[self.task.key] = self.task
            self.task = None
        else:
            self.take_fact(self.task, fact, element)

    def take_fact(self, task: CvatTask, fact: str, element: Element) -> None:
        """Read one fact about a task."""
        text = element.text
        if fact in _TEXT_FACTS:
            setattr(task, _TEXT_FACTS[fact], text)
        elif fact == "frame_filter":
            match = _STEP.fullmatch(text)
            if match is None or (match["step"] is not None and int(match["step"]) == 0):
                raise element.fault(f"expected a frame filter such as step=5, found {text[:60]!r}")
            task.step = int(match["step"] or 1)
        elif fact in ("original_size/width", "original_size/height"):
            setattr(task, element.tag, element.number(text, element.tag))
        elif fact in _FRAME_FACTS and text:
            value = element.whole_number(text, fact)
            if value < 0:
                raise element.fault(f"expected {fact} of 0 or more, found {value}")
            setattr(task, _FRAME_FACTS[fact], value)

    def finish(self) -> CvatContent:
        """Return the content at the end of the file."""
        values = np.array(self.values, dtype=np.float64).reshape(-1, len(_COLUMNS))
        boxes = pd.DataFrame(values, columns=list(_COLUMNS)).astype(_TYPES)
        self.content.boxes = boxes.assign(
            label=pd.Series(self.labels, dtype=object),
            attributes=pd.Series(self.attributes, dtype=object),
        )
        tasks = self.content.tasks
        if not tasks:
            tasks[""] = CvatTask()
        if len(tasks) == 1:
            task = next(iter(tasks.values()))
            task.source = task.source or self.source
        return self.content


def read_cvat(file: SourceFile, *, kind: str) -> CvatContent:
    """Read the content of a CVAT file.

    Parameters
    ----------
    file
        The file.
    kind
        ``track`` for CVAT for video, ``image`` for CVAT for images.

    Raises
    ------
    FormatError
        With file and line, if the file is not of that kind.
    """
    parser = _Parser(kind)
    for element in read_elements(file, root="annotations"):
        parser.take(element)
    return parser.finish()


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
    """Make the reading: sort classes, make rotated boxes upright, describe the conversion.

    Parameters
    ----------
    boxes
        Visible boxes of `CvatContent.boxes` of all files, with recording, track and file.
    declared
        Labels that the files declare.
    files, options
        Arguments of the reader.
    recordings, images, findings
        See `Reading`.
    facts
        Further parts of the conversion.
    """
    column = {str(name): values.to_numpy() for name, values in boxes.items()}
    label = column["label"]
    lines = Lines(files, column["file"], column["line"])
    choice = choose_classes(label, rule_for(None, {*label, *declared}, options), options, lines)
    codes, labels = labelled(label, choice.keep & ~choice.ignore, options.objects)
    is_truth = options.role == "truth"
    sides = _upright(boxes[CORNERS].to_numpy(), column["rotation"])
    is_double = _is_double(boxes.assign(**dict(zip("xywh", sides, strict=True))))
    keep = choice.keep & ~is_double
    changed = {
        "rotated boxes replaced by the upright box around them": keep
        & (np.nan_to_num(column["rotation"]) != 0),
        "polygons, ellipses or masks replaced by the box around them": keep & column["is_outline"],
        "polygons, ellipses or masks on a box of the same label left out": choice.keep & is_double,
    }
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
        *(f"{rows.sum()} {what}" for what, rows in changed.items() if rows.any()),
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
    """Mark outlines of objects that also have a box, if most outlines do. Bool, shape (n,)."""
    is_outline = boxes["is_outline"].to_numpy(copy=True)
    drawn, outlines = boxes[~is_outline], boxes[is_outline]
    overlap = best_overlaps(outlines, drawn, on=("recording", "frame", "label"))
    # a few overlaps may be one pedestrian in front of another
    are_most = np.count_nonzero(overlap >= _SAME_OBJECT) > len(overlap) / 2
    is_outline[is_outline] = (overlap >= _SAME_OBJECT) & are_most
    return is_outline


def _attributes(
    texts: np.ndarray, lines: Lines, is_truth: bool
) -> tuple[np.ndarray, list[Finding]]:
    """Collect classes named by annotators of the truth, and warn if a line has several boxes.

    Attributes are matched to boxes by line.
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
    """Return x, y, w, h of the upright box around each rotated one, shape (4, n)."""
    x0, y0, x1, y1 = corners.T
    # numbers near the largest float become infinite, which the dataset reports
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
    kinds = ", ".join(sorted({kind for kind, _, _ in shapes}))
    return rows_finding(
        np.ones(len(shapes), dtype=bool),
        "no-box",
        options.objects.say("{Many} drawn as ") + f"{kinds} were left out.",
        "Draw boxes, polygons, ellipses or masks in CVAT and export again.",
        role=options.role,
        place=lambda row: (
            file.name,
            f"line {shapes[row][2]}: {shapes[row][0]} of {shapes[row][1]}",
        ),
    )
