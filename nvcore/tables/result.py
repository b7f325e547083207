"""Tables for people from a `Result`: what the CSV files hold and the web shows."""

from __future__ import annotations

from collections import Counter
from dataclasses import asdict
from itertools import pairwise
from typing import Any

import numpy as np
import pandas as pd

from nvcore import __version__
from nvcore.comparison import Result, SystemResult
from nvcore.findings import Finding
from nvcore.metrics.saliency import aggregate_saliency
from nvcore.metrics.similarity import summarise_similarity
from nvcore.schema import NO_TRACK, Category, MissClass
from nvcore.tables.columns import column_names


def _names(result: Result, recording: np.ndarray) -> np.ndarray:
    """Names of recordings given by row."""
    names: np.ndarray = result.dataset.recordings["name"].to_numpy(dtype=object)[recording]
    return names


def _integers(values: np.ndarray, is_known: np.ndarray) -> Any:
    """Whole numbers, missing where not known."""
    # not by way of floats, which do not hold ids such as timestamps
    return pd.arrays.IntegerArray(values.astype(np.int64), ~is_known)


def _booleans(values: np.ndarray, is_known: np.ndarray) -> Any:
    """Truth values, missing where not known."""
    return pd.arrays.BooleanArray(values.astype(bool), ~is_known)


def frames_table(result: Result) -> pd.DataFrame:
    """One row per listed frame: counts, distances (px), similarity of both systems."""
    frames = result.dataset.frames
    columns: dict[str, Any] = {
        "recording": _names(result, frames["recording"].to_numpy()),
        "frame": frames["frame"],
        "time_s": frames["time_s"],
        "n_truth": result.n_truth,
    }
    for letter, system in result.sides:
        row = system.salient_row
        is_known = row >= 0
        track = np.full(len(row), NO_TRACK)
        track[is_known] = result.tracks.track[row[is_known]]
        columns |= {
            f"n_det_{letter}": system.n_det,
            f"matched_{letter}": system.matched,
            f"false_alarms_{letter}": system.false_alarms,
            f"d_miss_{letter}": system.distances.d_miss,
            f"d_false_{letter}": system.distances.d_false,
            f"similarity_{letter}": system.similarity,
            f"similarity_window_{letter}": system.similarity_window,
            f"salient_track_{letter}": _integers(track, is_known),
        }
    return pd.DataFrame(columns)


def encounters_table(result: Result) -> pd.DataFrame:
    """One row per encounter: category, how each system did, the encounter's own figures."""
    encounters, frame = result.encounters, result.dataset.frames["frame"].to_numpy()
    is_near = result.category != Category.DISTANT.value
    columns: dict[str, Any] = {
        "recording": _names(result, encounters.recording),
        "track": encounters.track,
        "first_frame": frame[encounters.first_row],
        "last_frame": frame[encounters.last_row],
        "n_relevant": result.x.encounters["n_relevant"],
        "category": result.category,
    }
    for letter, system in result.sides:
        judged = system.encounters
        columns |= {
            f"matched_{letter}": judged["matched"],
            f"coverage_{letter}": judged["coverage"],
            f"detected_{letter}": _booleans(judged["is_detected"].to_numpy(), is_near),
            f"miss_class_{letter}": judged["miss_class"],
            f"lag_s_{letter}": judged["lag_s"],
            f"gap_s_{letter}": judged["gap_s"],
            f"tail_s_{letter}": judged["tail_s"],
        }
    columns |= {
        "lead_time_s": result.lead_time_s,
        "n_frames": encounters.n_frames,
        "lateral_offset": encounters.lateral_offset,
        "lateral_position": encounters.lateral_position,
        "peak_height": encounters.peak_height,
        "peak_k": result.x.encounters["peak_k"],
        "aspect_ratio": encounters.aspect_ratio,
        "aspect_z": encounters.aspect_z,
        "occluded_share": encounters.occluded_share,
    }
    return pd.DataFrame(columns)


def _spans(result: Result, spans: pd.DataFrame, letter: str) -> dict[str, Any]:
    """The columns that events, intervals and episodes share."""
    frames = result.dataset.frames
    first, last = spans["first_row"].to_numpy(), spans["last_row"].to_numpy()
    return {
        "system": np.full(len(spans), letter, dtype=object),
        "recording": _names(result, spans["recording"].to_numpy()),
        "first_frame": frames["frame"].to_numpy()[first],
        "last_frame": frames["frame"].to_numpy()[last],
        "start_s": frames["time_s"].to_numpy()[first],
        "duration_s": spans["duration_s"].to_numpy(),
    }


def events_table(result: Result) -> pd.DataFrame:
    """One row per saliency event of either system."""
    return located_events(result)[column_names("events.csv")]


def located_events(result: Result) -> pd.DataFrame:
    """`events_table`, with where to find each event in the other tables.

    Returns
    -------
    The columns of `events_table`, and recording_row (row of the recordings table), first_row and
    last_row (rows of the frames table).
    """
    tables = []
    for letter, system in result.sides:
        spans = _spans(result, system.events, letter)
        spans |= {name: system.events[name] for name in ("track", "tau", "recency")}
        spans["saliency_s"] = system.events["saliency_s"]
        spans |= {name: system.events[name] for name in ("first_row", "last_row")}
        spans["recording_row"] = system.events["recording"]
        tables.append(pd.DataFrame(spans))
    return pd.concat(tables, ignore_index=True)


def worst_events(result: Result, letter: str, *, n: int = 5) -> pd.DataFrame:
    """The `n` events of one system with the largest saliency, worst first, as `located_events`."""
    table = located_events(result)
    table = table[table["system"] == letter]
    return table.sort_values("saliency_s", ascending=False, kind="stable").head(n)


def intervals_table(result: Result) -> pd.DataFrame:
    """One row per low-similarity interval of either system."""
    frame = result.dataset.frames["frame"].to_numpy()
    tables = []
    for letter, system in result.sides:
        spans = _spans(result, system.intervals, letter)
        spans |= {
            "severity_s": system.intervals["severity_s"].to_numpy(),
            "min_similarity": system.intervals["min_similarity"].to_numpy(),
            "worst_frame": frame[system.intervals["worst_row"].to_numpy()],
        }
        tables.append(pd.DataFrame(spans))
    return pd.concat(tables, ignore_index=True)


def worst_intervals(result: Result, letter: str, *, n: int = 5) -> pd.DataFrame:
    """The `n` low-similarity intervals of one system with the largest severity, worst first."""
    table = intervals_table(result)
    table = table[table["system"] == letter]
    return table.sort_values("severity_s", ascending=False, kind="stable").head(n)


def recordings_table(result: Result) -> pd.DataFrame:
    """One row per recording: its size, Venn counts, and the aggregates of both systems."""
    dataset, frames = result.dataset, result.dataset.frame_columns
    duration_s = _per_recording(result, frames.gap, frames.recording) / frames.fps
    columns: dict[str, Any] = {
        "recording": dataset.recordings["name"],
        "width": dataset.recordings["width"],
        "height": dataset.recordings["height"],
        "fps": dataset.recordings["fps"],
        "n_frames": np.diff(frames.first),
        "duration_s": duration_s,
        "n_truth": _per_recording(result, result.n_truth, frames.recording).astype(np.int64),
    }
    for category in Category:
        is_it = result.category == category.value
        columns[category.value] = _per_recording(result, is_it, result.encounters.recording).astype(
            np.int64
        )
    for letter, system in result.sides:
        columns |= _system_by_recording(result, letter, system, duration_s)
    return pd.DataFrame(columns)


def _per_recording(result: Result, values: np.ndarray, recording: np.ndarray) -> np.ndarray:
    """Sum of `values` over each recording."""
    return np.bincount(recording, weights=values, minlength=len(result.dataset.recordings))


def _system_by_recording(
    result: Result, letter: str, system: SystemResult, duration_s: np.ndarray
) -> dict[str, Any]:
    first = result.dataset.frame_columns.first
    # a loop over recordings: percentiles need each recording's own sorted frames
    summaries = [
        summarise_similarity(system.similarity[a:b], low=result.params.low)
        for a, b in pairwise(first)
    ]
    event_s = system.events["saliency_s"].to_numpy()
    first_event = np.searchsorted(system.events["recording"], np.arange(len(summaries) + 1))
    saliency = [
        aggregate_saliency(event_s[a:b], aggregate=result.params.saliency_aggregate)
        for a, b in pairwise(first_event)
    ]
    alarms = _per_recording(
        result, system.false_alarms, result.dataset.frame_columns.recording
    ).astype(np.int64)
    episodes = _per_recording(
        result, np.ones(len(system.episodes)), system.episodes["recording"].to_numpy()
    ).astype(np.int64)
    detected = _per_recording(
        result, system.encounters["is_detected"].to_numpy(), result.encounters.recording
    ).astype(np.int64)
    with np.errstate(invalid="ignore"):  # a recording without frames has no rates
        alarms_per_minute, episodes_per_hour = (
            alarms / duration_s * 60,
            episodes / duration_s * 3600,
        )
    return {
        f"mean_similarity_{letter}": [one.mean for one in summaries],
        f"min_similarity_{letter}": [one.minimum for one in summaries],
        f"percentile_5_similarity_{letter}": [one.percentile_5 for one in summaries],
        f"share_low_{letter}": [one.share_low for one in summaries],
        f"saliency_{letter}": saliency,
        f"encounters_detected_{letter}": detected,
        f"false_alarms_{letter}": alarms,
        f"false_alarms_per_minute_{letter}": alarms_per_minute,
        f"false_alert_episodes_{letter}": episodes,
        f"false_alert_episodes_per_hour_{letter}": episodes_per_hour,
    }


def findings_table(findings: tuple[Finding, ...]) -> pd.DataFrame:
    """One row per finding of the audit, as given."""
    names = column_names("findings.csv")
    rows = [{name: str(getattr(one, name)) for name in names} for one in findings]
    return pd.DataFrame(rows, columns=names).astype({"count": "int64"})


def summary(result: Result) -> dict[str, Any]:
    """All aggregates, ready for JSON; None is undefined."""
    lead = result.lead_time_s
    lead = lead[np.isfinite(lead)]
    either, both = result.fusion.x, result.fusion.y
    content = {
        "version": __version__,
        "fingerprint": result.dataset.fingerprint,
        "parameters": asdict(result.params),
        "recordings": len(result.dataset.recordings),
        "frames": len(result.dataset.frames),
        "duration_s": result.duration_s,
        "truth": {
            "boxes": int(result.n_truth.sum()),
            "boxes_ignored": int(np.count_nonzero(result.dataset.truth.ignore)),
            "encounters": len(result.encounters),
            "recordings_with_linked_tracks": len(result.tracks.linked_recordings),
            "boxes_without_distance": result.k_truth.n_without_distance,
        },
        "x": system_summary(result, result.x),
        "y": system_summary(result, result.y),
        "venn": result.venn.counts(),
        "dominant": result.venn.dominant,
        "exclusivity": asdict(result.exclusivity),
        "boxes": asdict(result.boxes),
        "lead_time_s": {
            "encounters": len(lead),
            "mean": float(lead.mean()) if len(lead) else None,
            "median": float(np.median(lead)) if len(lead) else None,
        },
        "fusion": {
            "x_or_y": system_summary(result.fusion, either),
            "x_and_y": system_summary(result.fusion, both),
        },
    }
    defined: dict[str, Any] = _without_nan(content)
    return defined


def system_summary(result: Result, system: SystemResult) -> dict[str, Any]:
    """Aggregates of one system over all recordings."""
    alarms = system.false_alarm_summary
    is_near = result.category != Category.DISTANT.value
    classes = Counter(system.encounters["miss_class"][is_near])
    return {
        "name": system.name,
        "threshold": system.threshold,
        "detections": int(system.n_det.sum()),
        "detections_without_distance": system.weights.n_without_distance,
        "mean_similarity": system.summary.mean,
        "min_similarity": system.summary.minimum,
        "percentile_5_similarity": system.summary.percentile_5,
        "share_low": system.summary.share_low,
        "saliency": system.saliency_s,
        "encounters_detected": int(system.encounters["is_detected"].sum()),
        "miss_classes": {kind.value: classes.get(kind.value, 0) for kind in MissClass},
        "boxes_matched": int(system.matched.sum()),
        "false_alarms": alarms.count,
        "false_alarms_per_frame": alarms.per_frame,
        "false_alarms_per_minute": alarms.per_minute,
        "false_alert_episodes": alarms.episodes,
        "false_alert_episodes_per_hour": alarms.episodes_per_hour,
        "mean_episode_s": alarms.mean_episode_s,
        "longest_episode_s": alarms.longest_episode_s,
    }


def _without_nan(value: Any) -> Any:
    """The same with None in place of NaN and infinities, which JSON does not have."""
    if isinstance(value, dict):
        return {key: _without_nan(item) for key, item in value.items()}
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value
