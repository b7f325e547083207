"""Estimate the detectability of every pedestrian in recordings from picture features."""

from __future__ import annotations

from collections import Counter
from dataclasses import asdict, dataclass
from typing import Any, Final, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from nvcore.common.errors import InputError, ParameterError
from nvcore.common.wording import MOST_NAMED, count_text, listed, one_line
from nvcore.notes import Note, phrase
from nvcore.settings.objects import PEDESTRIAN
from nvcore.subjects.driver.estimators import Estimator, fingerprint
from nvcore.subjects.driver.features import FEATURE_KEYS, FEATURES, LABELS, FeatureSettings
from nvcore.subjects.driver.illumination.clock import period_after
from nvcore.subjects.driver.running.run import BOX_COLUMNS, FeatureRun

DETECTABILITY_COLUMNS: Final = (
    *(*BOX_COLUMNS, "detectability", "sd"),
    *("is_outside", "outside_features", "period_s", "estimator_s"),
)
"""Columns of a detectability file, one row per truth box that is not ignored.

`period_s` is the time that the eyes had to adapt, `estimator_s` the period of the estimator.
"""
SEPARATOR: Final = ";"
"""Separator in `outside_features`, as in the tables of a comparison."""

WIDTH_FACTOR: Final = 1.1
"""Factor above which the widths of pictures count as different. (Our choice.)"""
_WHOSE: Final = ["recording", "track"]


class Steps(NamedTuple):
    """Numbers of pedestrians whose estimates switch from one period's estimator to the next.

    Attributes
    ----------
    n_crossing
        Pedestrians (tracks) whose estimates switch to another period's estimator at some frame.
    n_jumping
        Those of them whose two estimates from the same frame's features differ by more than the sd
        of each. Coming nearer therefore does not count as a jump.
    """

    n_crossing: int = 0
    n_jumping: int = 0


@dataclass(frozen=True, eq=False, repr=False)
class EstimateRun:
    """Estimated detectability of the pedestrians in recordings. ``print`` shows a summary.

    Attributes
    ----------
    table
        `DETECTABILITY_COLUMNS`, with the rows of the features.
    is_interpolated
        True if estimates are between the estimators of two periods.
    steps
        Jumps from one estimator to the next. None with interpolation.
    """

    features: FeatureRun
    table: pd.DataFrame
    estimator: Estimator
    is_interpolated: bool = False
    steps: Steps = Steps()

    @property
    def n_estimated(self) -> int:
        """Number of pedestrian boxes with an estimate."""
        return int(self.table["detectability"].notna().sum())

    @property
    def outside_by_feature(self) -> dict[str, int]:
        """Number of estimates outside the training range by feature label, most frequent first."""
        chosen = self.table.loc[self.table["is_outside"], "outside_features"].value_counts()
        counts = Counter[str]()
        for keys, n in chosen.items():  # a few combinations
            counts.update(dict.fromkeys(str(keys).split(SEPARATOR), int(n)))
        return {LABELS[key]: n for key, n in counts.most_common()}

    @property
    def n_light_unknown(self) -> int:
        """Number of estimates in frames where the last change of light is unknown."""
        is_known = np.concatenate([part.is_light_known for part in self.features.recordings])
        return int((self.table["detectability"].notna() & ~is_known).sum())

    def __repr__(self) -> str:
        return f"<EstimateRun of {count_text(len(self.table), 'box', 'boxes')}>"

    def __str__(self) -> str:
        known = self.table[self.table["detectability"].notna()]
        notes: list[Note | None] = [
            Note(
                "driver.result",
                n_known=len(known),
                n=len(self.table),
                mean=known["detectability"].mean() if len(known) else None,
                missing=None if len(known) else self._missing(),
            ),
            self._of_heat(),
            self._lacking() if len(known) else None,
        ]
        simulated = self.estimator.origin.simulated
        if caution := self.estimator.caution(simulated=simulated):
            notes.append(Note("driver.estimates", caution=caution))
        notes += self._other_width_notes()
        if self.estimator.feature_settings is None:
            settings = asdict(self.features.settings.features)
            notes.append(Note("driver.other_settings", **settings))
        if n_adapted := int(known["period_s"].isna().sum()):
            n_unknown = self.n_light_unknown
            notes.append(Note("driver.for_adapted_eyes", n=n_adapted, n_unknown=n_unknown))
        if n_outside := int(known["is_outside"].sum()):
            counts = self.outside_by_feature.items()
            features = [Note("driver.in_feature", name=name, n=n) for name, n in counts]
            notes.append(Note("driver.estimates_outside", n=n_outside, features=features))
        if self.steps.n_jumping:
            notes.append(Note("driver.jumps", **self.steps._asdict()))
        texts = [phrase(note, PEDESTRIAN) for note in notes if note is not None]
        return "\n".join([str(self.features), *texts])

    def _of_heat(self) -> Note | None:
        """Return a note on recordings whose pictures may be far infrared, or None."""
        names = [one_line(part.name) for part in self.features.recordings if part.may_be_of_heat]
        return Note("driver.of_heat", names=listed(names, most=MOST_NAMED)) if names else None

    def _lacking(self) -> Note | None:
        """Return a note on boxes with a picture but no estimate, or None."""
        table, features = self.table, self.features.table
        is_seen = (features["picture"] != "").to_numpy()
        is_unknown = table["detectability"].isna().to_numpy()
        is_lacking = is_seen & is_unknown & ~_is_of_heat(self.features)
        if not is_lacking.any():
            return None
        lost, periods = features[is_lacking].isna().any(), table.loc[is_lacking, "period_s"]
        return Note(
            "driver.lacking",
            n=len(periods),
            n_after=int(periods.notna().sum()),
            periods_s=(periods.min(), periods.max()),
            features=[LABELS[key] for key in self.estimator.features if lost[key]],
        )

    def _missing(self) -> Note | None:
        """Return a note on features that the estimator needs but no box has, or None."""
        parts = [part for part in self.features.recordings if not part.may_be_of_heat]
        table = self.features.table[~_is_of_heat(self.features)]
        if table.empty:
            return None
        is_missing = table[list(self.estimator.features)].isna().all()
        keys = [key for key in self.estimator.features if is_missing[key]]
        if not keys:
            return None
        why = dict.fromkeys(
            f"{one_line(part.name)}: {part.why_missing[key]}"
            for part in parts
            for key in keys
            if key in part.why_missing
        )
        reasons = listed([*why], most=MOST_NAMED) or None
        return Note("driver.missing", features=keys, reasons=reasons)

    def _other_widths(self) -> dict[str, int]:
        """Return picture widths that differ from those of the training, by recording name.

        Empty if the width in the training is unknown, or no feature depends on it.
        """
        trained_px = self.estimator.origin.picture_px
        if trained_px is None or not self._labels_of_scale():
            return {}
        return {
            part.name: part.picture_px[0]
            for part in self.features.recordings
            if part.picture_px is not None
            and not part.may_be_of_heat
            and max(part.picture_px[0], trained_px[0])
            > WIDTH_FACTOR * min(part.picture_px[0], trained_px[0])
        }

    def _other_width_notes(self) -> list[Note]:
        names: dict[int, list[str]] = {}
        for name, width in self._other_widths().items():
            names.setdefault(width, []).append(one_line(name))
        trained, *_ = self.estimator.origin.picture_px or (0,)
        return [
            Note(
                "driver.other_width",
                names=listed(of_width, most=MOST_NAMED),
                width=width,
                trained=trained,
                features=self._labels_of_scale(),
            )
            for width, of_width in names.items()
        ]

    def _labels_of_scale(self) -> list[str]:
        """Return the labels of the estimator's features that depend on the picture size."""
        taken = self.estimator.features
        return [of.label for of in FEATURES if of.is_of_scale and of.key in taken]

    def refuse_empty(self) -> None:
        """Raise an InputError with the reason if there are pedestrians but no estimates."""
        if self.n_estimated or self.table.empty:
            return
        note = Note(
            "driver.no_estimate",
            n=len(self.table),
            n_unseen=sum(part.n_unseen for part in self.features.recordings),
            reasons=[*filter(None, (self._missing(), self._of_heat()))],
        )
        raise InputError(phrase(note, PEDESTRIAN))

    def counts_json(self) -> dict[str, Any]:
        """Return counts of estimates, and doubts about them, as JSON values for a record."""
        parts = self.features.recordings
        counts = {
            "n": self.n_estimated,
            "n_light_unknown": self.n_light_unknown,
            "outside": self.outside_by_feature,
        }
        doubts = {
            "other_width": self._other_widths(),
            "light_doubts": {part.name: part.light_doubt for part in parts if part.light_doubt},
            "picture_doubts": {
                part.name: part.picture_doubt for part in parts if part.picture_doubt
            },
        }
        return counts | {name: entries for name, entries in doubts.items() if entries}

    def as_json(self) -> dict[str, Any]:
        """Return the estimator's name, features and training as JSON values for a record."""
        origin = self.estimator.origin.as_json()
        return {
            "name": self.estimator.name,
            "fingerprint": fingerprint(self.estimator),
            "features": list(self.estimator.features),
            "is_interpolated": self.is_interpolated,
            "no_better_at_s": list(self.estimator.no_better_at_s),
            "of_no_use": self.estimator.is_of_no_use,
            "trained_on": origin.pop("fingerprint"),
            **origin,
        }


def check_settings(settings: FeatureSettings, estimator: Estimator) -> None:
    """Raise a ParameterError if an estimator was trained on features with other settings."""
    if estimator.feature_settings is None:
        return
    own = asdict(settings)
    for name, value in asdict(estimator.feature_settings).items():
        if own[name] != value:
            raise ParameterError(
                f"{name}: the estimator was trained on features with {value:g}, found "
                f"{own[name]:g}; leave it out, or train on features with {own[name]:g}"
            )


def run_estimate(
    features: FeatureRun, estimator: Estimator, *, interpolate: bool = False
) -> EstimateRun:
    """Estimate the detectability of every pedestrian box from its features.

    Boxes that lack a feature which the estimator needs get no estimate. The same applies to grey
    pictures that are not declared as visible light, because far infrared says nothing about what
    eyes see.

    Parameters
    ----------
    features
        See `nvcore.subjects.driver.running.run.run_features`.
    estimator
        Estimator trained on pictures of the same size and angle of view.
    interpolate
        Whether to interpolate between the estimators of the adaptation periods before and after.
        Otherwise, that of the nearest period is taken.

    Raises
    ------
    ParameterError
        If the features have other settings than those that the estimator was trained on.
    """
    check_settings(features.settings.features, estimator)
    table = features.table
    period_s = table["period_s"].to_numpy(np.float64)
    values = table[list(FEATURE_KEYS)].to_numpy(np.float64, copy=True)
    values[_is_of_heat(features)] = np.nan
    estimates = estimator.estimate(values, period_s, interpolate=interpolate)
    is_known = ~np.isnan(estimates.detectability)
    own = table[list(BOX_COLUMNS)].assign(
        detectability=estimates.detectability,
        sd=estimates.sd,
        is_outside=pd.arrays.BooleanArray(estimates.is_outside & is_known, ~is_known),
        outside_features=_names(estimates.outside & is_known[:, None]),
        period_s=period_s,
        estimator_s=np.where(is_known, estimates.period_s, np.nan),
    )
    steps = Steps()
    if not interpolate:
        steps = steps_between_periods(estimator, values, own, estimates.period_s)
    return EstimateRun(features, own[list(DETECTABILITY_COLUMNS)], estimator, interpolate, steps)


def steps_between_periods(
    estimator: Estimator,
    features: NDArray[np.float64],
    table: pd.DataFrame,
    taken_s: NDArray[np.float64],
) -> Steps:
    """Count pedestrians whose estimates switch to another period's estimator as the eyes adapt.

    A new change of light does not count.

    Parameters
    ----------
    features
        Features of each row, as for `Estimator.estimate`, float64, shape (n, 8).
    table
        Table as in `EstimateRun`. Boxes without a track are skipped.
    taken_s
        Period of the estimator that was used for each row, seconds, float64, shape (n,). Rows with
        NaN (no estimator) are skipped.

    Examples
    --------
    >>> from nvcore.subjects.driver.estimators import estimator_path, read_estimator
    >>> estimator = read_estimator(estimator_path("sample"))
    >>> features = np.tile([30, 80, 20, 15, 8, 12, 2, 150.0], (2, 1))
    >>> period_s = np.array([0.9, 1.1])  # the nearest are those of 0.5 s and of 1.5 s
    >>> estimates = estimator.estimate(features, period_s)
    >>> table = pd.DataFrame({
    ...     "recording": "drive", "track": 7, "frame": [17, 21], "period_s": period_s,
    ...     "detectability": estimates.detectability, "sd": estimates.sd,
    ... })
    >>> steps_between_periods(estimator, features, table, estimates.period_s).n_crossing
    1
    """
    rows = table.assign(taken_s=taken_s, row=np.arange(len(table)))
    needed = ["track", "detectability", "period_s", "taken_s"]
    rows = rows[rows[needed].notna().all(axis=1)].sort_values([*_WHOSE, "frame"], kind="stable")
    before = rows.shift()
    is_same = (rows[_WHOSE] == before[_WHOSE]).all(axis=1)
    is_step = is_same & (rows["taken_s"] > before["taken_s"])
    steps = rows[is_step]
    former = estimator.estimate(
        features[steps["row"].to_numpy()], before.loc[is_step, "taken_s"].to_numpy(np.float64)
    )
    change = (steps["detectability"] - former.detectability).abs()
    jumps = steps[change > np.fmax(steps["sd"], former.sd)]
    return Steps(*(len(part[_WHOSE].drop_duplicates()) for part in (steps, jumps)))


def _is_of_heat(features: FeatureRun) -> NDArray[np.bool_]:
    """Return whether the picture of each row may be far infrared."""
    parts = [np.full(len(part.table), part.may_be_of_heat) for part in features.recordings]
    return np.concatenate(parts)


def _names(outside: NDArray[np.bool_]) -> NDArray[np.object_]:
    """Return the keys of each row's features outside the training range, joined to one text.

    The text is empty if all features of a row are inside.
    """
    keys = np.array([f"{key}{SEPARATOR}" for key in FEATURE_KEYS], dtype=object)
    joined = pd.Series(np.where(outside, keys, "").sum(axis=1), dtype=object)
    of_rows: NDArray[np.object_] = joined.str.removesuffix(SEPARATOR).to_numpy(object)
    return of_rows


def simulate_change(
    features: pd.DataFrame,
    end_s: NDArray[np.float64],
    change_s: float,
    estimator: Estimator,
    *,
    interpolate: bool = False,
    real_s: NDArray[np.float64] | None = None,
) -> pd.DataFrame:
    """Estimate detectability as if it had become dark at `change_s` of a recording.

    Pictures and features stay the same. Only the time that the eyes had to adapt changes: frames
    that end before the change keep their period, and in later ones it runs from the change until
    the next real change.

    Parameters
    ----------
    features
        Rows of one recording of a features file
        (`nvcore.subjects.driver.running.run.FEATURE_COLUMNS`), from visible-light pictures. Unlike
        `run_estimate`, this function does not check the kind of pictures.
    end_s
        End of each row's frame, seconds from the recording's first frame, as in the dataset, shape
        (n,).
    change_s
        Time of the simulated change on the same axis.
    interpolate
        Same as in `Estimator.estimate`.
    real_s
        Times of the real changes on the same axis, float64 (`AdaptationClock.change_s`). None:
        derive them from the periods of the rows, which misses changes that began and ended between
        two rows.

    Returns
    -------
    One row per row, with its index: period_s (NaN: adapted), detectability, sd (0..1, NaN unknown),
    is_outside, is_simulated (whether the period runs from the simulated change).

    Raises
    ------
    ParameterError
        If the time is not finite.
    """
    if not np.isfinite(change_s):
        raise ParameterError(f"change: expected seconds from the first frame, found {change_s:g}")
    known_s = features["period_s"].to_numpy(np.float64)
    period_s, is_simulated = period_after(known_s, end_s, change_s, real_s=real_s)
    estimates = estimator.estimate(
        features[list(FEATURE_KEYS)].to_numpy(np.float64), period_s, interpolate=interpolate
    )
    columns = {
        "period_s": period_s,
        "detectability": estimates.detectability,
        "sd": estimates.sd,
        "is_outside": estimates.is_outside & ~np.isnan(estimates.detectability),
        "is_simulated": is_simulated,
    }
    return pd.DataFrame(columns, index=features.index)
