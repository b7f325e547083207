"""Training data of estimators from judged responses: detectability beside the features."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd
import scipy

from nvcore.common.errors import InputError
from nvcore.common.findings import Remedy, Step
from nvcore.common.wording import count_text, did_you_mean, listed
from nvcore.inputs.readers.parse.table import read_table
from nvcore.metrics.shares import share_of
from nvcore.notes import Note, phrase
from nvcore.settings import objects
from nvcore.subjects.driver.features import FEATURE_KEYS, FeatureSettings
from nvcore.subjects.driver.features.feature_record import about_features
from nvcore.subjects.driver.inputs.study_tables import (
    BOX,
    LARGEST,
    LATE_S,
    LONGEST_S,
    NO_ANSWER,
    PEDESTRIAN,
    TRIAL_COLUMNS,
    check_pedestrians,
    is_same_time,
    picture_boxes,
    read_picture_boxes,
)
from nvcore.subjects.driver.trials.judging import Judging, judge_trials

SIMULATED: Final = "simulated"
"""Device name of trials with simulated subjects."""


def read_trials(path: Path) -> pd.DataFrame:
    """Read trials from a CSV file with one row per picture shown to a subject.

    The columns are `TRIAL_COLUMNS`, in any order, separated by commas, semicolons or tabs.
    ``adaptation_asked_s`` is the planned time from the change of light to the picture's appearance,
    ``adaptation_measured_s`` the measured one. ``touch_x`` and ``touch_y`` are in pixels of the
    picture, and empty if ``not_seen`` is 1. ``adaptation_measured_s``, ``response_s`` and
    ``device`` may be empty.

    Returns
    -------
    The columns in the order of `TRIAL_COLUMNS`, and ``line``: text, integers (int64), seconds and
    pixels (float64, NaN: empty), ``not_seen`` as bool.

    Raises
    ------
    InputError
        If the file cannot be opened, a column is missing, a field is invalid, a row has both or
        neither of a touch and ``not_seen``, or a subject sees a picture twice at one time. Errors
        in a row state the line.
    """
    table = read_table(path, what="trials", required=TRIAL_COLUMNS)
    seconds = partial(table.numbers, low=0.0, high=LONGEST_S)
    values = partial(table.numbers, low=-LARGEST, high=LARGEST)
    trials = pd.DataFrame(
        {
            "subject": table.texts("subject"),
            **{name: table.whole_numbers(name) for name in ("run", "position", "order")},
            **{name: table.texts(name) for name in PEDESTRIAN},
            "adaptation_asked_s": seconds("adaptation_asked_s"),
            "adaptation_measured_s": seconds("adaptation_measured_s", may_be_empty=True),
            "touch_x": values("touch_x", may_be_empty=True),
            "touch_y": values("touch_y", may_be_empty=True),
            "response_s": seconds("response_s", may_be_empty=True),
            "not_seen": table.flags("not_seen"),
            "device": table.texts("device", may_be_empty=True),
            "line": table.lines,
        }
    )
    has_touch = trials[["touch_x", "touch_y"]].notna()
    not_seen = trials["not_seen"].to_numpy()
    is_wrong = np.where(not_seen, has_touch.any(axis=1), ~has_touch.all(axis=1))
    if is_wrong.any():
        row = int(np.argmax(is_wrong))
        expected = "no touch where not_seen is 1" if not_seen[row] else "touch_x and touch_y"
        raise table.fault(row, f"expected {expected}; or change not_seen")
    shown = trials[["subject", *PEDESTRIAN, "adaptation_asked_s"]]
    twice = shown.duplicated().to_numpy()
    if twice.any():
        row = int(np.argmax(twice))
        trial = shown.iloc[row]
        first = int(np.argmax((shown == trial).all(axis=1)))
        raise table.repeated(
            row,
            first,
            f"{trial['subject']} is shown the picture {trial['image']} after "
            f"{trial['adaptation_asked_s']:g} s a second time",
        )
    return trials


def read_features(path: Path) -> tuple[pd.DataFrame, pd.DataFrame | None]:
    """Read pedestrians' features from a file written by ``nvcore driver features``.

    Returns
    -------
    ``image``, ``pedestrian`` and the features by their keys (float64, NaN: undefined), and the
    boxes as in `picture_boxes`, or None if the file has no boxes.

    Raises
    ------
    InputError
        If the file cannot be opened or is not such a table, or a pedestrian occurs twice. Errors in
        a row state the line.
    """
    table = read_table(path, what="features", required=(*PEDESTRIAN, *FEATURE_KEYS))
    check_pedestrians(table)
    values = partial(table.numbers, low=-LARGEST, high=LARGEST, may_be_empty=True)
    features = pd.DataFrame(
        {name: table.texts(name) for name in PEDESTRIAN}
        | {name: values(name) for name in FEATURE_KEYS}
    )
    return features, picture_boxes(table) if all(name in table for name in BOX) else None


LEAST_TRIALS: Final = 10
"""Minimum number of trials to judge a subject."""
FAR: Final = 0.25
"""Maximum difference between a subject's share right and the others'."""
EASY: Final = 0.9
"""Minimum share of others who are right in an easy trial."""
MOST_EASY: Final = 0.75
"""Minimum share right in easy trials for a subject who pays attention."""
AT_CHANCE_P: Final = 0.05
"""Maximum p-value at which touches count as better than chance."""
SAME_PLACE: Final = 0.5
"""Minimum share of touches in one square to count as always in one place, if that square holds at
most half as large a share of the pedestrians.
"""
_MOST: Final = 2000
"""Maximum number of touches to compare with each other. More are subsampled."""
CELL: Final = [*PEDESTRIAN, "period_s"]
"""Columns that group trials of several subjects with the same picture and period."""


def subjects_table(judged: pd.DataFrame, judging: Judging) -> pd.DataFrame:
    """Summarize each subject's responses and list oddities. All subjects are kept.

    A subject is odd for any of these reasons (all limits are our choice, and need 10 trials):

    - the share right differs by more than 0.25 from the share expected from the others' responses
      to the same pictures at the same periods, which is also outside its Wilson interval;
    - they miss more than a quarter of what nine tenths of the others see;
    - their touches are not better than on other pictures (one-sided binomial test, 0.05);
    - half of their touches or more are in one place that has less than half as many pedestrians;
    - there are no touches.

    Parameters
    ----------
    judged
        Table from `nvcore.subjects.driver.trials.judging.judge_trials`.

    Returns
    -------
    A row for each subject, in the order of the file: ``subject``, ``n``, ``n_right``, ``share``
    with its interval ``low`` and ``high``, ``share_expected`` (from the others, NaN without
    others), ``n_easy`` and ``share_easy`` (number of trials in which nine tenths of the others are
    right, and the subject's share right in them, NaN without any), ``n_touches``,
    ``share_touches_right``, ``share_chance``, ``share_one_place``, ``share_there`` (share of
    pedestrians in that place, NaN without touches), ``n_off_time``, and ``odd``: the reasons as
    text, or empty.
    """
    groups = judged.groupby(CELL)["is_right"]
    n_others = groups.transform("size") - 1
    by_others = groups.transform("sum") - judged["is_right"]
    expected = (by_others / n_others.where(n_others > 0)).astype(float)  # NaN without others
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


@dataclass(frozen=True)
class TrainingTable:
    """Training data of estimators, with their origin.

    Attributes
    ----------
    rows
        A row for each pedestrian and period: ``image``, ``pedestrian``, ``period_s``,
        ``detectability`` (0..1), ``n_right``, ``n_subjects``, ``low``, ``high`` (Wilson), and the
        features by their keys (float64, NaN: undefined).
    subjects
        Table from `subjects_table`, including subjects left out.
    left_out
        Names of subjects whose responses are excluded.
    n_trials, n_off_time
        Numbers of trials in total, and of those with a picture more than 50 ms early or late.
    n_unanswered
        Number of trials without an answer in time, marked in ``device``. They count as not seen.
    n_outside
        Number of touches outside the picture. 0 if its size is unknown.
    simulated
        ``"no"``, ``"all"`` or ``"some"``: share of trials with simulated subjects.
    judging
        Criteria by which the responses were judged.
    feature_settings
        Settings of the feature computation. None: no record beside the file states them.
    picture_px
        Width and height of the pictures. None: they differ, or no record beside the features states
        them.
    trials_file, features_file
        Source files, for error messages.
    """

    rows: pd.DataFrame
    subjects: pd.DataFrame
    left_out: tuple[str, ...]
    n_trials: int
    n_off_time: int
    simulated: str
    judging: Judging
    feature_settings: FeatureSettings | None = None
    trials_file: Path | None = None
    features_file: Path | None = None
    picture_px: tuple[int, int] | None = None
    n_unanswered: int = 0
    n_outside: int = 0

    @property
    def n_subjects(self) -> int:
        """Number of subjects whose responses are included."""
        return len(self.subjects) - len(self.left_out)

    @property
    def responses(self) -> tuple[int, int]:
        """Minimum and maximum number of subjects per pedestrian and period."""
        n = self.rows["n_subjects"]
        return int(n.min()), int(n.max())

    @property
    def odd_subjects(self) -> tuple[str, ...]:
        """Included subjects with odd responses."""
        is_odd = (self.subjects["odd"] != "") & ~self.subjects["subject"].isin(self.left_out)
        return tuple(self.subjects.loc[is_odd, "subject"])

    @property
    def n_pedestrians(self) -> int:
        """Number of pedestrians that occur at one period at least."""
        return len(self.rows[[*PEDESTRIAN]].drop_duplicates())

    @property
    def periods_s(self) -> tuple[float, ...]:
        """Adaptation periods, ascending."""
        return tuple(sorted(self.rows["period_s"].unique().tolist()))


def training_table(
    trials: Path,
    features: Path,
    *,
    boxes: Path | None = None,
    judging: Judging | None = None,
    leave_out: Sequence[str] = (),
) -> TrainingTable:
    """Read trials from files, judge them and join them to the features of their pictures.

    Parameters
    ----------
    trials
        File with the columns `nvcore.subjects.driver.inputs.study_tables.TRIAL_COLUMNS`.
    features
        File with ``image,pedestrian`` and the eight features.
    boxes
        File with ``image,pedestrian,x,y,w,h``. None: the file of features has these columns.
    judging
        Criteria for correct responses. None: the defaults.
    leave_out
        Subjects whose responses are excluded.

    Raises
    ------
    InputError
        If a file cannot be used, a trial's pedestrian has no box or no features, a subject to leave
        out does not exist, or two adaptation periods are closer than `LATE_S`.
    """
    judging = judging or Judging()
    table, own_boxes = read_features(features)
    places = own_boxes if boxes is None else picture_boxes(read_picture_boxes(boxes))
    if places is None:
        raise InputError(
            "to judge the responses the boxes of the pedestrians are needed: columns x,y,w,h "
            "here, or a file of image,pedestrian,x,y,w,h",
            file=features,
            steps=(Step(Remedy.OPTION, "", "boxes"),),
        )
    responses = read_trials(trials)
    if responses.empty:
        raise InputError("there is no trial in it", file=trials)
    _refuse_measured_times(responses, trials)
    judged = judge_trials(responses, places, judging, name=str(trials))
    subjects = subjects_table(judged, judging)
    for name in leave_out:
        if name not in set(subjects["subject"]):
            known = listed(subjects["subject"].tolist())
            hint = did_you_mean(name, subjects["subject"], f"there are {known}")
            raise InputError(f"there is no subject {name!r}; {hint}", file=trials)
    used = judged[~judged["subject"].isin(list(leave_out))]
    if used.empty:
        raise InputError("all subjects are left out: there is nothing to learn", file=trials)
    rows = detectability_table(used).merge(table, how="left", on=[*PEDESTRIAN], indicator=True)
    _refuse_without_features(rows, used, trials, features)
    is_simulated = used["device"].str.casefold() == SIMULATED
    feature_settings, picture_px = about_features(features)
    touch = used[["touch_x", "touch_y"]].to_numpy(np.float64)
    is_outside = (touch < 0) | (touch > (picture_px or np.inf))
    return TrainingTable(
        rows=rows.drop(columns="_merge"),
        subjects=subjects,
        left_out=tuple(dict.fromkeys(leave_out)),
        n_trials=len(used),
        n_off_time=int(used["is_off_time"].sum()),
        simulated="all" if is_simulated.all() else "some" if is_simulated.any() else "no",
        judging=judging,
        feature_settings=feature_settings,
        trials_file=trials,
        features_file=features,
        picture_px=picture_px,
        n_unanswered=int(used["device"].str.contains(NO_ANSWER, regex=False).sum()),
        n_outside=0 if picture_px is None else int(is_outside.any(axis=1).sum()),
    )


def detectability_table(judged: pd.DataFrame) -> pd.DataFrame:
    """Compute the share of subjects who saw each pedestrian at each period.

    Parameters
    ----------
    judged
        Table from `nvcore.subjects.driver.trials.judging.judge_trials`. A subject sees each
        pedestrian once per period.

    Returns
    -------
    ``image``, ``pedestrian``, ``period_s``, ``detectability`` (share of subjects who are right,
    0..1), ``n_right``, ``n_subjects``, and the 95 % Wilson interval ``low``, ``high``. Sorted by
    period, then in the order of the trials.
    """
    groups = judged.groupby(CELL, sort=False)["is_right"]
    counts = pd.DataFrame({"n_right": groups.sum(), "n_subjects": groups.size()}).reset_index()
    counts = counts.sort_values("period_s", kind="stable", ignore_index=True)
    pairs = counts[["n_right", "n_subjects"]].astype("int64")
    of_pair = cache(share_of)
    shares = [of_pair(*pair) for pair in pairs.itertuples(index=False, name=None)]
    detectability, low, high = np.array([(of.share, of.low, of.high) for of in shares]).T
    return counts[CELL].assign(detectability=detectability, **pairs, low=low, high=high)


def _refuse_measured_times(responses: pd.DataFrame, trials: Path) -> None:
    """Reject periods closer together than pictures are on time, which are measured times.

    Each of them would get its own estimator from the few trials with that measured time.
    """
    asked_s = np.unique(responses["adaptation_asked_s"].round(6))
    is_near = is_same_time(np.diff(asked_s))
    if is_near.any():
        at = int(np.argmax(is_near))
        raise InputError(
            f"the adaptation times {asked_s[at]:g} and {asked_s[at + 1]:g} s are less than "
            f"{1000 * LATE_S:g} ms apart: are these the planned times (adaptation_asked_s), not "
            "the measured ones? Each has an estimator of its own",
            file=trials,
        )


def _refuse_without_features(
    rows: pd.DataFrame, used: pd.DataFrame, trials: Path, features: Path
) -> None:
    """Reject pedestrians that the feature file lacks."""
    lost = rows[rows["_merge"] == "left_only"]
    if lost.empty:
        return
    image, pedestrian = lost.iloc[0][[*PEDESTRIAN]]
    is_first = (used["image"] == image) & (used["pedestrian"] == pedestrian)
    n_lost = len(lost[[*PEDESTRIAN]].drop_duplicates())
    raise InputError(
        f"{features.name} has no features of the pedestrian {pedestrian} of the picture {image}"
        + (f", nor of {count_text(n_lost - 1, 'other')}" if n_lost > 1 else ""),
        file=trials,
        line=int(used.loc[is_first, "line"].iloc[0]),
    )
