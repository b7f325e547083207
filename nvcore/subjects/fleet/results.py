"""Results of a scan: Arrow tables, and measures of all recordings."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Any, Final

import numpy as np
import pandas as pd
import pyarrow as pa

from nvcore.common.errors import ParameterError
from nvcore.comparison.compare import Result
from nvcore.comparison.measures.entry import HOUR_S, is_met
from nvcore.comparison.measures.table import (
    EVIDENCE_KEYS,
    MEASURES,
    counted,
    hides_rate,
    inference_of,
    measure_of,
    words_of,
)
from nvcore.comparison.measures.values import per_recording, ratio_of
from nvcore.comparison.scoring import SystemResult
from nvcore.dataset.schema import MissClass
from nvcore.evidence.units import RECORDINGS, Units, sum_units
from nvcore.settings.objects import PEDESTRIAN
from nvcore.settings.params import Params, params_from
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
"""Tables of every scan. ``frames`` is added on request."""

_TYPES: Final = {
    CellKind.TEXT: pa.string(),
    CellKind.INTEGER: pa.int64(),
    CellKind.NUMBER: pa.float64(),
    CellKind.TRUTH_VALUE: pa.bool_(),
}
_COUNTS: Final = ("detections", "boxes_matched", *(f"miss_{kind.value}" for kind in MissClass))
_TIMES: Final = ("episode_s", "event_s", "event_relevant_s")
_BOXES: Final = ("boxes_both", "boxes_x_only", "boxes_y_only", "boxes_neither")
_SUMMED: Final = {
    key: inference_of(key) for key in EVIDENCE_KEYS if inference_of(key).test == "units"
}
"""Measures whose summands have a column of recordings, ``sum_`` and the key."""
_SPANS: Final = {"events": events_table, "intervals": intervals_table, "episodes": episodes_table}
"""Tables of results that list X before Y, not by recording."""
_COMPARING: Final = "aspect_z"
"""Column of encounters that compares recordings, so that no scan has it."""
_RATIOS: Final = {
    **{
        measure.key: (measure.key.removesuffix("_per_hour"), "duration_s", HOUR_S)
        for measure in MEASURES
        if measure.key.endswith("_per_hour")
    },
    **{f"miss_classes.{kind.value}": (f"miss_{kind.value}", "", 1.0) for kind in MissClass},
    "false_alarms_per_frame": ("false_alarms", "n_frames", 1.0),
    "false_alarms_per_minute": ("false_alarms", "duration_s", 60.0),
    "saliency_relevant_share": ("event_relevant_s", "event_s", 1.0),
    "severity_s_per_min": ("severity_s", "duration_s", 60.0),
    "mean_episode_s": ("episode_s", "false_alert_episodes", 1.0),
    "saliency_largest_event": ("largest_event_s", "", 1.0),
    **{key: (f"sum_{key}", of.per, of.factor) for key, of in _SUMMED.items()},
}
"""Numerator, denominator (empty: 1) and factor of measures. Others have a column of their own."""
_EXTREMES: Final[dict[str, Callable[[list[Any]], float]]] = {
    "min_similarity": min,
    "worst_window_similarity": min,
    "largest_event_s": max,
    "worst_severity_s": max,
    "longest_episode_s": max,
}
"""Columns of each system in the table of recordings that are reduced to their extreme value."""


@dataclass(frozen=True)
class ScanParams:
    """Sources and settings of a scan.

    Attributes
    ----------
    x, y, truth
        Sources of the store: "FIR" (its newest version), "FIR@2", "FIR@name-of-version".
    params
        Settings of the comparison. A threshold of None: the store's, for each recording.
    frames
        Whether results include the table of frames.

    Raises
    ------
    ParameterError
        If two sources are the same, or alerts are to be read from logs, which a store lacks.
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
        """Return sources and settings as JSON values, which `ScanParams.parse` reads."""
        own = {name: getattr(self, name) for name in ("x", "y", "truth", "frames")}
        return own | {"params": self.params.given()}

    @staticmethod
    def parse(given: Mapping[str, Any]) -> ScanParams:
        """Parse what `given` returned, or raise ParameterError for an invalid parameter."""
        return ScanParams(**{**given, "params": params_from(given["params"])})


def _both(names: Iterable[str]) -> list[str]:
    return [f"{name}_{letter}" for letter in "xy" for name in names]


@cache
def schema(table: str) -> pa.Schema:
    """Return the Arrow schema of a results table: recording, then columns of the report's file.

    ``encounters`` also has the frame to look at. ``recordings`` also has tags, the kind of truth,
    and the counts, sums and extremes from which measures of several recordings are computed.
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
        whole = ("n_encounters", *counted(), *_BOXES, *_both(_COUNTS))
        fields |= dict.fromkeys(whole, pa.int64())
        sums = _both([*_TIMES, *_EXTREMES, *(f"sum_{key}" for key in _SUMMED)])
        fields |= dict.fromkeys(("share_of_recording", *sums), pa.float64())
    return pa.schema(fields)


def result_tables(result: Result, truth: Sequence[str], has_frames: bool) -> dict[str, pa.Table]:
    """Convert a comparison of independent recordings (`each_alone`) to tables for `gather`.

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
    made |= {name: make(result) for name, make in _SPANS.items()}
    if has_frames:
        made["frames"] = frames_table(result)
    return {name: typed(table, schema(name)) for name, table in made.items()}


def typed(table: pd.DataFrame, columns: pa.Schema) -> pa.Table:
    """Convert a table to Arrow with these columns, and null for missing cells and columns."""
    known = [
        pa.array(table[of.name], of.type, from_pandas=True)
        if of.name in table
        else pa.nulls(len(table), of.type)
        for of in columns
    ]
    return pa.Table.from_arrays(known, schema=columns)


def _each_recording(result: Result) -> Units:
    """Return units of analysis: one for each recording that has frames."""
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
    """Return counts, sums and extremes by recording, from which overall measures are computed."""
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
    """Concatenate the results of a batch's parts by recording, and add the quarantine.

    Parameters
    ----------
    refused
        Reasons why recordings are not compared, by name.
    """
    reasons = {"recording": sorted(refused), "reason": [refused[name] for name in sorted(refused)]}
    tables = {"quarantine": pa.table(reasons, schema("quarantine"))}
    for name in (*TABLES[:-1], *(["frames"] if has_frames else [])):
        table = pa.concat_tables([part[name] for part in parts] or [schema(name).empty_table()])
        if len(parts) > 1 or name in _SPANS:
            table = table.sort_by("recording")
        tables[name] = table.combine_chunks()
    return tables


@dataclass(frozen=True)
class Summary:
    """Totals and extremes over all recordings, from which measures are computed.

    Attributes
    ----------
    recordings, quarantined
        Number of recordings that were compared, and of others in the quarantine.
    totals
        Values of `reductions`, by column. Columns without values are absent.
    """

    params: ScanParams
    recordings: int
    quarantined: int
    totals: Mapping[str, float]

    @staticmethod
    def of(recordings: pa.Table, quarantined: int, params: ScanParams) -> Summary:
        """Summarize a table of recordings over the columns of `reductions`."""
        totals = {
            name: reduce(values)
            for name, reduce in reductions().items()
            if (values := recordings[name].drop_null().to_pylist())
        }
        return Summary(params, len(recordings), quarantined, totals)

    def total(self, column: str) -> float:
        """Return the total or extreme of a column, or NaN if no recording has a value."""
        return self.totals.get(column, np.nan)

    def measures(self) -> pd.DataFrame:
        """Return one row per measure that totals determine, in the order of `MEASURES`.

        Medians, percentiles and detection curves need all values at once, and are left out.

        Returns
        -------
        key, label, x, y (NaN: undefined), and n: number of encounters or recordings in a mean,
        otherwise of frames.
        """
        columns = {"n_near": "n_encounters", "n_boxes": "n_truth", **{of: of for of in counted()}}
        counts = {name: int(self.totals.get(of, 0)) for name, of in columns.items()}
        words = words_of(self.params.params, counts, RECORDINGS)
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
        """Return a system's value of a measure, or None if totals do not determine it."""
        part, per, factor = _RATIOS.get(key, (key, "", 1.0))
        total = self.total(f"{part}_{letter}")
        if part in _EXTREMES:
            return total
        if np.isnan(total) or hides_rate(measure_of(key), self.total("duration_s")):
            return None
        if not per:
            return total
        over = self.total(f"{per}_{letter}")
        return ratio_of(factor * total, self.total(per) if np.isnan(over) else over)


@cache
def reductions() -> dict[str, Callable[[list[Any]], float]]:
    """Return the function that reduces each column of recordings to one value, by column name.

    Sums are rounded once, so they do not depend on the order of recordings.
    """
    columns = schema("recordings")
    sums = ["duration_s", "share_of_recording", *_both([*_TIMES, "severity_s"])]
    return {
        **{of.name: sum for of in columns if pa.types.is_int64(of.type)},
        **{of.name: math.fsum for of in columns if of.name.startswith("sum_") or of.name in sums},
        **{f"{name}_{letter}": of for name, of in _EXTREMES.items() for letter in "xy"},
    }
