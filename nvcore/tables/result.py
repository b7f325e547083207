"""Tables of a `Result`, for the CSV files and the dashboard."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import product
from typing import Any

import numpy as np
import pandas as pd

from nvcore.common.findings import Finding
from nvcore.comparison.compare import Result
from nvcore.comparison.measures.entry import is_met
from nvcore.comparison.measures.table import MEASURES, hides_rate
from nvcore.comparison.measures.values import duration_of_recordings, per_recording
from nvcore.dataset.copies import units_of
from nvcore.dataset.schema import NO_TRACK, Category, integers_of
from nvcore.metrics.encounter_classes import classes_of
from nvcore.metrics.saliency import EVENT_COLUMNS
from nvcore.settings.codes import CodedInterval
from nvcore.tables.column import added_values
from nvcore.tables.columns import column_names


def _names(result: Result, recording: np.ndarray) -> np.ndarray:
    """Return the names of recordings given by row."""
    names: np.ndarray = result.dataset.recordings["name"].to_numpy(dtype=object)[recording]
    return names


def truth_values(values: np.ndarray, is_known: np.ndarray) -> Any:
    """Return truth values, missing if unknown."""
    return pd.arrays.BooleanArray(values.astype(bool), ~is_known)


def frames_table(result: Result) -> pd.DataFrame:
    """Return one row per listed frame: counts, distances (px), similarity of both systems."""
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
            f"loss_miss_{letter}": system.loss_miss,
            f"loss_false_{letter}": system.loss_false,
            f"similarity_{letter}": system.similarity,
            f"similarity_window_{letter}": system.similarity_window,
            f"salient_track_{letter}": integers_of(track, is_known),
        }
    return pd.DataFrame(columns | added_values("frames.csv", result))


def frame_numbers(result: Result, row: np.ndarray) -> Any:
    """Return frame numbers of rows of the frames table, missing if the row is -1."""
    frame, is_known = result.dataset.frames["frame"].to_numpy(), row >= 0
    numbers = np.zeros(len(row), np.int64)
    numbers[is_known] = frame[row[is_known]]
    return integers_of(numbers, is_known)


def encounters_table(result: Result) -> pd.DataFrame:
    """Return one row per encounter: category, performance of each system, and facts about it."""
    encounters, frame = result.encounters, result.dataset.frames["frame"].to_numpy()
    is_near = result.is_near
    classes = classes_of(result.dataset)
    columns: dict[str, Any] = {
        "recording": _names(result, encounters.recording),
        "track": encounters.track,
        "first_frame": frame[encounters.first_row],
        "last_frame": frame[encounters.last_row],
        "n_relevant": result.x.encounters["n_relevant"],
        "category": result.category,
    }
    for letter, system in result.sides:
        outcomes, failures = system.encounters, system.failures
        columns |= {
            f"matched_{letter}": outcomes["matched"],
            f"coverage_{letter}": outcomes["coverage"],
            f"detected_{letter}": truth_values(outcomes["is_detected"].to_numpy(), is_near),
            f"miss_class_{letter}": outcomes["miss_class"],
            f"lag_s_{letter}": outcomes["lag_s"],
            f"gap_s_{letter}": outcomes["gap_s"],
            f"tail_s_{letter}": outcomes["tail_s"],
            f"severity_s_{letter}": failures["severity_s"],
            f"peak_cost_{letter}": failures["peak_cost"],
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
        "attributes": classes.attributes,
        "classes": classes.texts,
    }
    return pd.DataFrame(columns | added_values("encounters.csv", result))


def _spans(result: Result, spans: pd.DataFrame, letter: str) -> dict[str, Any]:
    """Return the columns that events, intervals and episodes share."""
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
    """Return one row per saliency event of either system."""
    return located_events(result)[column_names("events.csv")]


def located_events(result: Result) -> pd.DataFrame:
    """Return `events_table` with the rows of each event in the other tables.

    Returns
    -------
    The columns of `events_table`, and recording_row (row of the recordings table), first_row and
    last_row (rows of the frames table).
    """
    tables = []
    for letter, system in result.sides:
        spans = _spans(result, system.events, letter)
        others = set(EVENT_COLUMNS) - spans.keys() - {"encounter"}
        spans |= {name: system.events[name] for name in EVENT_COLUMNS if name in others}
        spans["recording_row"] = system.events["recording"]
        tables.append(pd.DataFrame(spans))
    return pd.concat(tables, ignore_index=True)


def worst_events(result: Result, letter: str, *, n: int = 5) -> pd.DataFrame:
    """Return one system's `n` events with the largest saliency, worst first.

    The columns are those of `located_events`.
    """
    return _worst(located_events(result), letter, "saliency_s", n)


def intervals_table(result: Result) -> pd.DataFrame:
    """Return one row per low-similarity interval of either system."""
    frame = result.dataset.frames["frame"].to_numpy()
    tables = []
    for letter, system in result.sides:
        spans = _spans(result, system.intervals, letter)
        spans |= {
            "depth_s": system.intervals["depth_s"].to_numpy(),
            "min_similarity": system.intervals["min_similarity"].to_numpy(),
            "worst_frame": frame[system.intervals["worst_row"].to_numpy()],
        }
        tables.append(pd.DataFrame(spans))
    return pd.concat(tables, ignore_index=True)


def episodes_table(result: Result) -> pd.DataFrame:
    """Return one row per false-alert episode of either system, with its false alarms as n_boxes."""
    spans = [
        _spans(result, system.episodes, letter) | {"n_boxes": system.episodes["n_boxes"].to_numpy()}
        for letter, system in result.sides
    ]
    return pd.concat([pd.DataFrame(columns) for columns in spans], ignore_index=True)


def worst_intervals(result: Result, letter: str, *, n: int = 5) -> pd.DataFrame:
    """Return one system's `n` low-similarity intervals with the largest depth, worst first."""
    return _worst(intervals_table(result), letter, "depth_s", n)


def _worst(table: pd.DataFrame, letter: str, column: str, n: int) -> pd.DataFrame:
    of_system = table[table["system"] == letter]
    return of_system.sort_values(column, ascending=False, kind="stable").head(n)


def recordings_table(result: Result) -> pd.DataFrame:
    """Return one row per recording: its size, Venn counts, and the aggregates of both systems."""
    dataset, frames = result.dataset, result.dataset.frame_columns
    # mean of its series, or else the speed that the recording states
    by_series = dataset.frames["speed_kmh"].groupby(dataset.frames["recording"]).mean()
    speed = by_series.reindex(dataset.recordings.index).fillna(dataset.recordings["speed_kmh"])
    columns: dict[str, Any] = {
        "recording": dataset.recordings["name"],
        "width": dataset.recordings["width"],
        "height": dataset.recordings["height"],
        "fps": dataset.recordings["fps"],
        "context": dataset.recordings["context"],
        "speed_kmh": speed,
        "unit": units_of(dataset),
        "n_frames": np.diff(frames.first),
        "duration_s": duration_of_recordings(result),
        "n_truth": per_recording(result, result.n_truth, frames.recording).astype(np.int64),
    }
    for category in Category:
        is_category = result.category == category.value
        columns[category.value] = per_recording(
            result, is_category, result.encounters.recording
        ).astype(np.int64)
    for (letter, system), measure in product(result.sides, MEASURES):
        if measure.by_recording is not None and is_met(measure.only_if, result):
            values = measure.by_recording(result, system)
            if np.any(is_hidden := hides_rate(measure, columns["duration_s"])):
                values = np.where(is_hidden, np.nan, values)
            columns[f"{measure.key}_{letter}"] = values
    return pd.DataFrame(columns | added_values("recordings.csv", result))


def codes_table(codes: Iterable[CodedInterval]) -> pd.DataFrame:
    """Return one row per coded interval, by recording and time.

    `nvcore.inputs.codes` can read it.
    """
    rows = [of.given() for of in sorted(codes)]
    return pd.DataFrame(rows, columns=column_names("codes.csv"))


def findings_table(findings: tuple[Finding, ...]) -> pd.DataFrame:
    """Return one row per finding of the audit, in the given order."""
    names = column_names("findings.csv")
    rows = [{name: str(getattr(finding, name)) for name in names} for finding in findings]
    return pd.DataFrame(rows, columns=names).astype({"count": "int64"})
