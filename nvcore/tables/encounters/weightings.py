"""One encounter under height, horizon and distance weighting, side by side."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
import pandas as pd

from nvcore.comparison.compare import Result
from nvcore.comparison.scoring import weigh_misses
from nvcore.metrics.encounters import RELEVANT_K, find_encounters, judge_encounters
from nvcore.metrics.proximity import in_use, weigh_proximity
from nvcore.metrics.proximity.borrowing import weighing_truth
from nvcore.metrics.severity import cost_of_miss, weigh_failures
from nvcore.settings.params import Params, Proximity

KINDS: Final[tuple[Proximity, ...]] = ("height", "horizon", "distance")
"""Measures of how near a pedestrian is."""


@dataclass(frozen=True, eq=False)
class Weightings:
    """Results of an encounter under each of `KINDS`.

    Attributes
    ----------
    curves
        One row per frame of the encounter: row (of the frames table), frame, time_s, and for each
        kind ``k_<kind>``, the proximity weight, NaN if horizon or distance are unknown; matched_x,
        matched_y. If a track occurs twice in a frame, the nearer box's weight is used.
    table
        One row per kind, in order: is_known; n_relevant, first_frame, last_frame (of the relevant
        ones); n_by_height, boxes without a distance, which count by height; and for each system
        missed, severity_s, detected and miss_class. Values are missing if the kind is unknown.
    in_use
        Kind that the comparison uses; empty for none of them.
    """

    curves: pd.DataFrame
    table: pd.DataFrame
    in_use: str


def compare_weightings(result: Result, encounter: int) -> Weightings:
    """Judge an encounter with nearness measured by height, by horizon, and by distance.

    All other settings are those of the result. By distance, boxes without one count by height, as
    usual. An encounter without any distance is unknown by distance.

    Parameters
    ----------
    encounter
        Row of ``result.encounters``.
    """
    encounters, dataset = result.encounters, result.dataset
    start, stop = encounters.offsets[encounter : encounter + 2]
    rows = np.sort(encounters.order[start:stop])
    frame_row, first_box = np.unique(dataset.truth.frame_index[rows], return_index=True)
    frames = dataset.frames
    curves: dict[str, np.ndarray] = {
        "row": frame_row,
        "frame": frames["frame"].to_numpy()[frame_row],
        "time_s": frames["time_s"].to_numpy()[frame_row],
    }
    table = []
    for kind in KINDS:
        k, has_own_kind, facts = _judge(result, encounter, rows, kind)
        shown = np.where(has_own_kind, k, -np.inf)
        nearest = np.maximum.reduceat(shown, first_box)
        curves[f"k_{kind}"] = np.where(np.isfinite(nearest), nearest, np.nan)
        table.append({"kind": kind, **facts})
    for letter, system in result.sides:
        is_matched = system.matches.is_matched[rows]
        curves[f"matched_{letter}"] = np.logical_or.reduceat(is_matched, first_box)
    kind_in_use = result.params.proximity
    return Weightings(
        pd.DataFrame(curves),
        pd.DataFrame(table).set_index("kind"),
        kind_in_use if kind_in_use in KINDS else "",
    )


def _judge(
    result: Result, encounter: int, rows: np.ndarray, kind: Proximity
) -> tuple[np.ndarray, np.ndarray, dict[str, object]]:
    """Return each truth row's weight, whether it is of the kind, and the resulting table row."""
    dataset, frames = result.dataset, result.dataset.frame_columns
    params = _params_by(result, encounter, kind)
    if params is None:
        return np.zeros(len(rows)), np.zeros(len(rows), dtype=bool), {"is_known": False}
    is_own = np.zeros(len(dataset.truth), dtype=bool)
    is_own[rows] = True
    truth = weighing_truth(dataset, params).only(is_own)
    has_own_kind = np.isfinite(truth.distance_m) if kind == "distance" else np.ones(len(rows), bool)
    if not has_own_kind.any():
        return np.zeros(len(rows)), has_own_kind, {"is_known": False}
    k = weigh_proximity(truth, ~truth.ignore, frames, params).k
    k_miss = weigh_misses(k, dataset, params, rows=rows)
    cost = cost_of_miss(truth, k_miss, frames, in_use(params, "edge_weight", frames))
    occlusion = dataset.boxes["occlusion"].to_numpy()[rows]
    alone = find_encounters(truth, result.tracks.track[rows], occlusion, frames)
    relevant = truth.frame_index[k >= RELEVANT_K]
    facts: dict[str, object] = {
        "is_known": True,
        "n_by_height": int(np.count_nonzero(~has_own_kind)),
        "first_frame": int(frames.frame[relevant[0]]) if len(relevant) else None,
        "last_frame": int(frames.frame[relevant[-1]]) if len(relevant) else None,
    }
    for letter, system in result.sides:
        is_matched = system.matches.is_matched[rows]
        outcome = judge_encounters(alone, k, is_matched, frames, params).iloc[0]
        failures = weigh_failures(truth, alone, k, cost, is_matched, frames).iloc[0]
        n_relevant = int(outcome["n_relevant"])
        facts |= {
            "n_relevant": n_relevant,
            f"missed_{letter}": n_relevant - int(outcome["matched"]),
            f"severity_s_{letter}": float(failures["severity_s"]),
            f"detected_{letter}": bool(outcome["is_detected"]) if n_relevant else None,
            f"miss_class_{letter}": outcome["miss_class"],
        }
    return k, has_own_kind, facts


def _params_by(result: Result, encounter: int, kind: Proximity) -> Params | None:
    """Return the result's settings with another kind of nearness, or None if it is unknown."""
    params = replace(result.params, proximity=kind)
    if kind != "horizon":
        return params
    recording = int(result.encounters.recording[encounter])
    horizon = float(in_use(params, "horizon", result.dataset.frame_columns)[recording])
    # as a setting, because other recordings may lack theirs
    return None if np.isnan(horizon) else replace(params, horizon=horizon)
