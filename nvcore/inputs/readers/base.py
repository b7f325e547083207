"""Inputs and results of readers, shared by all formats."""

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

from nvcore.common.errors import FormatError, InputError
from nvcore.common.file_kinds import PACKED_HEAD_BYTES, packed_by
from nvcore.common.findings import Finding, Severity, Step
from nvcore.dataset.schema import READING_DTYPES, conform
from nvcore.dataset.sources import LeftOut as LeftOut
from nvcore.inputs.files.packed import Unpacking
from nvcore.inputs.files.pipes import open_stored
from nvcore.settings.objects import PEDESTRIAN, Objects

Role = Literal["truth", "detections"]
Numbering = Literal["coco", "list", "mot"]
"""Class numbers in files: COCO's ids, indices of a list of names, or those of MOT's truth."""
BOTH_ROLES: Final[tuple[Role, ...]] = ("truth", "detections")
_CHUNK: Final = 1 << 20


@dataclass(frozen=True)
class SourceFile:
    """One file to read.

    Attributes
    ----------
    path
        Location on this machine.
    name
        Name for display, from which recording and frame are parsed: the path as the user gave it,
        or relative to the given folder, with ``/`` as separator. The name may come from an upload,
        so it is not to be trusted and never joined to a path.
    """

    path: Path
    name: str

    @contextmanager
    def open(self) -> Iterator[BufferedReader]:
        """Open the decompressed content, or raise InputError if it cannot be read."""
        with self.open_stored() as stored:
            kind = packed_by(stored.peek(PACKED_HEAD_BYTES))
            if kind is None:
                yield stored
            else:
                n_bytes = os.fstat(stored.fileno()).st_size
                yield BufferedReader(Unpacking(stored, kind, n_bytes=n_bytes, fault=self.fault))

    @contextmanager
    def open_stored(self) -> Iterator[BufferedReader]:
        """Open the file without decompressing it, or raise InputError if it cannot be read."""
        try:
            with open_stored(self.path) as stream:
                yield stream
        except OSError as error:
            raise InputError(f"cannot be opened ({error.strerror})", file=self.name) from error

    def is_larger_than(self, n_bytes: int) -> bool:
        """Whether the decompressed content has more bytes. InputError if it cannot be read."""
        with self.open() as stream:
            while n_bytes >= 0 and (part := stream.read(_CHUNK)):
                n_bytes -= len(part)
        return n_bytes < 0

    def fault(
        self, message: str, line: int | None = None, steps: tuple[Step, ...] = ()
    ) -> FormatError:
        """Return an error about the file or one of its lines (1-based), for the caller to raise."""
        line = int(line) if line else None
        return FormatError(message, file=self.name, line=line, steps=steps)


@dataclass(frozen=True)
class Lines:
    """File and line of each row of a reading.

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
        """Return the lines of a single file."""
        return cls((file,), np.zeros(len(line), dtype=np.int64), line)

    def __len__(self) -> int:
        return len(self.line)

    def __getitem__(self, rows: np.ndarray) -> Lines:
        return Lines(self.files, self.file[rows], self.line[rows])

    def fault(self, row: int | np.intp, message: str, steps: tuple[Step, ...] = ()) -> FormatError:
        """Return an error about a row, for the caller to raise."""
        file: SourceFile = self.files[self.file[row]]
        return file.fault(message, self.line[row], steps)

    def refuse(self, is_wrong: np.ndarray, message: Callable[[int], str]) -> None:
        """Raise FormatError with `message` for the first wrong row, if there is one."""
        if is_wrong.any():
            row = int(np.argmax(is_wrong))
            raise self.fault(row, message(row))

    def boxes(
        self, box: Iterable[object], *, keep: np.ndarray | None = None, **columns: object
    ) -> pd.DataFrame:
        """Make the boxes table of a reading from these rows, or from the kept ones.

        Parameters
        ----------
        box
            x, y, w, h, each of shape (n,), px.
        keep
            Rows to keep, bool, shape (n,). None: all.
        **columns
            Other known columns (see `reading_boxes`), or another file or line.
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
        """Call `rows_finding` with the line and an optional `example` of a row ("class 99")."""

        def place(row: int) -> tuple[str, str]:
            text = "" if example is None else f": {example(row)}"
            return self.files[self.file[row]].name, f"line {self.line[row]}{text}"

        return rows_finding(
            is_odd, code, message, advice, role=role, place=place, severity=severity, steps=steps
        )


NO_FRAME: Final = -1
"""Frame number of a system's picture that the truth does not have."""


@dataclass(frozen=True)
class NamedPictures:
    """Listed pictures with their recordings and frames.

    Attributes
    ----------
    table
        Columns recording, frame, name; one row per picture, in the order of the list.
    how
        Interpretation of the names: ``numbers``, ``times``, ``order`` or ``scenes``.
    facts
        Description of the interpretation, for the conversion text.
    rates
        Frames per second of recordings, if the names contain times.
    strange
        Index of the first name without a number, if there is no table. -1: none.
    is_joined
        Whether pictures of the truth were found by name.
    empty
        Further pictures as in `table`, without boxes. None: none.
    findings
        Oddities of the list.
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
        """The list with the `empty` pictures included."""
        if self.empty is None:
            return self
        return replace(
            self, table=pd.concat([self.table, self.empty], ignore_index=True), empty=None
        )

    @property
    def recording(self) -> np.ndarray:
        """Recording of each picture, object, shape (n,)."""
        return self.table["recording"].to_numpy(dtype=object)

    @property
    def frame(self) -> np.ndarray:
        """Frame number of each picture or `NO_FRAME`, int64, shape (n,)."""
        return self.table["frame"].to_numpy(dtype=np.int64)

    @property
    def images(self) -> pd.DataFrame:
        """`Reading.images`, numbered from 1 in the order of recording and frame.

        Results of Caltech and KAIST use these numbers.
        """
        images = self.with_empty.table.sort_values(["recording", "frame"], ignore_index=True)
        numbered = images.assign(image_id=np.arange(1, len(images) + 1))
        return numbered.rename(columns={"name": "file_name"})


@dataclass(frozen=True)
class ReadOptions:
    """Options of a reader.

    Attributes
    ----------
    role
        Ground truth or a system's detections.
    objects
        Kind of objects in the boxes.
    classes
        Class names (or numbers, as text) that count as such objects. None: the format's default.
        Other classes that could be mistaken for the objects become ignore regions. The rest is
        left out. The reader's conversion text says how it treats each class.
    size
        (width, height) of the pictures in pixels, if a flag gives it.
    frame_base
        Number of the first frame in the files, 0 or 1, for formats that do not define it.
    box_base
        Coordinate of the first pixel, 0 or 1, for a format whose files differ (Pascal VOC).
    recordings
        Names of the recordings of the ground truth, for readers of detections.
    images
        The truth's image list (see `Reading.images`), for results that name images by id.
    categories, numbering
        Names of classes by their numbers in the files of the other side, and the kind of these
        numbers, for files without names of their own. Use `names_for`.
    frame_names
        Interpretation of picture names and large numbers: one of
        `nvcore.inputs.facts.FRAME_NAMES`, or None to infer it.
    named
        The truth's pictures by name, for systems whose pictures have the same names or times.
    boxes
        Boxes of the truth, which resolve ambiguities of detections.
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
        """Return the other side's names of classes if it uses this numbering, else none.

        Numbers of different kinds are unrelated. For example, COCO's start anywhere.
        """
        return self.categories if self.numbering == numbering else {}


@dataclass(frozen=True)
class Reading:
    """Result of a reader.

    Attributes
    ----------
    boxes
        Columns of `READING_DTYPES`, in file order, in the conventions of docs/formats.md: 0-based
        continuous pixels, x, y, w, h. `file` is the index of the file.
    recordings
        One row per recording: name, width, height, fps (NaN if unknown).
    images
        Image list of formats that have one: columns recording, frame, image_id, in the order of
        the file. It defines the evaluated frames. None for other formats.
    annotated
        Frames with a row of any class, even one that was left out: columns recording, frame, each
        pair once. None: the frames of `boxes`.
    conversion
        Description of the conversion: "frames kept, pixels from 1-based to 0-based; ...".
    findings
        Recoverable oddities.
    attributes
        Columns of `ATTRIBUTE_DTYPES`: texts of the truth's boxes, for the classes of encounters.
        None: there are none.
    labels
        Classes that the column `label` of `boxes` indexes, in the objects' terms ("70"), without
        those of ignored boxes.
    categories, numbering
        Names of classes by their numbers, and the kind of these numbers, for files of the other
        side that use the same numbers and have no names.
    classes
        Numbers of the classes that count, if names in another file decided it. A session that
        states them does not need that file. Otherwise empty.
    left_out
        Unused content of the files, the most frequent first. `conversion` describes it.
    layout
        Meaning of the four numbers of a box: the text of a
        `nvcore.inputs.box_layouts.BoxLayout`.
    is_laid_out
        Whether the layout was given and differs from the format's.
    has_score_beside
        Whether the score may be before or after the four numbers.
    usual
        Fields of `nvcore.inputs.session.Source` with their defaults for these files. Stating them
        changes nothing.
    named
        Pictures by name, if the files name them.
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
        Roles that files of the format can have.
    suffixes
        File name endings that belong to it, with the dot, lower case.
    recognise
        (file name, first 64 KiB as text, role) -> whether the content is in this format. The first
        match in the order of the registry is used.
    read
        The reader. It raises FormatError with file and line (or record) of the first violation of
        the format, MissingFactError for facts that the files lack (the size of pictures, the
        truth's image list), and InputError if a class is unknown, a file's name has no frame
        number, or two files belong to one recording or one frame.
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
    """Make one finding about all odd rows, with the first as an example, or none.

    Parameters
    ----------
    is_odd
        bool, shape (n,).
    code, message, advice, severity, steps
        See `Finding`.
    role
        Role of the files.
    place
        Function from a row to the name of its file and an example text ("line 3: class 99").
    """
    if not is_odd.any():
        return []
    file, example = place(int(np.argmax(is_odd)))
    count = int(np.count_nonzero(is_odd))
    return [Finding(severity, code, role, count, message, advice, file, example, steps=steps)]


def joined_findings(findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """Merge findings of one kind about several files, adding counts and naming the first file."""
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
    """Make a warning about the files of a role or of a system (see `Finding`)."""
    return Finding(Severity.WARNING, code, role, count, message, advice, **more)


def reading_boxes(n_rows: int, **columns: object) -> pd.DataFrame:
    """Make a boxes table from the columns that the format has, with the rest unknown."""
    return conform(columns, READING_DTYPES, n_rows=n_rows, repeat=np.broadcast_to)


def select_boxes(boxes: pd.DataFrame, keep: np.ndarray) -> pd.DataFrame:
    """Select boxes and renumber them, without a copy if all are kept."""
    return boxes if keep.all() else boxes[keep].reset_index(drop=True)


def best_overlaps(
    boxes: pd.DataFrame, others: pd.DataFrame, on: Sequence[str] = ("recording", "frame")
) -> np.ndarray:
    """Return each box's best IoU with `others` of equal `on` columns, 0 to 1, shape (n,)."""
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
    """Make an object array of texts, shape (n,), where numpy would use fixed-width text."""
    return np.array([*texts, None], dtype=object)[:-1]


def annotated_frames(recording: object, frame: np.ndarray) -> pd.DataFrame:
    """Make `Reading.annotated` from recordings (one, or one per row) and frames of rows."""
    pairs = pd.DataFrame({"recording": recording, "frame": frame}, columns=["recording", "frame"])
    return pairs.drop_duplicates(ignore_index=True)


def image_list(recordings: Sequence[str], frames: Sequence[np.ndarray]) -> pd.DataFrame:
    """Make `Reading.images` of recordings with these frames, which serve as image ids."""
    frame = np.concatenate([np.empty(0, dtype=np.int64), *frames])
    recording = np.repeat(object_array(recordings), [len(listed) for listed in frames])
    return pd.DataFrame({"recording": recording, "frame": frame, "image_id": frame})


def concat_boxes(tables: Sequence[pd.DataFrame]) -> pd.DataFrame:
    """Concatenate boxes of several files. No files give an empty table with all columns."""
    if not tables:
        return reading_boxes(0)
    # the categories of an empty table have another dtype
    filled = [table for table in tables if len(table)] or list(tables[:1])
    if len(filled) == 1:
        return filled[0]
    names = union_categoricals([table["recording"] for table in filled])
    boxes = pd.concat([table.drop(columns="recording") for table in filled], ignore_index=True)
    boxes.insert(0, "recording", pd.Series(names))
    return boxes


def recordings_table(
    names: Iterable[str], *, width: object = np.nan, height: object = np.nan, fps: object = np.nan
) -> pd.DataFrame:
    """Make a table of recordings, dropping duplicate names.

    Parameters
    ----------
    names
        Names of the recordings.
    width, height, fps
        One value for all, or one for each; NaN if unknown.
    """
    table = pd.DataFrame(
        {"name": object_array(names), "width": width, "height": height, "fps": fps}
    )
    types = {"name": object, "width": float, "height": float, "fps": float}
    return table.astype(types).drop_duplicates("name", ignore_index=True)


def conversion_text(facts: Iterable[str]) -> str:
    """Join the parts of `Reading.conversion`, dropping empty and repeated ones."""
    return "; ".join(dict.fromkeys(fact for fact in facts if fact))
