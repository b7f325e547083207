"""Chance that drivers react to alerts soon enough to stop for urgent encounters.

The sequence is detection, alert, reaction, foot, brakes. The driver reacts after a time drawn from
a lognormal distribution by the kind of alert, then the foot moves and the brakes build up. All
kinds, draws and systems are judged on the same encounters, those that are urgent in the comparison.
Urgency depends on the reaction time, so different sets for each kind could reverse the order of X
and Y.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import pandas as pd
import scipy

from nvcore.comparison.compare import Result
from nvcore.dataset.schema import KMH
from nvcore.evidence.bootstrap import CONFIDENCE, MIN_UNITS, SEED, count_units, expanded_tail
from nvcore.evidence.units import BLOCKS, Units, find_units
from nvcore.metrics.encounters import Encounters
from nvcore.subjects.alerts.steps import alerts_in
from nvcore.subjects.driver.comparison.steps import driver_in
from nvcore.subjects.time_left.judging import speed_of_frames
from nvcore.subjects.time_left.steps import time_left_in

MOST_DRAWS, FEWEST_DRAWS, DRAWN = 2_000, 200, 20_000_000
"""Most and fewest draws of reactions and resamples of units, and the numbers drawn in total."""
DRIVER_WORDS: Final = {
    "sees": "sees the {one} in time without an alert",
    "does_not": "does not",
    "not_known": "not known",
    "all": "all",
}
"""Rows of `InTime.of_hundred`: texts for the driver's view."""
NEVER: Final = -np.inf
"""Slack of an encounter without an alert."""


@dataclass(frozen=True)
class Reaction:
    """Distribution of the time that drivers take to react to a kind of alert.

    Attributes
    ----------
    mean_s, sd_s
        Mean and SD of the reaction times, seconds. With an SD of 0 each driver takes the mean.
    """

    mean_s: float
    sd_s: float

    def times(self, normal: np.ndarray) -> np.ndarray:
        """Convert standard normal draws to lognormal reaction times with this mean and SD."""
        variance = np.log1p((self.sd_s / self.mean_s) ** 2) if self.sd_s else 0.0
        drawn: np.ndarray = self.mean_s * np.exp(np.sqrt(variance) * normal - variance / 2)
        return drawn


REACTIONS: Final[Mapping[str, Reaction]] = {
    "visual": Reaction(1.678, 0.7551),
    "audio": Reaction(2.171, 0.7662),
    "haptic": Reaction(1.245, 0.3895),
}
"""Reactions by kind of alert: mean and SD of 11 persons, onset to tap (Aalborg 2015, experiment 2).
"""


def slack_at_onset(
    encounters: Encounters,
    ttc_s: np.ndarray,
    braking_s: np.ndarray,
    time_s: np.ndarray,
    onset_row: np.ndarray,
    last_row: np.ndarray,
    *,
    reaction_s: float,
) -> pd.DataFrame:
    """Return the time that the driver may take to react to an alert and still stop, by encounter.

    This is the time to contact at the onset minus the time needed for braking. Time to contact is
    measured with noise, so the least value of all frames up to the onset counts. As in the time
    left, an alert after the last chance is late even if a later frame seems to give time again. The
    slack at the last chance is at most `reaction_s`, however slowly the car seemed to close before.

    Parameters
    ----------
    ttc_s
        Time to contact of each truth box (`nvcore.subjects.time_left.judging.Contact.ttc_s`),
        seconds; inf: not closing, NaN: unknown. float64, shape (n_truth,).
    braking_s
        ``v / (2 * deceleration)`` of each frame, seconds; shape (n_frames,).
    time_s
        Time of each frame within its recording, seconds; shape (n_frames,).
    onset_row, last_row
        Frame row of each encounter's alert onset (-1: no alert) and last chance (-1: none, so the
        slack is not capped). int64, shape (n_encounters,).
    reaction_s
        Reaction time used for the last chance, seconds.

    Returns
    -------
    One row per encounter: slack_s (`NEVER` without an alert; NaN: no time to contact is known) and
    ttc_s at the onset, seconds (from the nearest earlier frame with a known time; NaN without an
    alert). If none is known up to the onset, both come from the first known frame, plus the time
    until then. Both are finite if there is a last chance.
    """
    n = len(encounters)
    encounter = np.repeat(np.arange(n), np.diff(encounters.offsets))
    frame, ttc = encounters.frame_index, ttc_s[encounters.order]
    table = pd.DataFrame(
        {
            "encounter": encounter,
            "ttc_s": ttc,
            "slack_s": ttc - braking_s[frame],
            "early_s": np.maximum(time_s[frame] - time_s[onset_row[encounter]], 0.0),
            "is_up_to": frame <= onset_row[encounter],
        }
    )[~np.isnan(ttc) & (onset_row[encounter] >= 0)]
    before = table[table["is_up_to"]].groupby("encounter")
    at_onset = before.agg(slack_s=("slack_s", "min"), ttc_s=("ttc_s", "last"))
    first = table.groupby("encounter").first()
    later = first[["slack_s", "ttc_s"]].add(first["early_s"], axis=0)
    found: pd.DataFrame = at_onset.combine_first(later).reindex(
        np.arange(n), columns=["slack_s", "ttc_s"]
    )
    left_s = reaction_s + np.maximum(time_s[last_row] - time_s[onset_row], 0.0)
    most_s = np.where(last_row >= 0, left_s, np.inf)
    found["slack_s"] = np.minimum(found["slack_s"], most_s)
    found["ttc_s"] = np.minimum(found["ttc_s"], most_s + braking_s[onset_row])
    found.loc[onset_row < 0, "slack_s"] = NEVER
    return found


def draw(
    onset: pd.DataFrame,
    speed_kmh: np.ndarray,
    unit: np.ndarray,
    reaction: Reaction,
    *,
    after_s: float,
    deceleration: float,
    normal: np.ndarray,
) -> dict[str, np.ndarray]:
    """Judge the encounters once for each random draw of the drivers' reaction times.

    An encounter is in time if ``slack >= reaction + after_s``, as it is urgent below that.
    Otherwise the car hits at
    ``sqrt(v^2 - 2 * deceleration * v * (ttc at onset - reaction - after_s))``, or at v without an
    alert (``docs/metrics.md``, time left).

    Parameters
    ----------
    onset
        Rows of `slack_at_onset` for the judged encounters.
    speed_kmh, unit
        Speed at the last chance, km/h, and number of the unit, from 0, of each encounter.
    after_s
        Movement of the foot and build-up of the brakes, seconds.
    normal
        Standard normal draws, shape (n_draws, n), the same for all systems and kinds, so that only
        these differ.

    Returns
    -------
    ``share`` and ``impact_kmh``: number in time, and sum of the impact speeds, of the encounters of
    each unit; float64, shape (n_draws, n_units).
    """
    slack, ttc = (onset[name].to_numpy() for name in ("slack_s", "ttc_s"))
    v = speed_kmh / KMH
    braking_from = reaction.times(normal) + after_s
    is_in_time = slack >= braking_from
    braked_s = np.where(np.isnan(ttc), 0.0, np.maximum(ttc - braking_from, 0.0))
    impact = KMH * np.sqrt(np.maximum(v**2 - 2 * deceleration * v * braked_s, 0.0))
    order = np.argsort(unit, kind="stable")
    first = np.unique(unit[order], return_index=True)[1]
    values = {"share": is_in_time.astype(float), "impact_kmh": np.where(is_in_time, 0.0, impact)}
    return {name: np.add.reduceat(of[:, order], first, axis=1) for name, of in values.items()}


def intervals(sums: np.ndarray, n: np.ndarray) -> dict[str, float]:
    """Return the mean over encounters with intervals over drivers' reactions, units, and both.

    Units are resampled as a whole with their encounters. The ends of their intervals are moved
    outwards to allow for few units (`nvcore.evidence.bootstrap.expanded_tail`).

    Parameters
    ----------
    sums
        Sums by draw and unit, as from `draw`, or differences of two; (n_draws, n_units).
    n
        Encounters of each unit, 1 or more; shape (n_units,).

    Returns
    -------
    mean; draws_low, draws_high (outcome with other drivers on these units); units_low, units_high
    (the mean over drivers and units); low, high (outcome of another study as large, with other
    drivers and units). The level is 95 %. All are NaN without encounters; with fewer than
    `MIN_UNITS` units, only the intervals of the draws are defined.
    """
    ends = ("draws_low", "draws_high", "units_low", "units_high", "low", "high")
    if not len(n):
        return dict.fromkeys(("mean", *ends), np.nan)
    by_draw = sums.sum(axis=1) / n.sum()
    limits = [*np.quantile(by_draw, [(1 - CONFIDENCE) / 2, (1 + CONFIDENCE) / 2])]
    if len(n) < MIN_UNITS:
        limits += [np.nan] * 4
    else:
        rng = np.random.default_rng(SEED)
        counts = count_units(rng.integers(0, len(n), (len(sums), len(n))), len(n))
        tail = expanded_tail(len(n))
        for resampled in (counts @ sums.mean(axis=0), (counts * sums).sum(axis=1)):
            limits += [*np.quantile(resampled / (counts @ n), [tail, 1 - tail])]
    return {"mean": float(by_draw.mean()), **dict(zip(ends, map(float, limits), strict=True))}


def chance_in_time(slack_s: np.ndarray, reaction: Reaction, after_s: float) -> np.ndarray:
    """Compute each encounter's chance that the driver reacts in time, shaped like `slack_s`.

    The chance is exact, without random draws.
    """
    left = slack_s - after_s
    if not reaction.sd_s:
        return np.where(np.isnan(left), np.nan, left >= reaction.mean_s)
    sigma = np.sqrt(np.log1p((reaction.sd_s / reaction.mean_s) ** 2))
    with np.errstate(divide="ignore"):
        z = (np.log(np.maximum(left, 0.0) / reaction.mean_s) + sigma**2 / 2) / sigma
    chance: np.ndarray = scipy.special.ndtr(z)
    return chance


@dataclass(frozen=True, eq=False)
class InTime:
    """Shares of urgent encounters in which the driver reacts in time, by kind of alert.

    Attributes
    ----------
    table
        A row for each kind of alert, measure (``share``, 0..1; ``impact_kmh``) and side (``x``,
        ``y``, ``difference``), with the columns of `intervals`; the mean of a share is exact.
    units
        Units that intervals resample. Units without urgent encounters have no part in them.
    chances
        A row for each urgent encounter (index: of ``result.encounters``): is_known (True if it is
        known whether the driver sees them unaided before the last chance), is_seen (True if the
        driver does),
        slack_s_x, slack_s_y, and for each kind the chance to be in time with X, with Y and with
        both: ``visual_x``, ``visual_y``, ``visual_both``.
    """

    table: pd.DataFrame
    units: Units
    chances: pd.DataFrame

    @property
    def what_varies(self) -> str:
        """Name of the units that intervals resample, such as ``recordings``."""
        return "stretches of these recordings" if self.units.kind == BLOCKS else self.units.kind

    def of_hundred(self, kind: str) -> pd.DataFrame:
        """Return urgent encounters, scaled to 100, by unaided driver and systems that help in time.

        Returns
        -------
        Rows ``sees``, ``does_not``, ``not_known`` (of the driver), each if there is such an
        encounter, and ``all``. If the driver is known of no encounter, ``sees`` and ``does_not``
        are NaN, and ``not_known`` is left out: it would be ``all`` again. Columns encounters, both,
        only_x, only_y, neither (in time with such an alert; they add up to encounters).
        """
        chance = {name: self.chances[f"{kind}_{name}"] for name in ("x", "y", "both")}
        parts = pd.DataFrame(
            {
                "encounters": 1.0,
                "both": chance["both"],
                "only_x": chance["x"] - chance["both"],
                "only_y": chance["y"] - chance["both"],
                "neither": 1 - chance["x"] - chance["y"] + chance["both"],
            }
        )
        driver = np.select(
            [self.chances["is_seen"], self.chances["is_known"]], ["sees", "does_not"], "not_known"
        )
        rows = parts.groupby(driver).sum()
        rows.loc["all"] = rows.sum()
        if not self.chances["is_known"].any():
            rows = rows.reindex(["sees", "does_not", "all"])
        return 100 * rows.loc[[of for of in DRIVER_WORDS if of in rows.index]] / len(self.chances)


def judge_in_time(
    result: Result,
    onset_rows: Sequence[np.ndarray],
    *,
    reactions: Mapping[str, Reaction] = REACTIONS,
    movement_s: float = 0.0,
    brakes_s: float = 0.0,
) -> InTime:
    """Judge how often drivers react in time to the alerts of X and Y in urgent encounters.

    Parameters
    ----------
    onset_rows
        Onset rows of X and Y, see `slack_at_onset`.
    reactions
        Reactions of the drivers, by kind of alert.
    movement_s, brakes_s
        Movement of the foot and build-up of the brakes, seconds. 0 is optimistic.

    References
    ----------
    ``docs/alerts.md``, in time for the driver.
    """
    dataset, params, encounters = result.dataset, result.params, result.encounters
    time_left, frames, units = time_left_in(result), dataset.frame_columns, find_units(result)
    rows = np.flatnonzero(alerts_in(result).is_to_alert)
    urgent_row = time_left.urgency["urgent_row"]
    braking_s = speed_of_frames(frames, params.speed_kmh) / KMH / (2 * params.deceleration)
    time_s, last_row = dataset.frames["time_s"].to_numpy(), urgent_row.to_numpy()
    ttc_s, reaction_s = time_left.contact.ttc_s, params.reaction_s
    sides = [
        slack_at_onset(
            encounters, ttc_s, braking_s, time_s, onset, last_row, reaction_s=reaction_s
        ).iloc[rows]
        for onset in onset_rows
    ]
    _, unit, n = np.unique(
        units.unit_of_frame[encounters.first_row[rows]], return_inverse=True, return_counts=True
    )
    after_s, speed_kmh = movement_s + brakes_s, time_left.urgency["speed_kmh"].to_numpy()[rows]
    n_draws = int(np.clip(DRAWN // max(len(rows), 1), FEWEST_DRAWS, MOST_DRAWS))
    is_seen, is_known = (
        (first >= 0) & (first < last_row[rows])
        for first in driver_in(result).table[["confirmed_row", "known_row"]].to_numpy()[rows].T
    )
    slacks = [side["slack_s"].to_numpy() for side in sides]
    chances = pd.DataFrame({"is_known": is_known, "is_seen": is_seen}, index=rows)
    chances[["slack_s_x", "slack_s_y"]] = np.column_stack(slacks)
    shared: dict[str, Any] = {"after_s": after_s, "deceleration": params.deceleration}
    drives, drive = np.unique(encounters.recording[rows], return_inverse=True)
    normal = np.random.default_rng(SEED).standard_normal((n_draws, len(drives)))
    shared["normal"] = normal[:, drive]  # a recording has a single driver
    table = []
    for kind, reaction in reactions.items():
        of_sides = dict(zip(("x", "y", "both"), (*slacks, np.minimum(*slacks)), strict=True))
        for side, slack in of_sides.items():
            chances[f"{kind}_{side}"] = chance_in_time(slack, reaction, after_s)
        x, y = (draw(side, speed_kmh, unit, reaction, **shared) for side in sides)
        exact = {side: chances[f"{kind}_{side}"].mean() for side in ("x", "y")}
        exact["difference"] = exact["x"] - exact["y"]
        for name, of_x in x.items():
            for side, sums in (("x", of_x), ("y", y[name]), ("difference", of_x - y[name])):
                row = {"kind": kind, "measure": name, "side": side, **intervals(sums, n)}
                table.append(row | ({"mean": exact[side]} if name == "share" else {}))
    return InTime(pd.DataFrame(table), units, chances)
