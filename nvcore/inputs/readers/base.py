"""What a reader gets and what it returns; shared by all formats."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from io import BufferedReader
from pathlib import Path
from typing import Any, Final, Literal

import numpy as np
import pandas as pd
from pandas.api.types import union_categoricals

from nvcore.dataset.sources import LeftOut as LeftOut
from nvcore.errors import FormatError, InputError
from nvcore.file_kinds import PACKED_HEAD_BYTES, packed_by
from nvcore.findings import Finding, Severity, Step
from nvcore.inputs.packed import Unpacking
from nvcore.inputs.pipes import open_stored
from nvcore.objects import PEDESTRIAN, Objects
from nvcore.schema import READING_DTYPES, conform

Role = Literal["truth", "detections"]
Numbering = Literal["coco", "list", "mot"]
"""How files number classes: by COCO's ids, by places in a list of names from 0, as MOT's truth."""
BOTH_ROLES: Final[tuple[Role, ...]] = ("truth", "detections")
_CHUNK: Final = 1 << 20


@dataclass(frozen=True)
class SourceFile:
    """One file to read.

    Attributes
    ----------
    path
        Where it lies on this machine.
    name
        How it is shown, and what recording and frame names are taken from: the path as the user
        gave it, or relative to the folder that was given, with ``/`` between its parts. Where the
        folder was an upload, the name is hostile: it is never joined to a path.
    """

    path: Path
    name: str

    @contextmanager
    def open(self) -> Iterator[BufferedReader]:
        """The content as bytes, from its beginning, unpacked; InputError if it cannot be read."""
        with self.open_stored() as stored:
            kind = packed_by(stored.peek(PACKED_HEAD_BYTES))
            if kind is None:
                yield stored
            else:
                n_bytes = os.fstat(stored.fileno()).st_size
                yield BufferedReader(Unpacking(stored, kind, n_bytes=n_bytes, fault=self.fault))

    @contextmanager
    def open_stored(self) -> Iterator[BufferedReader]:
        """The file as it is stored, packed or not; InputError if it cannot be read."""
        try:
            with open_stored(self.path) as stream:
                yield stream
        except OSError as error:
            raise InputError(f"cannot be opened ({error.strerror})", file=self.name) from error

    def is_larger_than(self, n_bytes: int) -> bool:
        """Whether the content, unpacked, has more bytes; InputError if it cannot be read."""
        with self.open() as stream:
            while n_bytes >= 0 and (part := stream.read(_CHUNK)):
                n_bytes -= len(part)
        return n_bytes < 0

    def fault(
        self, message: str, line: int | None = None, steps: tuple[Step, ...] = ()
    ) -> FormatError:
        """The error that refuses the content, as a whole or at a 1-based line; to be raised."""
        line = int(line) if line else None
        return FormatError(message, file=self.name, line=line, steps=steps)


@dataclass(frozen=True)
class Lines:
    """Where the rows of a reading stand.

    Attributes
    ----------
    files
        The files of the reading.
    file, line
        Index of the file and 1-based line of each row, int64, shape (n,).
    """

    files: Sequence[SourceFile]
    file: np.ndarray
    line: np.ndarray

    @classmethod
    def of(cls, file: SourceFile, line: np.ndarray) -> Lines:
        """Rows of a single file."""
        return cls((file,), np.zeros(len(line), dtype=np.int64), line)

    def __len__(self) -> int:
        return len(self.line)

    def __getitem__(self, rows: np.ndarray) -> Lines:
        return Lines(self.files, self.file[rows], self.line[rows])

    def fault(self, row: int | np.intp, message: str, steps: tuple[Step, ...] = ()) -> FormatError:
        """The error that refuses a row; to be raised."""
        file: SourceFile = self.files[self.file[row]]
        return file.fault(message, self.line[row], steps)

    def refuse(self, is_wrong: np.ndarray, message: Callable[[int], str]) -> None:
        """Raise FormatError for the first row that is wrong, with what `message` says of it."""
        if is_wrong.any():
            row = int(np.argmax(is_wrong))
            raise self.fault(row, message(row))

    def boxes(
        self, box: Iterable[object], *, keep: np.ndarray | None = None, **columns: object
    ) -> pd.DataFrame:
        """Boxes table of a reading, of these rows or those that stay.

        Parameters
        ----------
        box
            x, y, w, h, each of shape (n,), px.
        keep
            Rows that stay, bool, shape (n,); None: all.
        **columns
            What else is known, see `reading_boxes`; also another file or line.
        """
        columns = {"file": self.file, "line": self.line} | columns
        boxes = reading_boxes(len(self), **dict(zip("xywh", box, strict=True)), **columns)
        return boxes if keep is None else select_boxes(boxes, keep)

    def finding(
        self,
        is_odd: np.ndarray,
        code: str,
        message: str,
        advice: str,
        *,
        role: Role,
        example: Callable[[int], str] | None = None,
        severity: Severity = Severity.WARNING,
        steps: tuple[Step, ...] = (),
    ) -> list[Finding]:
        """`rows_finding`, with the line and, where given, the row as an example ("class 99")."""

        def place(row: int) -> tuple[str, str]:
            text = "" if example is None else f": {example(row)}"
            return self.files[self.file[row]].name, f"line {self.line[row]}{text}"

        return rows_finding(
            is_odd, code, message, advice, role=role, place=place, severity=severity, steps=steps
        )


NO_FRAME: Final = -1
"""Frame of a system's picture that is none of the truth's."""


@dataclass(frozen=True)
class NamedPictures:
    """The pictures of a list, each with its recording and frame.

    Attributes
    ----------
    table
        Columns recording, frame, name; one row per picture, in the order of the list.
    how
        How the names were understood: ``numbers``, ``times``, ``order`` or ``scenes``.
    facts
        The same in words, for the conversion text.
    rates
        Frames per second of recordings, where the names hold times.
    strange
        First name without a number, for which there is no table; -1: none.
    is_joined
        Whether pictures of the truth were found by name.
    empty
        Further pictures as in `table`, in which nobody is; None: none.
    findings
        What is odd about the list.
    """

    table: pd.DataFrame
    how: str = ""
    facts: tuple[str, ...] = ()
    rates: Mapping[str, float] = field(default_factory=dict)
    strange: int = -1
    is_joined: bool = False
    empty: pd.DataFrame | None = None
    findings: tuple[Finding, ...] = ()

    @property
    def with_empty(self) -> NamedPictures:
        """The list with the `empty` pictures."""
        if self.empty is None:
            return self
        return replace(
            self, table=pd.concat([self.table, self.empty], ignore_index=True), empty=None
        )

    @property
    def recording(self) -> np.ndarray:
        """Recording of each picture; object, shape (n,)."""
        return self.table["recording"].to_numpy(dtype=object)

    @property
    def frame(self) -> np.ndarray:
        """Frame number of each picture, or `NO_FRAME`; int64, shape (n,)."""
        return self.table["frame"].to_numpy(dtype=np.int64)

    @property
    def images(self) -> pd.DataFrame:
        """`Reading.images`, numbered from 1 in the order of recording and frame.

        So results of Caltech and KAIST number the images.
        """
        images = self.with_empty.table.sort_values(["recording", "frame"], ignore_index=True)
        numbered = images.assign(image_id=np.arange(1, len(images) + 1))
        return numbered.rename(columns={"name": "file_name"})


@dataclass(frozen=True)
class ReadOptions:
    """What a reader may need to know beside the files.

    Attributes
    ----------
    role
        Whether the files hold ground truth or a system's detections.
    objects
        What the boxes are of.
    classes
        Class names (or numbers, as text) that count as such objects; None: the format's default.
        Other classes that could be mistaken for them are ignore regions, the rest is left out;
        what a reader does with which class is part of its conversion text.
    size
        (width, height) of the pictures in pixels, where given by flag.
    frame_base
        Number of the first frame in the files, where the format does not say: 0 or 1.
    box_base
        0 or 1: coordinate of the first pixel, where files of one format differ (Pascal VOC).
    recordings
        Names of the recordings of the ground truth, for readers of detections.
    images
        The truth's image list (see `Reading.images`), for results that name images by id.
    categories, numbering
        Names of classes by their numbers in the files of the other side, and which numbers those
        are; for files that have no names of their own. Use `names_for`.
    frame_names
        How names of pictures and large numbers are understood: one of
        `nvcore.inputs.facts.FRAME_NAMES`; None: by what they look like.
    named
        The truth's pictures by name, for systems whose pictures have the same names or times.
    boxes
        Those of the truth, for what only they can decide.
    picture_folders
        Folders of pictures that the session names.
    """

    role: Role = "truth"
    objects: Objects = PEDESTRIAN
    classes: tuple[str, ...] | None = None
    size: tuple[int, int] | None = None
    frame_base: int | None = None
    box_base: int | None = None
    recordings: tuple[str, ...] = ()
    images: pd.DataFrame | None = None
    categories: Mapping[str, str] = field(default_factory=dict)
    numbering: Numbering = "coco"
    frame_names: str | None = None
    named: NamedPictures | None = None
    boxes: pd.DataFrame | None = None
    picture_folders: tuple[Path, ...] = ()

    def names_for(self, numbering: Numbering) -> Mapping[str, str]:
        """The other side's names of classes, if it numbers them so; else none.

        Numbers of one kind say nothing about those of another: COCO's begin anywhere.
        """
        return self.categories if self.numbering == numbering else {}


@dataclass(frozen=True)
class Reading:
    """What one call of a reader returns.

    Attributes
    ----------
    boxes
        Columns of `READING_DTYPES`, in file order, in the conventions of docs/formats.md: 0-based
        continuous pixels, x, y, w, h. `file` counts the files as they were given.
    recordings
        One row per recording: name, width, height, fps (NaN where the files do not say).
    images
        Where the format lists its images (and so the evaluated frames): columns recording, frame,
        image_id, in the order of the file. Else None.
    annotated
        Frames with a row of any class, also of those that were left out: columns recording, frame,
        each pair once. None: those of `boxes`.
    conversion
        In words, what was converted: "frames kept, pixels from 1-based to 0-based; ...".
    findings
        Recoverable oddities.
    attributes
        Columns of `ATTRIBUTE_DTYPES`: texts of boxes of the truth, for the classes of encounters;
        None: there are none.
    labels
        What the column `label` of `boxes` counts: classes in the words of the objects ("70"), of
        the boxes that are not ignored.
    categories, numbering
        Names of classes by their numbers, and which numbers those are, for files of the other side
        that number classes in the same way and have no names.
    classes
        Numbers of the classes that count, where names in another file said which they are: stated
        in a session they need that file no more. Else empty.
    left_out
        What of the files is not used, the most first; `conversion` says it in words.
    layout
        What the four numbers of a box were taken for: the text of a
        `nvcore.inputs.box_layouts.BoxLayout`.
    is_laid_out
        Whether that was given and differs from what the format has.
    has_score_beside
        Whether the score may stand before the four numbers as well as behind them.
    usual
        Fields of `nvcore.inputs.session.Source`, with what is taken where they are not given: so
        given, they change nothing.
    named
        The pictures by name, where the files name them.
    """

    boxes: pd.DataFrame
    recordings: pd.DataFrame
    conversion: str
    images: pd.DataFrame | None = None
    annotated: pd.DataFrame | None = None
    findings: tuple[Finding, ...] = ()
    attributes: pd.DataFrame | None = None
    labels: tuple[str, ...] = ()
    categories: Mapping[str, str] = field(default_factory=dict)
    numbering: Numbering = "coco"
    classes: tuple[str, ...] = ()
    left_out: tuple[LeftOut, ...] = ()
    layout: str = "sizes"
    is_laid_out: bool = False
    has_score_beside: bool = False
    usual: Mapping[str, Any] = field(default_factory=dict)
    named: NamedPictures | None = None


Read = Callable[[Sequence[SourceFile], ReadOptions], Reading]


@dataclass(frozen=True)
class Format:
    """One readable format.

    Attributes
    ----------
    name
        Name for ``--format``.
    title
        Name for people.
    roles
        What such files can hold.
    suffixes
        File name endings that belong to it, with the dot, lower case.
    recognise
        (file name, first 64 KiB as text, role) -> whether the content is this format. Formats are
        tried in the order of the registry; the first match is taken.
    read
        The reader. Like every reader it raises FormatError with file and line (or record) of the
        first thing that the format does not have; MissingFactError for what the files do not say
        (the size of pictures, the truth's image list); and InputError if a class is unknown, a
        file's name has no frame number, or two files are of one recording or one frame.
    """

    name: str
    title: str
    roles: tuple[Role, ...]
    suffixes: tuple[str, ...]
    recognise: Callable[[str, str, Role], bool]
    read: Read = field(repr=False)


def rows_finding(
    is_odd: np.ndarray,
    code: str,
    message: str,
    advice: str,
    *,
    role: str,
    place: Callable[[int], tuple[str, str]],
    severity: Severity = Severity.WARNING,
    steps: tuple[Step, ...] = (),
) -> list[Finding]:
    """One finding about all odd rows, shown by the first of them; none where no row is odd.

    Parameters
    ----------
    is_odd
        bool, shape (n,).
    code, message, advice, severity, steps
        See `Finding`.
    role
        What the files hold.
    place
        Row -> name of its file, and the row as an example ("line 3: class 99").
    """
    if not is_odd.any():
        return []
    file, example = place(int(np.argmax(is_odd)))
    count = int(np.count_nonzero(is_odd))
    return [Finding(severity, code, role, count, message, advice, file, example, steps=steps)]


def joined_findings(findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """Findings of one kind about several files as one: all rows counted, the first file named."""
    groups: dict[Finding, list[Finding]] = {}
    for finding in findings:
        groups.setdefault(replace(finding, count=0, file="", example=""), []).append(finding)
    joined = []
    for group in groups.values():
        first, n_files = group[0], len({finding.file for finding in group})
        count = sum(finding.count for finding in group)
        message = first.message + (f" They stand in {n_files} files." if n_files > 1 else "")
        joined.append(replace(first, count=count, message=message))
    return tuple(joined)


def warning(code: str, count: int, message: str, advice: str, *, role: str, **more: Any) -> Finding:
    """A warning about what the files of a role, or of a system, hold; see `Finding`."""
    return Finding(Severity.WARNING, code, role, count, message, advice, **more)


def reading_boxes(n_rows: int, **columns: object) -> pd.DataFrame:
    """Boxes table of a reading from the columns that the format has; the rest is unknown."""
    return conform(columns, READING_DTYPES, n_rows=n_rows, repeat=np.broadcast_to)


def select_boxes(boxes: pd.DataFrame, keep: np.ndarray) -> pd.DataFrame:
    """The boxes that stay, renumbered; no copy where all do."""
    return boxes if keep.all() else boxes[keep].reset_index(drop=True)


def best_overlaps(
    boxes: pd.DataFrame, others: pd.DataFrame, on: Sequence[str] = ("recording", "frame")
) -> np.ndarray:
    """Best IoU of each box with the others that are equal in these columns, 0 to 1; shape (n,)."""
    here, there = (part[[*on, *"xywh"]].astype({"recording": object}) for part in (boxes, others))
    pairs = here.assign(row=np.arange(len(here))).merge(there, on=[*on], suffixes=("", "_other"))
    across, down = (
        np.minimum(pairs[at] + pairs[size], pairs[f"{at}_other"] + pairs[f"{size}_other"])
        - np.maximum(pairs[at], pairs[f"{at}_other"])
        for at, size in (("x", "w"), ("y", "h"))
    )
    common = np.maximum(across, 0) * np.maximum(down, 0)
    iou = common / (pairs["w"] * pairs["h"] + pairs["w_other"] * pairs["h_other"] - common)
    best = iou.groupby(pairs["row"]).max()
    return np.asarray(best.reindex(range(len(boxes)), fill_value=0.0))


def object_array(texts: Iterable[str]) -> np.ndarray:
    """Texts as an array of object, shape (n,); numpy would make a wide array of text of them."""
    return np.array([*texts, None], dtype=object)[:-1]


def annotated_frames(recording: object, frame: np.ndarray) -> pd.DataFrame:
    """`Reading.annotated` from the recording (one, or of each row) and the frame of all rows."""
    pairs = pd.DataFrame({"recording": recording, "frame": frame}, columns=["recording", "frame"])
    return pairs.drop_duplicates(ignore_index=True)


def image_list(recordings: Sequence[str], frames: Sequence[np.ndarray]) -> pd.DataFrame:
    """`Reading.images` of recordings with these frames, which are the ids of their images."""
    frame = np.concatenate([np.empty(0, dtype=np.int64), *frames])
    recording = np.repeat(object_array(recordings), [len(listed) for listed in frames])
    return pd.DataFrame({"recording": recording, "frame": frame, "image_id": frame})


def concat_boxes(tables: Sequence[pd.DataFrame]) -> pd.DataFrame:
    """Boxes of several files in one table; no file gives an empty table with all columns."""
    if not tables:
        return reading_boxes(0)
    # categories of an empty table are of another dtype, and it adds nothing
    filled = [table for table in tables if len(table)] or list(tables[:1])
    if len(filled) == 1:
        return filled[0]
    names = union_categoricals([table["recording"] for table in filled])
    boxes = pd.concat([table.drop(columns="recording") for table in filled], ignore_index=True)
    boxes.insert(0, "recording", pd.Series(names))
    return boxes


def recordings_table(
    names: Iterable[str],
    *,
    width: object = np.nan,
    height: object = np.nan,
    fps: object = np.nan,
) -> pd.DataFrame:
    """The recordings of a reading; doubles by name are dropped.

    Parameters
    ----------
    names
        Names of the recordings.
    width, height, fps
        Of all, or of each; NaN where unknown.
    """
    table = pd.DataFrame(
        {"name": object_array(names), "width": width, "height": height, "fps": fps}
    )
    types = {"name": object, "width": float, "height": float, "fps": float}
    return table.astype(types).drop_duplicates("name", ignore_index=True)


def conversion_text(facts: Iterable[str]) -> str:
    """`Reading.conversion` from its parts, each named once; empty ones are passed over."""
    return "; ".join(dict.fromkeys(fact for fact in facts if fact))
