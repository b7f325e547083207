"""From judged responses to what estimators learn: detectability beside the features."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd

from nvcore.driver.feature_record import about_features
from nvcore.driver.features import FeatureSettings
from nvcore.driver.inputs.study_tables import (
    LATE_S,
    NO_ANSWER,
    PEDESTRIAN,
    is_same_time,
    picture_boxes,
    read_picture_boxes,
)
from nvcore.driver.trials.judging import Judging, judge_trials
from nvcore.driver.trials.reading import SIMULATED, read_features, read_trials
from nvcore.driver.trials.subjects import CELL, subjects_table
from nvcore.errors import InputError
from nvcore.findings import Remedy, Step
from nvcore.metrics.shares import share_of
from nvcore.wording import count_text, did_you_mean, listed


@dataclass(frozen=True)
class TrainingTable:
    """Training data of estimators, and where it is from.

    Attributes
    ----------
    rows
        A row for each pedestrian and period: ``image``, ``pedestrian``, ``period_s``,
        ``detectability`` (0..1), ``n_right``, ``n_subjects``, ``low``, ``high`` (Wilson), and the
        features by their keys (float64, NaN: undefined).
    subjects
        Of `nvcore.driver.trials.subjects.subjects_table`, those left out as well.
    left_out
        Names of subjects whose responses are not in it.
    n_trials, n_off_time
        Trials in it, and those of them whose picture came more than 50 ms early or late.
    n_unanswered
        Trials without an answer in time, by their mark in ``device``; they count as not seen.
    n_outside
        Touches outside the picture; 0 where its size is not known.
    simulated
        ``"no"``, ``"all"`` or ``"some"``: trials that no person took.
    judging
        How the responses were judged.
    feature_settings
        With which the features were computed; None: no record beside their file says it.
    picture_px
        Width and height of the pictures; None: they differ, or no record beside the features says
        it.
    trials_file, features_file
        What it was read from, for errors.
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
        """Subjects whose responses are in it."""
        return len(self.subjects) - len(self.left_out)

    @property
    def responses(self) -> tuple[int, int]:
        """Fewest and most subjects who responded to one pedestrian at one period."""
        n = self.rows["n_subjects"]
        return int(n.min()), int(n.max())

    @property
    def odd_subjects(self) -> tuple[str, ...]:
        """Subjects with something odd whose responses are in the table."""
        is_odd = (self.subjects["odd"] != "") & ~self.subjects["subject"].isin(self.left_out)
        return tuple(self.subjects.loc[is_odd, "subject"])

    @property
    def n_pedestrians(self) -> int:
        """Pedestrians, each at one period at least."""
        return len(self.rows[[*PEDESTRIAN]].drop_duplicates())

    @property
    def periods_s(self) -> tuple[float, ...]:
        """The adaptation periods, ascending."""
        return tuple(sorted(self.rows["period_s"].unique().tolist()))


def training_table(
    trials: Path,
    features: Path,
    *,
    boxes: Path | None = None,
    judging: Judging | None = None,
    leave_out: Sequence[str] = (),
) -> TrainingTable:
    """Trials from files, judged and joined to the features of their pictures.

    Parameters
    ----------
    trials
        File of `nvcore.driver.inputs.study_tables.TRIAL_COLUMNS`.
    features
        File of ``image,pedestrian`` and the eight features.
    boxes
        File of ``image,pedestrian,x,y,w,h``; None: the file of features has these columns.
    judging
        How responses are judged; None: as by default.
    leave_out
        Subjects whose responses are not used.

    Raises
    ------
    InputError
        If a file cannot be used, a trial's pedestrian has no box or no features, there is no such
        subject, or two adaptation periods are nearer than `LATE_S`.
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
    """Compute how many of the subjects saw each pedestrian at each period.

    Parameters
    ----------
    judged
        Of `nvcore.driver.trials.judging.judge_trials`; a subject has each pedestrian once at a
        period.

    Returns
    -------
    ``image``, ``pedestrian``, ``period_s``, ``detectability`` (share of the subjects who are right,
    0..1), ``n_right``, ``n_subjects``, and the 95 % Wilson interval ``low``, ``high``; by period,
    then in the order of the trials.
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
    """Refuse times nearer to each other than pictures come on time: nobody plans these.

    Each would have an estimator of its own, of the few trials that had it by the clock.
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
    """Refuse pedestrians that the file of features does not have."""
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
