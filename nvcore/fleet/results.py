"""Results of a scan: tables as Arrow, and the summary that batches are merged into."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cache
from typing import Any, Final

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.compute as pc

from nvcore.comparison import Result
from nvcore.errors import InputError, ParameterError
from nvcore.evidence.units import RECORDINGS, Units, sum_units
from nvcore.measures.entry import HOUR_S, is_met
from nvcore.measures.table import (
    EVIDENCE_KEYS,
    MEASURES,
    counted,
    hides_rate,
    inference_of,
    measure_of,
)
from nvcore.measures.values import per_recording, ratio_of
from nvcore.metrics.venn import BoxVenn, Venn
from nvcore.objects import PEDESTRIAN
from nvcore.params import Params, params_from
from nvcore.schema import Category, MissClass
from nvcore.scoring import SystemResult
from nvcore.tables.column import CellKind
from nvcore.tables.columns import report_columns
from nvcore.tables.moments import encounter_moments
from nvcore.tables.result import (
    encounters_table,
    episodes_table,
    events_table,
    frames_table,
    intervals_table,
    recordings_table,
)

TABLES: Final = ("recordings", "encounters", "events", "intervals", "episodes", "quarantine")
"""Results of every scan; ``frames`` comes with them if it is asked for."""

_TYPES: Final = {
    CellKind.TEXT: pa.string(),
    CellKind.INTEGER: pa.int64(),
    CellKind.NUMBER: pa.float64(),
    CellKind.TRUTH_VALUE: pa.bool_(),
}
_WHOLE: Final = {
    "detections": "detections",
    "boxes_matched": "boxes_matched",
    **{f"miss_classes.{kind.value}": f"miss_{kind.value}" for kind in MissClass},
}
"""Measures that are counts, and the columns that have them by recording."""
_TIMES: Final = (
    *("episode_s", "longest_episode_s", "event_s", "event_relevant_s", "largest_event_s"),
    "worst_severity_s",
)
_BOXES: Final = ("boxes_both", "boxes_x_only", "boxes_y_only", "boxes_neither")
_SUMMED: Final = tuple(key for key in EVIDENCE_KEYS if inference_of(key).test == "units")
"""Measures that are a factor times a sum over another one; sums have ``sum_`` before the key."""

_SPANS: Final = {
    "events": events_table,
    "intervals": intervals_table,
    "episodes": episodes_table,
}
_COMPARING: Final = "aspect_z"
"""Column of encounters that compares recordings, and so is in no result of a scan."""
_RATIOS: Final = {
    "false_alarms_per_frame": ("false_alarms", "n_frames", 1.0),
    "false_alarms_per_minute": ("false_alarms", "duration_s", 60.0),
    "saliency_relevant_share": ("event_relevant_s", "event_s", 1.0),
    "severity_s_per_min": ("severity_s", "duration_s", 60.0),
    "mean_episode_s": ("episode_s", "false_alert_episodes", 1.0),
}
"""Other measures that are one: numerator, denominator, factor; those of alerts follow their names.
"""
_EXTREMES: Final = {
    "min_similarity": ("min_similarity", min),
    "worst_window_similarity": ("worst_window_similarity", min),
    "saliency_largest_event": ("largest_event_s", max),
    "worst_severity_s": ("worst_severity_s", max),
    "longest_episode_s": ("longest_episode_s", max),
}
"""Measures that are the least or the largest of a column of recordings."""


@dataclass(frozen=True)
class ScanParams:
    """What is compared over a fleet, and how.

    Attributes
    ----------
    x, y, truth
        Sources of the store: "FIR" (its newest version), "FIR@2", "FIR@name-of-version".
    params
        Settings of the comparison. A threshold that is None is the one that the store has for the
        system in each recording.
    frames
        Whether results have the table of frames.

    Raises
    ------
    ParameterError
        If two sources are the same, or alerts are to be those of logs, which a store does not hold.
    """

    x: str
    y: str
    truth: str = "truth"
    params: Params = field(default_factory=Params)
    frames: bool = False

    def __post_init__(self) -> None:
        if len({*self.sources}) < 3:
            raise ParameterError(
                f"expected three different sources, got {', '.join(self.sources)}; name two "
                "systems, or two versions of one"
            )
        if self.params.alerts == "log":
            raise ParameterError(
                "alerts: a store holds no alert logs, so a scan cannot use them; scan with alerts "
                "policy, or compare a session with nvcore compare"
            )

    @property
    def sources(self) -> tuple[str, str, str]:
        """Truth, X and Y."""
        return self.truth, self.x, self.y

    def given(self) -> dict[str, Any]:
        """For JSON; `ScanParams.parse` reads it."""
        own = {name: getattr(self, name) for name in ("x", "y", "truth", "frames")}
        return own | {"params": self.params.given()}

    @staticmethod
    def parse(given: Mapping[str, Any]) -> ScanParams:
        """From what `given` returned.

        Raises
        ------
        ParameterError
            If a parameter is unknown or impossible.
        """
        return ScanParams(**{**given, "params": params_from(given["params"])})


def _both(names: Iterable[str]) -> list[str]:
    return [f"{name}_{letter}" for letter in "xy" for name in names]


@cache
def schema(table: str) -> pa.Schema:
    """Return the columns of a table of results: those of the report's file, recording first.

    ``encounters`` also has the frame to look at, and its time, but no column that compares
    recordings. ``recordings`` also has the tags, the kind of the truth, and the counts, sums
    (``sum_`` and the key of the measure) and extremes that measures of several are computed from.
    """
    if table == "quarantine":
        fields = {"recording": pa.string(), "reason": pa.string()}
    elif table == "episodes":
        fields = {field.name: field.type for field in schema("intervals")}
        for name in ("depth_s", "min_similarity", "worst_frame"):
            del fields[name]
        fields["n_boxes"] = pa.int64()
    else:
        fields = {"recording": pa.string()}
        fields |= {of.name: _TYPES[of.kind] for of in report_columns()[f"{table}.csv"]}
    if table == "encounters":
        del fields[_COMPARING]
        fields |= {"shown_frame": pa.int64(), "shown_s": pa.float64()}
    if table == "recordings":
        fields |= {"tags": pa.list_(pa.string()), "truth": pa.string()}
        whole = ("n_encounters", *counted(), *_BOXES, *_both(_WHOLE.values()))
        fields |= dict.fromkeys(whole, pa.int64())
        sums = _both([*_TIMES, *(f"sum_{key}" for key in _SUMMED)])
        fields |= dict.fromkeys(("share_of_recording", *sums), pa.float64())
    return pa.schema(fields)


def result_tables(result: Result, truth: Sequence[str], has_frames: bool) -> dict[str, pa.Table]:
    """Make the result tables of a comparison of recordings that are each alone, by recording.

    Parameters
    ----------
    truth
        Kind of the truth of each recording.
    has_frames
        Whether to make the table of frames.
    """
    facts = {"tags": result.dataset.recordings["tags"], "truth": [*truth], **_sums(result)}
    shown = result.dataset.frames.iloc[encounter_moments(result)["shown_row"]]
    made = {
        "recordings": pd.concat([recordings_table(result), pd.DataFrame(facts)], axis=1),
        "encounters": encounters_table(result).assign(
            shown_frame=shown["frame"].to_numpy(), shown_s=shown["time_s"].to_numpy()
        ),
    }
    for name, make in _SPANS.items():
        of_both = [getattr(system, name)["recording"] for _, system in result.sides]
        made[name] = make(result).iloc[np.argsort(np.concatenate(of_both), kind="stable")]
    if has_frames:
        made["frames"] = frames_table(result)
    return {name: typed(table, schema(name)) for name, table in made.items()}


def typed(table: pd.DataFrame, columns: pa.Schema) -> pa.Table:
    """A table as Arrow with these columns; what is missing, cells or columns, is null."""
    known = [
        pa.array(table[of.name], of.type, from_pandas=True)
        if of.name in table
        else pa.nulls(len(table), of.type)
        for of in columns
    ]
    return pa.Table.from_arrays(known, schema=columns)


def _each_recording(result: Result) -> Units:
    """Take each recording as a unit; those without frames are in none."""
    frames = result.dataset.frame_columns
    number, has_frames = np.arange(len(frames.fps)), np.diff(frames.first) > 0
    n_with_frames = int(np.count_nonzero(has_frames))
    return Units(
        kind=RECORDINGS,
        unit_of_frame=frames.recording.astype(np.int64),
        recording=number,
        n_recordings=n_with_frames,
        n_independent=n_with_frames,
        block_s=np.nan,
        of_recording=np.where(has_frames, number, -1),
    )


def _sums(result: Result) -> dict[str, np.ndarray]:
    """What measures over several recordings are made of, of each recording."""
    frames, n = result.dataset.frame_columns, len(result.dataset.recordings)
    sums = sum_units(result, _each_recording(result))
    columns = {name: sums[name].to_numpy() for name in ("n_encounters", *counted())}
    columns["share_of_recording"] = sums["share_of_recording"].to_numpy()
    columns |= {
        f"sum_{key}_{letter}": sums[f"{key}_{letter}"].to_numpy()
        for key in _SUMMED
        for letter in "xy"
        if is_met(measure_of(key).only_if, result)
    }
    truth = result.dataset.truth
    code = 4 * frames.recording[truth.frame_index].astype(np.int64)  # in the order of _BOXES
    code += 2 * ~result.x.matches.is_matched + ~result.y.matches.is_matched
    counts = np.bincount(code[~truth.ignore], minlength=4 * n).reshape(n, 4)
    columns |= dict(zip(_BOXES, counts.T, strict=True))
    for letter, system in result.sides:
        of_system = _sums_of_system(result, system)
        columns |= {f"{name}_{letter}": values for name, values in of_system.items()}
    return columns


def _sums_of_system(result: Result, system: SystemResult) -> dict[str, np.ndarray]:
    frames, recording = result.dataset.frame_columns, result.encounters.recording
    is_near = result.is_near
    n_frames, n_near = np.diff(frames.first), per_recording(result, is_near, recording)
    events, episodes = system.events, system.episodes
    of_event, of_episode = events["recording"].to_numpy(), episodes["recording"].to_numpy()
    kind, severity_s = system.encounters["miss_class"].to_numpy(), system.failures["severity_s"]
    largest_s, longest_s, worst_s = np.full((3, len(n_frames)), np.nan)
    largest_s[n_frames > 0] = worst_s[n_near > 0] = 0.0
    np.fmax.at(largest_s, of_event, events["saliency_s"].to_numpy(float))
    np.fmax.at(longest_s, of_episode, episodes["duration_s"].to_numpy(float))
    np.fmax.at(worst_s, recording[is_near], severity_s.to_numpy()[is_near])
    return {
        "detections": per_recording(result, system.n_det, frames.recording),
        "boxes_matched": per_recording(result, system.matched, frames.recording),
        **{
            f"miss_{of.value}": per_recording(result, (kind == of.value) & is_near, recording)
            for of in MissClass
        },
        "episode_s": per_recording(result, episodes["duration_s"].to_numpy(), of_episode),
        "longest_episode_s": longest_s,
        "event_s": per_recording(result, events["duration_s"].to_numpy(), of_event),
        "event_relevant_s": per_recording(result, events["relevant_s"].to_numpy(), of_event),
        "largest_event_s": largest_s,
        "worst_severity_s": worst_s,
    }


def gather(
    parts: Sequence[Mapping[str, pa.Table]], refused: Mapping[str, str], *, has_frames: bool
) -> dict[str, pa.Table]:
    """The result tables of all parts of a batch as one of each, by recording.

    Parameters
    ----------
    refused
        Why recordings are not compared, by name.
    """
    reasons = {"recording": sorted(refused), "reason": [refused[name] for name in sorted(refused)]}
    tables = {"quarantine": pa.table(reasons, schema("quarantine"))}
    for name in (*TABLES[:-1], *(["frames"] if has_frames else [])):
        table = pa.concat_tables([part[name] for part in parts] or [schema(name).empty_table()])
        if len(parts) > 1:
            names = pc.sort_indices(pc.unique(table["recording"]))
            ordered = pc.unique(table["recording"]).take(names)
            place = pc.index_in(table["recording"], ordered).to_numpy()
            table = table.take(np.argsort(place, kind="stable"))
        tables[name] = table.combine_chunks()
    return tables


@dataclass(frozen=True)
class Summary:
    """Measures over recordings, in a form that can be merged.

    Sums are kept exactly, as fractions, so that the order of merging changes no digit.

    Attributes
    ----------
    params
        What was compared.
    recordings, quarantined
        Recordings compared, and those that could not be.
    counts, sums
        Of columns of the table of recordings, by name; one that no recording has is absent.
    extremes
        Least or largest value of a measure and system (``min_similarity_x``), and the recording
        that has it, of several the first by name.
    """

    params: ScanParams
    recordings: int
    quarantined: int
    counts: Mapping[str, int]
    sums: Mapping[str, Fraction]
    extremes: Mapping[str, tuple[float, str]]

    @staticmethod
    def of(tables: Mapping[str, pa.Table], params: ScanParams) -> Summary:
        """Of the result tables of `nvcore.fleet.batch.scan_batch`."""
        recordings = tables["recordings"]
        known = {name: recordings[name].drop_null() for name in recordings.column_names}
        counts, sums = ([name for name in names if len(known[name])] for names in _summed())
        names, extremes = recordings["recording"].to_pylist(), {}
        for key, (column, worst) in _EXTREMES.items():
            for letter in "xy":
                values = zip(recordings[f"{column}_{letter}"].to_pylist(), names, strict=True)
                having = [of for of in values if of[0] is not None]
                if having:
                    extremes[f"{key}_{letter}"] = _worst(having, worst)
        return Summary(
            params,
            len(recordings),
            len(tables["quarantine"]),
            {name: sum(known[name].to_pylist()) for name in counts},
            {name: exact_sum(known[name].to_numpy()) for name in sums},
            extremes,
        )

    @staticmethod
    def merge(parts: Sequence[Summary]) -> Summary:
        """The summary of all of their recordings: the same bytes in whatever order and nesting.

        Raises
        ------
        InputError
            If there is none, or they are of different comparisons.
        """
        if not parts:
            raise InputError("there is no summary to merge; scan a recording at least")
        if any(part.params != parts[0].params for part in parts):
            raise InputError("summaries of different comparisons cannot be merged")
        counts: dict[str, int] = {}
        sums: dict[str, Fraction] = {}
        for part in parts:
            for name, value in part.counts.items():
                counts[name] = counts.get(name, 0) + value
            for name, amount in part.sums.items():
                sums[name] = sums.get(name, Fraction()) + amount
        extremes = {}
        for name in {name for part in parts for name in part.extremes}:
            known = [part.extremes[name] for part in parts if name in part.extremes]
            extremes[name] = _worst(known, _EXTREMES[name[:-2]][1])
        return Summary(
            parts[0].params,
            sum(part.recordings for part in parts),
            sum(part.quarantined for part in parts),
            counts,
            sums,
            extremes,
        )

    def total(self, column: str) -> float:
        """Sum of a column of the table of recordings; NaN if no recording has it."""
        return float(self.sums.get(column, self.counts.get(column, np.nan)))

    @property
    def venn(self) -> Venn:
        """Encounters by who detects them."""
        return Venn(*(self.counts.get(kind.value, 0) for kind in Category))

    @property
    def boxes(self) -> BoxVenn:
        """Boxes of the truth by who matches them."""
        return BoxVenn(*(self.counts.get(name, 0) for name in _BOXES))

    def measures(self) -> pd.DataFrame:
        """One row per measure that recordings add up to, in the order of `MEASURES`.

        Medians, percentiles and detection curves need all values at once, and are not there.

        Returns
        -------
        key, label, x, y (NaN: undefined), and n: how many encounters or recordings it is a mean
        of, else the frames behind it.
        """
        settings = self.params.params
        is_largest = settings.saliency_aggregate == "max"
        words: dict[str, Any] = {
            "low": settings.low,
            "window": settings.window,
            "aggregate": "largest event" if is_largest else "sum of events",
            "n_near": self.counts.get("n_encounters", 0),
            "n_boxes": self.counts.get("n_truth", 0),
            "units": RECORDINGS,
            **{name: self.counts.get(name, 0) for name in counted()},
        }
        rows = []
        for measure in MEASURES:
            values = [self._value(measure.key, letter) for letter in "xy"]
            if None not in values:
                per = measure.inference.per if measure.inference is not None else ""
                n = self.total("n_frames" if per in ("", "duration_s") else per)
                label = PEDESTRIAN.say(measure.label, **words)
                rows.append((measure.key, label, *values, 0 if np.isnan(n) else int(n)))
        return pd.DataFrame(rows, columns=["key", "label", "x", "y", "n"])

    def _value(self, key: str, letter: str) -> float | None:
        """A measure of a system; None: no sum makes it, or no recording has it."""
        if key in _EXTREMES:
            return self.extremes.get(f"{key}_{letter}", (np.nan, ""))[0]
        if hides_rate(measure_of(key), self.total("duration_s")):
            return None
        part, per, factor = _WHOLE.get(key, key), "", 1.0
        if key in _SUMMED:
            part, per, factor = f"sum_{key}", inference_of(key).per, inference_of(key).factor
        elif key in _RATIOS:
            part, per, factor = _RATIOS[key]
        elif key.endswith("_per_hour"):
            part, per, factor = key.removesuffix("_per_hour"), "duration_s", HOUR_S
        total = self.total(f"{part}_{letter}")
        if np.isnan(total) or not per:
            return None if np.isnan(total) else total
        over = self.total(f"{per}_{letter}" if f"{per}_{letter}" in self._columns else per)
        return ratio_of(factor * total, over)

    @property
    def _columns(self) -> set[str]:
        return {*self.counts, *self.sums}

    def given(self) -> dict[str, Any]:
        """For JSON, the same for the same summary; `Summary.parse` reads it."""
        return {
            "params": self.params.given(),
            "recordings": self.recordings,
            "quarantined": self.quarantined,
            "counts": dict(self.counts),
            "sums": {name: str(value) for name, value in self.sums.items()},
            "extremes": {name: list(of) for name, of in self.extremes.items()},
        }

    @staticmethod
    def parse(given: Mapping[str, Any]) -> Summary:
        """From what `given` returned."""
        return Summary(
            ScanParams.parse(given["params"]),
            given["recordings"],
            given["quarantined"],
            given["counts"],
            {name: Fraction(value) for name, value in given["sums"].items()},
            {name: (float(value), of) for name, (value, of) in given["extremes"].items()},
        )


@cache
def _summed() -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Columns of the table of recordings that are counts, and others that can be added up."""
    columns = schema("recordings")
    counts = tuple(of.name for of in columns if pa.types.is_int64(of.type))
    times = _both(["severity_s", "episode_s", "event_s", "event_relevant_s"])
    sums = ("duration_s", "share_of_recording", *times)
    return counts, (*sums, *(of.name for of in columns if of.name.startswith("sum_")))


def _worst(
    known: Iterable[tuple[float, str]], worst: Callable[[Iterable[float]], float]
) -> tuple[float, str]:
    """The least or largest value (`worst`) and whose it is, of several the first by name."""
    values = [*known]
    value = worst(of[0] for of in values)
    return value, min(name for own, name in values if own == value)


def exact_sum(values: np.ndarray) -> Fraction:
    """Sum of finite numbers without any rounding; float64, shape (n,)."""
    ratios = [value.as_integer_ratio() for value in values.tolist()]
    over = max((of[1] for of in ratios), default=1)  # all are powers of two
    return Fraction(sum(value * (over // of) for value, of in ratios), over)
