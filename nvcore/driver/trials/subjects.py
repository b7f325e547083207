"""Find subjects whose responses differ from those of the others or are uninformative."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
import pandas as pd
import scipy

from nvcore import objects
from nvcore.driver.inputs.study_tables import PEDESTRIAN
from nvcore.driver.trials.judging import Judging
from nvcore.metrics.shares import share_of
from nvcore.notes import Note, phrase

LEAST_TRIALS: Final = 10
"""Fewer say nothing about a subject."""
FAR: Final = 0.25
"""A share right is far from the others' if it differs by more than this."""
EASY: Final = 0.9
"""A trial is easy if this share of the others or more is right."""
MOST_EASY: Final = 0.75
"""Who is right in fewer of the easy trials does not attend."""
AT_CHANCE_P: Final = 0.05
"""Touches are at chance unless they are better with this p-value."""
SAME_PLACE: Final = 0.5
"""Touches are always in one place if this share of them lies in one square, and not more than half
as many of the pedestrians."""
_MOST: Final = 2000
"""Touches that are compared with each other; of more, every so many."""
CELL: Final = [*PEDESTRIAN, "period_s"]
"""What trials of several subjects are of the same."""


def subjects_table(judged: pd.DataFrame, judging: Judging) -> pd.DataFrame:
    """Summarize each subject's responses and why they are odd. All subjects are kept.

    A subject is odd for any of these reasons (all limits are ours, and need 10 trials):

    - the share right is more than 0.25 from what the others' responses to the same pictures at the
      same periods let expect, which also lies outside the Wilson interval of the share;
    - they miss more than a quarter of what nine tenths of the others see;
    - their touches are not better than on other pictures (one-sided binomial test, 0.05);
    - half of their touches or more are in one place that has less than half as many pedestrians;
    - they never touch.

    Parameters
    ----------
    judged
        Of `nvcore.driver.trials.judging.judge_trials`.

    Returns
    -------
    A row for each subject, in the order of the file: ``subject``, ``n``, ``n_right``, ``share``
    with its interval ``low`` and ``high``, ``share_expected`` (from the others; NaN: there are
    none), ``n_easy`` and ``share_easy`` (trials in which nine tenths of the others are right, and
    the share right of these; NaN without any), ``n_touches``, ``share_touches_right``,
    ``share_chance``, ``share_one_place``, ``share_there`` (of the pedestrians in that place; NaN
    without touches), ``n_off_time``, and ``odd``: why, as text; empty: nothing is.
    """
    expected = _expected(judged)
    rows = []
    for subject, trials in judged.groupby("subject", sort=False):
        right = share_of(int(trials["is_right"].sum()), len(trials))
        is_easy = expected[trials.index] >= EASY
        easy = share_of(int(trials["is_right"][is_easy].sum()), int(is_easy.sum()))
        row: dict[str, Any] = {
            "subject": subject,
            "n": right.n,
            "n_right": right.n_right,
            "share": right.share,
            "low": right.low,
            "high": right.high,
            "share_expected": float(expected[trials.index].mean()),
            "n_easy": easy.n,
            "share_easy": easy.share,
            **_of_touches(trials[~trials["not_seen"]], judging),
            "n_off_time": int(trials["is_off_time"].sum()),
        }
        rows.append({**row, "odd": _odd(row)})
    return pd.DataFrame(rows)


def _expected(judged: pd.DataFrame) -> pd.Series:
    """Return for each trial the share of other subjects who are right, NaN without others."""
    groups = judged.groupby(CELL)["is_right"]
    n_others = groups.transform("size") - 1
    n_right = groups.transform("sum") - judged["is_right"]
    return (n_right / n_others.where(n_others > 0)).astype(float)


def _of_touches(trials: pd.DataFrame, judging: Judging) -> dict[str, float]:
    """Summarize the touches of one subject."""
    n = len(trials)
    if n == 0:
        unknown = ("share_touches_right", "share_chance", "share_one_place", "share_there")
        return {"n_touches": 0, **dict.fromkeys(unknown, np.nan)}
    some = trials.iloc[:: -(-n // _MOST)]
    touch = some[["touch_x", "touch_y"]].to_numpy()
    size = some[["w", "h"]].to_numpy()
    centre = some[["x", "y"]].to_numpy() + size / 2
    half = judging.square_px / 2
    reach = half + judging.centre_share * size / 2
    is_right = (np.abs(touch[:, None] - centre) < reach).all(axis=2)
    n_pairs = len(some) * (len(some) - 1)
    chance = (is_right.sum() - np.trace(is_right)) / n_pairs if n_pairs else np.nan
    is_near = (np.abs(touch[:, None] - touch) <= half).all(axis=2).mean(axis=1)
    place = touch[int(is_near.argmax())]
    return {
        "n_touches": n,
        "share_touches_right": float(trials["is_right"].mean()),
        "share_chance": float(chance),
        "share_one_place": float(is_near.max()),
        "share_there": float((np.abs(centre - place) <= half).all(axis=1).mean()),
    }


def _odd(row: dict[str, Any]) -> str:
    """Return why a subject's responses are odd, or "" if they are not."""
    if row["n"] < LEAST_TRIALS:
        return ""
    keys = []
    share, expected = row["share"], row["share_expected"]
    if abs(share - expected) > FAR and not row["low"] <= expected <= row["high"]:
        keys.append("driver.unlike_others")
    if row["n_easy"] >= LEAST_TRIALS and row["share_easy"] < MOST_EASY:
        keys.append("driver.misses_easy")
    n = int(row["n_touches"])
    if n == 0:
        keys.append("driver.never_touches")
    if n >= LEAST_TRIALS:
        n_right = round(row["share_touches_right"] * n)
        test = scipy.stats.binomtest(n_right, n, row["share_chance"], alternative="greater")
        if test.pvalue > AT_CHANCE_P:
            keys.append("driver.at_chance")
        if row["share_one_place"] >= SAME_PLACE and row["share_one_place"] > 2 * row["share_there"]:
            keys.append("driver.in_one_place")
    return "; ".join(phrase(Note(key, **row), objects.PEDESTRIAN) for key in keys)
