"""Session: the inputs of one comparison, facts that they lack, and settings."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, get_type_hints

from nvcore.common.errors import SessionError
from nvcore.common.file_kinds import composed
from nvcore.common.subject import subjects
from nvcore.inputs.box_layouts import parse_layout
from nvcore.inputs.facts import (
    FRAME_NAMES,
    check_finite,
    check_path,
    check_paths,
    check_positive,
    check_rate,
    expect,
    is_frame_range,
    path_field,
    paths_in,
    with_paths_in,
)
from nvcore.settings.defaults import Settings, as_names, new_names
from nvcore.settings.params.traffic import parse_context

_KEYS: Final = [subject.session_keys() for subject in subjects()]
if TYPE_CHECKING:
    from nvcore.inputs.readers.base import Role

    class KeysOfSubjects:
        """Base of classes with fields that subjects add, by name."""

        def __getattr__(self, name: str) -> Any: ...

    TablesOfSubjects = KeysOfSubjects
    SystemKeysOfSubjects = KeysOfSubjects
else:

    def _base(*kinds: Sequence[type]) -> type:
        return type("OfSubjects", tuple(chain(*kinds))[::-1], {})  # fields of the last come first

    KeysOfSubjects = _base(*(keys.recording for keys in _KEYS))
    SystemKeysOfSubjects = _base(*(keys.system for keys in _KEYS))
    TablesOfSubjects = _base(*(keys.tables for keys in _KEYS))

MAX_OFFSET_FRAMES: Final = 1_000_000
"""Largest correction of frame numbers."""
_MAX_FRAME: Final = 2**53
"""Frame numbers are exact in every table up to here."""
GREATEST_SCALE: Final = 100.0
"""Limit of the scale in `visible_map`: visible pixels per pixel of the recording."""
GREATEST_OFFSET_PX: Final = 100_000.0
"""Limit of the offset in `visible_map`."""
TABLES_OF_SUBJECTS: Final[Mapping[str, type]] = {
    name: kind for keys in _KEYS for of in keys.tables for name, kind in get_type_hints(of).items()
}
"""Types of the session tables that subjects add, by name."""
SYSTEM_KEYS_OF_SUBJECTS: Final = tuple(
    name for keys in _KEYS for of in keys.system for name in get_type_hints(of)
)
"""Keys of a ``[[system]]`` that subjects add."""


@dataclass(frozen=True)
class RecordingEntry(KeysOfSubjects):
    """A ``[[recording]]`` of a session, with fields of subjects. None: as in the data.

    `pictures` is a video, a folder or an archive. `first_picture` is the frame number of its
    first picture. `visible` are pictures of visible light that accompany the `pictures` of
    another camera. `visible_map` (sx, sy, dx, dy) maps a point (x, y) of the recording, px, to
    (sx x + dx, sy y + dy) in `visible`; None: by the ratio of the sizes. `context` is the traffic
    context, from 0 (urban) to 1 (rural). `speed_kmh` is the speed of the car, and `speed` a CSV
    file of it over time (`nvcore.inputs.speed`). `tags` are words to choose recordings by, such
    as "night". `title` replaces the name in the data. Recordings of one `unit` (a drive, a route,
    a car) are not independent, so tests and intervals treat them as one.
    """

    name: str
    width: float | None = None
    height: float | None = None
    fps: float | None = None
    frames: str | None = None
    horizon: float | None = None
    pictures: str | None = path_field()
    first_picture: int | None = None
    tags: tuple[str, ...] = ()
    context: float | None = None
    title: str | None = None
    speed_kmh: float | None = None
    unit: str | None = None
    visible: str | None = path_field()
    visible_map: tuple[float, float, float, float] | None = None
    speed: str | None = path_field(label="Speed of the car over time (CSV: time_s,speed_kmh)")

    def __post_init__(self) -> None:
        object.__setattr__(self, "tags", as_names(self.tags))
        expect(bool(self.name), "expected a name of the recording")
        for name in ("title", "unit"):
            text = getattr(self, name)
            expect(text is None or bool(text.strip()), f"{name}: expected a name, found nothing")
        for name in ("width", "height", "speed_kmh"):
            check_positive(name, getattr(self, name))
        check_rate(self.fps)
        check_finite("horizon", self.horizon)
        if self.context is not None:
            try:
                parse_context(self.context)
            except ValueError as error:
                raise SessionError(f"context: {error}") from error
        expect(
            abs(self.first_picture or 0) <= _MAX_FRAME,
            f"first_picture: expected a frame number, found {self.first_picture}",
        )
        check_path("frames", self.frames)
        check_paths(self)
        expect(
            all(tag.strip() for tag in self.tags) and len(set(self.tags)) == len(self.tags),
            f"tags: expected different words, found {', '.join(map(repr, self.tags))}",
        )
        numbers = self.visible_map or (1.0, 1.0, 0.0, 0.0)
        expect(
            all(0 < scale <= GREATEST_SCALE for scale in numbers[:2])
            and all(abs(offset) <= GREATEST_OFFSET_PX for offset in numbers[2:]),  # nan: neither
            f"visible_map: expected two positive scales of at most {GREATEST_SCALE:g} and two "
            f"offsets of at most {GREATEST_OFFSET_PX:.0f} px, found "
            f"[{', '.join(f'{value:g}' for value in numbers)}]",
        )


@dataclass(frozen=True)
class RecordingsFile:
    """A table of the recordings (`nvcore.inputs.session.recordings_file`).

    Attributes
    ----------
    path
        The CSV file.
    line_of
        Line of each recording, by its name; None: the file has not been read.
    """

    path: str
    line_of: Mapping[str, int] | None = None

    def __post_init__(self) -> None:
        expect(bool(self.path), "path: expected a file, found nothing")
        check_path("path", self.path)


@dataclass(frozen=True)
class Source:
    """Paths of ground truth or of a system's detections, and options to read them.

    Attributes
    ----------
    path
        Files, folders or globs. A single one may be a plain text.
    format
        Name of a format. None: detected from the content.
    classes, frame_base, box_base, frame_names
        See `nvcore.inputs.readers.base.ReadOptions`.
    boxes
        Meaning of the four numbers of a box, such as ``corners`` or ``centres-yx-shares``
        (`nvcore.inputs.box_layouts`). None: as in the format.
    """

    path: tuple[str, ...] | str
    format: str | None = None
    classes: tuple[str, ...] | None = None
    frame_base: int | None = None
    box_base: int | None = None
    boxes: str | None = None
    frame_names: str | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "path", as_names(self.path))
        if self.classes is not None:
            object.__setattr__(self, "classes", as_names(self.classes))
        for name in ("frame_base", "box_base"):
            base = getattr(self, name)
            expect(base in (None, 0, 1), f"{name}: expected 0 or 1, found {base}")
        expect(
            self.frame_names in (None, *FRAME_NAMES),
            f"frame_names: expected {', '.join(FRAME_NAMES)}; found {self.frame_names!r}",
        )
        is_there = bool(self.path) and all(self.path)
        expect(is_there, "path: expected a file, folder or glob, found nothing")
        for text in self.path:
            check_path("path", text)
        if self.boxes is not None:
            object.__setattr__(self, "boxes", str(parse_layout(self.boxes)))
        expect(
            self.classes is None or (len(self.classes) > 0 and all(self.classes)),
            "classes: expected names or numbers of classes, found nothing",
        )


@dataclass(frozen=True)
class SystemSource(SystemKeysOfSubjects, Source):
    """A system's detections, threshold and corrections of boxes, with fields of subjects.

    Attributes
    ----------
    name
        The system's name. None: taken from the path.
    threshold
        Score threshold. None: every detection counts.
    frame_step
        Factor of frame numbers, if the system counts at another rate. The product is rounded.
    offset_frames
        Number added to the frame numbers after `frame_step` is applied.
    offset_px
        Numbers added to x and y after scaling.
    scale
        Factor of x and w, and factor of y and h.
    provenance
        File on how the detections were made (`nvcore.dataset.provenance`). None: unknown.
    version_of
        Name of the system, or of any word for a product, of which this is a later version. Systems
        of one name are versions in the session's order.
    """

    name: str | None = None
    threshold: float | None = None
    frame_step: float = 1.0
    offset_frames: int = 0
    offset_px: tuple[float, float] = (0.0, 0.0)
    scale: tuple[float, float] = (1.0, 1.0)
    provenance: str | None = path_field(is_of_run=True)
    version_of: str | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        check_paths(self)
        expect(self.version_of != "", "version_of: expected a name, found nothing")
        try:
            (self.name or "").encode()
        except UnicodeEncodeError as error:
            raise SessionError(f"name: expected UTF-8 text, found {self.name!r}") from error
        expect(not math.isnan(self.threshold or 0), "threshold: expected a number, found nan")
        expect(
            abs(self.offset_frames) <= MAX_OFFSET_FRAMES,
            f"offset_frames: expected at most {MAX_OFFSET_FRAMES}, found {self.offset_frames}",
        )
        check_positive("frame_step", self.frame_step)
        for value in self.offset_px:
            check_finite("offset_px", value)
        for value in self.scale:
            check_positive("scale", value)


@dataclass(frozen=True)
class Session(TablesOfSubjects, Settings):
    """Inputs and settings of a comparison, with fields of subjects.

    Attributes
    ----------
    folder
        Base of relative paths.
    truth, systems
        The inputs.
    recordings
        Facts by recording.
    recordings_file
        Table with more facts. Reading it moves them to `recordings`.
    size, fps, frames
        Facts for all recordings: (width, height) px, frames per second, frame list.
    hashes
        SHA-256 of each source when the session was written, by ``truth`` or the system's name.
        Loading the session checks them.
    pipes
        Paths that were pipes when the session was written, so that their content is lost.
    codes_file
        CSV file of coded intervals (`nvcore.inputs.codes`). Reading it moves them to `codes`, and
        sets it to None.
    rules
        Rules of the gate (`nvcore.report.gate`) that a new version has to pass.
    x, y, params, protocol, only_tags, only, objects, published, accept, codes
        See `nvcore.settings.defaults.Settings`.
    """

    folder: Path
    truth: Source
    systems: tuple[SystemSource, ...]
    recordings: tuple[RecordingEntry, ...] = ()
    recordings_file: RecordingsFile | None = None
    size: tuple[int, int] | None = None
    fps: float | None = None
    frames: str | None = None
    hashes: Mapping[str, str] = field(default_factory=dict)
    pipes: tuple[str, ...] = ()
    codes_file: str | None = None
    rules: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for name in ("only_tags", "only", "accept", "rules"):
            object.__setattr__(self, name, as_names(getattr(self, name)))
        check_rate(self.fps)
        check_path("frames", self.frames)
        check_path("codes", self.codes_file)
        names = [recording.name for recording in self.recordings]
        for name in names:
            message = f"expected one [[recording]] named {name!r}, found several"
            expect(names.count(name) == 1, message)

    def paths(self) -> Iterator[str]:
        """Yield the paths of files still to be read, as they are written."""
        if self.recordings_file is not None and self.has_unread_recordings:
            yield self.recordings_file.path
        if self.codes_file is not None:
            yield self.codes_file
        for source in (self.truth, *self.systems):
            yield from source.path
        for frames in (self.frames, *(recording.frames for recording in self.recordings)):
            if frames is not None and not is_frame_range(frames):
                yield frames
        tables = (getattr(self, name) for name in TABLES_OF_SUBJECTS)
        for part in (*self.recordings, *self.systems, *tables):
            yield from paths_in(part)

    @property
    def of_all(self) -> Session:
        """Return the session with all recordings compared."""
        return replace(self, only_tags=(), only=()) if self.only_tags or self.only else self

    @property
    def as_titled(self) -> Session:
        """Return the session with recordings named by their titles, not as in the data."""
        entries = [
            replace(entry, name=entry.title or entry.name, title=None) for entry in self.recordings
        ]
        return replace(self, recordings=tuple(entries))

    def renamed(
        self,
        systems: Mapping[str, str],
        recordings: Mapping[str, str],
        *,
        of: tuple[Sequence[str], Sequence[str]],
    ) -> Session:
        """Rename systems and recordings (see `Settings.renamed`), in sources and titles, too."""
        own_systems, own_recordings = of
        entries = self.entries(own_recordings)
        for name in own_recordings:
            if recordings.get(name, name) != name:
                entry = entries.get(name, RecordingEntry(name))
                entries[name] = replace(entry, title=recordings[name])
        named = zip(self.systems, new_names(own_systems, systems), strict=False)
        return replace(
            super().renamed(systems, recordings, of=of),
            systems=tuple(
                replace(source, name=name, version_of=systems.get(of, of) if of else None)
                for source, name in named
                for of in [source.version_of]
            ),
            recordings=tuple(entries.values()),
            hashes={systems.get(name, name): text for name, text in self.hashes.items()},
        )

    def choosing_from(self, titles: Collection[str]) -> Session:
        """Return the session with recordings chosen by title, not by their name in the data.

        Parameters
        ----------
        titles
            Titles of all recordings. A name that equals a title means that recording.
        """
        title_of = {entry.name: entry.title for entry in self.recordings if entry.title in titles}

        def called(names: tuple[str, ...]) -> tuple[str, ...]:
            return tuple(
                dict.fromkeys(
                    name if name in titles else title_of.get(name) or name for name in names
                )
            )

        only, counting = called(self.only), called(self.protocol.recordings)
        if (only, counting) == (self.only, self.protocol.recordings):
            return self
        return replace(self, only=only, protocol=replace(self.protocol, recordings=counting))

    @property
    def has_unread_recordings(self) -> bool:
        """Whether the session names a table of recordings that has not been read."""
        return self.recordings_file is not None and self.recordings_file.line_of is None

    @property
    def thresholds(self) -> tuple[float | None, ...]:
        """Score threshold of each system, in order. None: every detection counts."""
        return tuple(system.threshold for system in self.systems)

    @property
    def sources(self) -> tuple[tuple[Source, Role], ...]:
        """Truth and systems, each with its role."""
        return (self.truth, "truth"), *((system, "detections") for system in self.systems)

    def with_paths(self, rename: Callable[[str], str], *, folder: Path) -> Session:
        """Move the session to another folder, renaming each of its paths.

        A table of recordings that was read is no longer named, since `recordings` hold it.
        """
        table = self.recordings_file if self.has_unread_recordings else None

        def of_frames(frames: str | None) -> str | None:
            return frames if frames is None or is_frame_range(frames) else rename(frames)

        return replace(
            self,
            folder=folder,
            truth=replace(self.truth, path=tuple(map(rename, self.truth.path))),
            systems=tuple(
                replace(with_paths_in(system, rename), path=tuple(map(rename, system.path)))
                for system in self.systems
            ),
            recordings=tuple(
                replace(with_paths_in(entry, rename), frames=of_frames(entry.frames))
                for entry in self.recordings
            ),
            recordings_file=None if table is None else RecordingsFile(rename(table.path)),
            frames=of_frames(self.frames),
            codes_file=None if self.codes_file is None else rename(self.codes_file),
            **{name: with_paths_in(getattr(self, name), rename) for name in TABLES_OF_SUBJECTS},
        )

    def entries(self, names: Sequence[str]) -> dict[str, RecordingEntry]:
        """Return `recordings` by name. A single entry applies to the data's only recording.

        Parameters
        ----------
        names
            Titles of the data's recordings, or names of those without a title.
        """
        known = frozenset(names)
        entries = {
            entry.title if entry.title in known and entry.title is not None else entry.name: entry
            for entry in self.recordings
        }
        if not known.issuperset(entries):  # macOS decomposes accents
            as_known = {composed(name): name for name in names}
            entries = {
                name if name in known else as_known.get(composed(name), name): entry
                for name, entry in entries.items()
            }
        is_of_all = not self.only_tags and not self.only
        if len(names) == len(entries) == 1 and names[0] not in entries and is_of_all:
            return {names[0]: replace(self.recordings[0], name=names[0])}
        return entries

    @property
    def common_size(self) -> tuple[int, int] | None:
        """Size of all pictures, if the session gives a single one."""
        if self.size is not None:
            return self.size
        sizes = {(recording.width, recording.height) for recording in self.recordings}
        if len(sizes) != 1:
            return None
        width, height = sizes.pop()
        return None if width is None or height is None else (int(width), int(height))
