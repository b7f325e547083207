"""Recordings, frames and boxes of one comparison, as tables."""

from __future__ import annotations

import copy
import hashlib
from collections.abc import Callable, Collection, Hashable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, TypeVar

import numpy as np
import pandas as pd

from nvcore.common.errors import InputError
from nvcore.common.findings import Finding
from nvcore.common.wording import MOST_NAMED, did_you_mean, listed
from nvcore.dataset.columns import (
    BOX_COLUMNS,
    BoxColumns,
    Detectability,
    FrameColumns,
    frame_gaps,
    offsets_of,
)
from nvcore.dataset.copies import Copy, find_copies
from nvcore.dataset.provenance import Provenance
from nvcore.dataset.schema import (
    ATTRIBUTE_DTYPES,
    DETECTABILITY_COLUMNS,
    LEFT_OUT_DTYPES,
    TRUTH,
    conform,
)
from nvcore.dataset.sources import ReadAs
from nvcore.settings.defaults import Settings, as_names, is_chosen, new_names
from nvcore.settings.objects import Objects
from nvcore.settings.params import Params
from nvcore.settings.primary import Primary

Kept = TypeVar("Kept")

MOST_TAGS = 12
"""Most tags named in an error. Tags are short and few."""
INPUT_COLUMNS = ("subject", "file", "sha256", "format", "conversion")


@dataclass(frozen=True, eq=False)
class Dataset:
    """Ground truth and systems of one comparison, immutable.

    Attributes
    ----------
    recordings
        One row per recording: name, width, height (px), fps, horizon (px, NaN unknown), context (0
        urban to 1 rural, NaN not stated), speed_kmh (speed of the car in frames without a value in
        a series, NaN not stated), tags (tuple of str), unit (name of the unit that it belongs to;
        empty if it is a unit of its own).
    frames
        One row per listed frame, including frames without boxes: recording (row of `recordings`),
        frame, time_s, step_s, speed_kmh (from a series, NaN none). Sorted by recording, then frame.
    boxes
        Truth and all systems: columns of `nvcore.dataset.schema.DATASET_BOX_DTYPES`, sorted by
        source, frame_index, file order.
    systems
        Names. The boxes of ``systems[i]`` have source ``i + 1``.
    inputs
        One row per input file: subject (truth or system), file, sha256, format, conversion.
    left_out
        Rows that could not be used (frame not listed, recording unknown, coordinates that are no
        box), with subject, recording, frame, file, line, reason and box. No row of the input is
        lost.
    findings
        Findings reported while reading the inputs.
    notes
        Choices made on the user's behalf, in words, such as which frames are evaluated and why.
    fingerprint
        sha256 over the input bytes and the reader settings, or over the tables for data made in
        memory.
    attributes
        Attributes of pedestrians in the truth, for `nvcore.metrics.encounter_classes`; columns of
        `nvcore.dataset.schema.ATTRIBUTE_DTYPES`.
    settings
        Default settings of comparisons, from the session that the data were loaded from.
    provenance
        Provenance of the systems' detections, by system name; systems with unknown provenance are
        absent.
    of_subjects
        Data of subjects from their inputs (`nvcore.inputs.session.added.Input`), by subject name;
        see `of`.
    labels
        Names of the classes that the column `label` of `boxes` numbers, in the words of the objects
        ("70"), if boxes of several classes count.
    read_as
        Interpretation of the files of each source, by ``truth`` or system name; empty for data made
        in memory.
    each_alone
        True if no value of a recording may depend on the others. Values that compare recordings
        (z-scores, children by stature) are then left out, and tables have all possible columns.
    """

    recordings: pd.DataFrame
    frames: pd.DataFrame
    boxes: pd.DataFrame
    systems: tuple[str, ...]
    fingerprint: str
    inputs: pd.DataFrame = field(default_factory=lambda: pd.DataFrame(columns=list(INPUT_COLUMNS)))
    left_out: pd.DataFrame = field(default_factory=lambda: conform({}, LEFT_OUT_DTYPES, n_rows=0))
    findings: tuple[Finding, ...] = ()
    notes: tuple[str, ...] = ()
    attributes: pd.DataFrame = field(
        default_factory=lambda: conform({}, ATTRIBUTE_DTYPES, n_rows=0), repr=False
    )
    settings: Settings = field(default_factory=Settings, repr=False)
    provenance: Mapping[str, Provenance] = field(default_factory=dict, repr=False)
    of_subjects: Mapping[str, Any] = field(default_factory=dict, repr=False)
    labels: tuple[str, ...] = ()
    read_as: Mapping[str, ReadAs] = field(default_factory=dict, repr=False)
    each_alone: bool = False

    @property
    def primary(self) -> Primary:
        """Measure that decides the comparison."""
        return self.settings.primary.of_data(self.fingerprint)

    def of(self, subject: str) -> Any:
        """Return a subject's data from its inputs, or None if there are none."""
        return self.of_subjects.get(subject)

    @cached_property
    def frame_columns(self) -> FrameColumns:
        """Frames and recordings as arrays for the kernels."""
        recording = self.frames["recording"].to_numpy()
        first = np.searchsorted(recording, np.arange(len(self.recordings) + 1))
        frame = self.frames["frame"].to_numpy()
        numbers = {
            name: self.recordings[name].to_numpy()
            for name in ("width", "height", "fps", "horizon", "context")
        }
        gap = frame_gaps(frame, first)
        by_series = self.frames["speed_kmh"].to_numpy()
        of_recording = self.recordings["speed_kmh"].to_numpy()[recording]
        speed_kmh = np.where(np.isnan(by_series), of_recording, by_series)
        return FrameColumns(
            recording, frame, gap, first.astype(np.int64), **numbers, speed_kmh=speed_kmh
        )

    @cached_property
    def copies(self) -> tuple[Copy, ...]:
        """Recordings with the same truth, not searched for if each recording stands alone."""
        return () if self.each_alone else find_copies(self)

    def unlisted_frames(self, recording: str) -> np.ndarray:
        """Return the frames of a recording with truth boxes that are not evaluated, ascending."""
        return self._unlisted.get(recording, np.empty(0, np.int64))

    @cached_property
    def _unlisted(self) -> dict[str, np.ndarray]:
        """`unlisted_frames` of every recording that has any, in one pass over the unused rows."""
        lost = self.left_out[self.left_out["subject"] == "truth"]
        groups = lost.groupby("recording", sort=False)["frame"]
        return {str(name): np.unique(frames.to_numpy(np.int64)) for name, frames in groups}

    @cached_property
    def derived(self) -> dict[Hashable, Any]:
        """Cache of values computed from the data (audit and comparison)."""
        return {}

    def kept(self, key: Hashable, compute: Callable[[Dataset], Kept]) -> Kept:
        """Return a value computed from the data, cached in `derived`."""
        if key not in self.derived:
            self.derived[key] = compute(self)
        kept: Kept = self.derived[key]
        return kept

    @cached_property
    def source_starts(self) -> np.ndarray:
        """First box row of every source, shape (n_systems + 2,)."""
        return np.searchsorted(
            self.boxes["source"].to_numpy(), np.arange(len(self.systems) + 2)
        ).astype(np.int64)

    @property
    def objects(self) -> Objects:
        """Kind of objects that the boxes mark."""
        return self.settings.objects

    @property
    def truth(self) -> BoxColumns:
        """Boxes of the ground truth, including ignored ones."""
        return self.sources[TRUTH]

    @cached_property
    def sources(self) -> tuple[BoxColumns, ...]:
        """Boxes of the ground truth and of every system, in the order of `systems`."""
        # cached because every change of a parameter needs them again
        return tuple(self._source(source) for source in range(len(self.systems) + 1))

    @cached_property
    def detectability(self) -> Detectability:
        """Known detectability of every truth box for the driver, including ignored boxes."""
        n_truth = len(self.truth)
        return Detectability(
            *(self.boxes[name].to_numpy()[:n_truth] for name in DETECTABILITY_COLUMNS)
        )

    @cached_property
    def has_detectability(self) -> bool:
        """Whether the detectability of any pedestrian is known."""
        return bool((~np.isnan(self.detectability.value) & ~self.truth.ignore).any())

    def system(self, name: str) -> BoxColumns:
        """Return the detections of one system, whatever their scores.

        Raises
        ------
        InputError
            If there is no such system.
        """
        if name not in self.systems:
            raise InputError(f"there is no system {name!r}; there are {', '.join(self.systems)}")
        return self.sources[self.systems.index(name) + 1]

    def with_settings(self, settings: Settings) -> Dataset:
        """Return the same data with other settings. Its columns are shared, not copied."""
        assert self.derived is not None  # made now, it is shared too
        other = copy.copy(self)
        object.__setattr__(other, "settings", settings)
        return other

    def only(self, tags: str | Collection[str] = (), names: str | Collection[str] = ()) -> Dataset:
        """Return only the recordings that have all of the tags and one of the names.

        The settings of the result contain the same selection.

        Parameters
        ----------
        tags, names
            One or several; empty for any.

        Raises
        ------
        InputError
            If no recording is left, or there is none of a given name.
        """
        tags, names = as_names(tags), as_names(names)
        every = self.recordings["name"].tolist()
        for name in names:
            if name not in every:
                raise InputError(
                    f"there is no recording {name!r}; "
                    f"{did_you_mean(name, every, f'they are {listed(every, most=MOST_NAMED)}')}"
                )
        recordings = zip(every, self.recordings["tags"], strict=True)
        chosen = np.array([is_chosen(*of, tags, names) for of in recordings], dtype=bool)
        if not chosen.any():
            known = sorted({tag for own in self.recordings["tags"] for tag in own})
            known_text = f"the tags are {listed(known, most=MOST_TAGS)}"
            unknown = next((tag for tag in tags if tag not in known), None)
            if not known:
                known_text = "there are no tags"
            elif unknown is not None:
                known_text = did_you_mean(unknown, known, known_text)
            raise InputError(
                f"no recording has the {'tag' if len(tags) == 1 else 'tags'} {listed([*tags])}"
                f"{' and one of these names' if names else ''}; {known_text}"
            )
        if chosen.all():
            return self
        all_tags = tuple(dict.fromkeys([*self.settings.only_tags, *tags]))
        settings = replace(self.settings, only_tags=all_tags, only=names or self.settings.only)
        return replace(self._of(chosen, tags), settings=settings)

    def _of(self, is_chosen: np.ndarray, tags: Collection[str]) -> Dataset:
        frames, boxes = self.frames, self.boxes
        has_frame = is_chosen[frames["recording"].to_numpy()]
        has_box = has_frame[boxes["frame_index"].to_numpy()]
        new_recording, new_frame = np.cumsum(is_chosen) - 1, np.cumsum(has_frame) - 1
        kept_frames = frames[has_frame].reset_index(drop=True)
        kept_boxes = boxes[has_box].reset_index(drop=True)
        columns = kept_frames["recording"].to_numpy(), kept_boxes["frame_index"].to_numpy()
        names = self.recordings["name"][is_chosen].tolist()
        others = self.recordings["name"][~is_chosen]
        text = "\n".join([self.fingerprint, *names])
        return replace(
            self,
            recordings=self.recordings[is_chosen].reset_index(drop=True),
            frames=kept_frames.assign(recording=new_recording[columns[0]].astype(columns[0].dtype)),
            boxes=kept_boxes.assign(frame_index=new_frame[columns[1]].astype(columns[1].dtype)),
            left_out=self.left_out[~self.left_out["recording"].isin(others)].reset_index(drop=True),
            fingerprint=hashlib.sha256(text.encode()).hexdigest(),
            notes=(*self.notes, part_text(names, self.recordings, tags)),
        )

    def renamed(self, systems: Mapping[str, str], recordings: Mapping[str, str]) -> Dataset:
        """Return the same data with other names of systems and recordings, by the old names.

        Names that are not given stay. The settings use the new names, too.

        Raises
        ------
        InputError
            If two would have the same name, including recordings known only from unused rows.
        """
        own = self.systems, self.recordings["name"].tolist()
        names, titles = new_names(own[0], systems), new_names(own[1], recordings)
        every = dict.fromkeys([*own[1], *self.left_out["recording"].unique()])
        refuse_doubles("systems", names)
        refuse_doubles("recordings", new_names(every, recordings))
        if names == own[0] and titles == tuple(own[1]):
            return self
        subjects = {old: new for old, new in systems.items() if old in self.systems}
        text = "\n".join([self.fingerprint, *names, *titles])
        return replace(
            self,
            settings=self.settings.renamed(systems, recordings, of=own),
            recordings=self.recordings.assign(name=pd.Series(titles, dtype=object).array),
            systems=names,
            inputs=self.inputs.assign(subject=new_names(self.inputs["subject"], subjects)),
            left_out=self.left_out.assign(
                subject=new_names(self.left_out["subject"], subjects),
                recording=new_names(self.left_out["recording"], recordings),
            ),
            findings=tuple(
                replace(finding, subject=subjects.get(finding.subject, finding.subject))
                for finding in self.findings
            ),
            provenance={
                subjects.get(name, name): record.renamed(recordings)
                for name, record in self.provenance.items()
            },
            read_as={subjects.get(name, name): how for name, how in self.read_as.items()},
            fingerprint=hashlib.sha256(text.encode()).hexdigest(),
        )

    def compared(self, x: str | None = None, y: str | None = None) -> tuple[str | None, str | None]:
        """Return the names of X and Y: the given ones, those of the settings, or the first others.

        None if no system is left.
        """
        x, y = self.settings.names(x, y)
        x = x or next((name for name in self.systems if name != y), None)
        return x, y or next((name for name in self.systems if name != x), None)

    def params_of(self, x: str | None = None, y: str | None = None) -> Params:
        """Return the settings' parameters with the thresholds of these systems filled in.

        Parameters
        ----------
        x, y
            See `compared`.
        """
        threshold_of = dict(zip(self.systems, self.settings.thresholds, strict=False))
        name_x, name_y = self.compared(x, y)
        params = self.settings.params
        given_x, given_y = params.threshold_x, params.threshold_y
        return replace(
            params,
            threshold_x=threshold_of.get(name_x or "") if given_x is None else given_x,
            threshold_y=threshold_of.get(name_y or "") if given_y is None else given_y,
        )

    def _source(self, source: int) -> BoxColumns:
        start, stop = self.source_starts[source : source + 2]
        columns = {name: self.boxes[name].to_numpy()[start:stop] for name in BOX_COLUMNS}
        offsets = offsets_of(columns["frame_index"], len(self.frames))
        return BoxColumns(**columns, offsets=offsets, first_row=int(start))


def part_text(names: Sequence[str], every: pd.DataFrame, tags: Collection[str]) -> str:
    """Describe the selected recordings, such as ``3 of 8 recordings: night``.

    Parameters
    ----------
    every
        `Dataset.recordings` before the selection.
    tags
        Tags used for the selection. If other recordings have them, too, the names are added.
    """
    named = ", ".join(names[:MOST_NAMED])
    if len(names) > MOST_NAMED:
        named += f" and {len(names) - MOST_NAMED} more"
    n_tagged = sum(set(tags) <= set(own) for own in every["tags"])
    which = ", ".join(tags)
    if not tags:
        which = named
    elif n_tagged > len(names):
        which = f"{which}, of these {named}"
    return f"{len(names)} of {len(every)} recordings: {which}"


def refuse_doubles(what: str, names: Sequence[str]) -> None:
    """Raise InputError if two of these names are the same."""
    double = next((name for name in names if names.count(name) > 1), None)
    if double is not None:
        raise InputError(f"two {what} would be called {double!r}; expected different names")
