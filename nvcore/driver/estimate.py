"""Estimate the detectability of every pedestrian in recordings from picture features."""

from __future__ import annotations

from collections import Counter
from dataclasses import asdict, dataclass
from typing import Any, Final

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from nvcore.driver.estimators import Estimator, fingerprint
from nvcore.driver.estimators.words import LABELS, caution_of
from nvcore.driver.features import FEATURE_KEYS, FeatureSettings
from nvcore.driver.picture_width import other_width_notes, other_widths
from nvcore.driver.run import BOX_COLUMNS, FeatureRun
from nvcore.driver.steps import Steps, steps_between_periods
from nvcore.errors import InputError, ParameterError
from nvcore.notes import Note, phrase
from nvcore.objects import PEDESTRIAN
from nvcore.wording import MOST_NAMED, count_text, listed, one_line

DETECTABILITY_COLUMNS: Final = (
    *(*BOX_COLUMNS, "detectability", "sd"),
    *("is_outside", "outside_features", "period_s", "estimator_s"),
)
"""Columns of a detectability file: one row for each truth box that is not ignored. Of `period_s` is
how long the eyes have adapted, of `estimator_s` the estimator that was taken."""
SEPARATOR: Final = ";"
"""Between the features that are outside, as between attributes in the tables of a comparison."""


@dataclass(frozen=True, eq=False, repr=False)
class EstimateRun:
    """Estimated detectability of the pedestrians in recordings. ``print`` shows a summary.

    Attributes
    ----------
    features
        What it was estimated from.
    table
        `DETECTABILITY_COLUMNS`, rows as those of the features.
    estimator
        By which.
    is_interpolated
        Whether between the estimators of two periods.
    steps
        Where it is not: how often the next one is taken.
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
        lacking = self._lacking() if len(known) else ()
        notes = [self._result(known), *self._of_heat(), *lacking]
        simulated = self.estimator.origin.simulated
        if caution := caution_of(self.estimator, simulated=simulated):
            notes.append(Note("driver.estimates", caution=caution))
        notes += other_width_notes(self.features.recordings, self.estimator)
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
        texts = [phrase(note, PEDESTRIAN) for note in notes]
        return "\n".join([str(self.features), *texts])

    def _result(self, known: pd.DataFrame) -> Note:
        mean = known["detectability"].mean() if len(known) else None
        missing = None if len(known) else self._missing()
        return Note(
            "driver.result", n_known=len(known), n=len(self.table), mean=mean, missing=missing
        )

    def _of_heat(self) -> list[Note]:
        """Return a note on recordings whose pictures may be far infrared, if there are any."""
        names = [one_line(part.name) for part in self.features.recordings if part.may_be_of_heat]
        return [Note("driver.of_heat", names=listed(names, most=MOST_NAMED))] if names else []

    def _lacking(self) -> list[Note]:
        """Return a note on boxes with a picture but no estimate, and the features they lack."""
        table, features = self.table, self.features.table
        seen = (features["picture"] != "").to_numpy()
        is_lacking = seen & table["detectability"].isna().to_numpy()
        is_lacking &= ~np.concatenate(
            [np.full(len(part.table), part.may_be_of_heat) for part in self.features.recordings]
        )
        n = int(np.count_nonzero(is_lacking))
        if not n:
            return []
        keys = [
            key for key in self.estimator.features if features.loc[is_lacking, key].isna().any()
        ]
        periods = table.loc[is_lacking, "period_s"]
        return [
            Note(
                "driver.lacking",
                n=n,
                n_after=int(periods.notna().sum()),
                periods_s=(periods.min(), periods.max()),
                features=[LABELS[key] for key in keys],
            )
        ]

    def _missing(self) -> Note | None:
        """Return a note on features that the estimator needs but no box has, or None."""
        tables = [part.table for part in self.features.recordings if not part.may_be_of_heat]
        tables = [table for table in tables if len(table)]
        if not tables:
            return None
        is_missing = pd.concat(tables)[list(self.estimator.features)].isna().all()
        keys = [key for key in self.estimator.features if is_missing[key]]
        if not keys:
            return None
        why = dict.fromkeys(
            f"{one_line(part.name)}: {part.why_missing[key]}"
            for part in self.features.recordings
            for key in keys
            if key in part.why_missing and not part.may_be_of_heat
        )
        reasons = listed([*why], most=MOST_NAMED) or None
        return Note("driver.missing", features=keys, reasons=reasons)

    def refuse_empty(self) -> None:
        """Raise an error if there are pedestrians, but none has an estimate.

        Raises
        ------
        InputError
            With the reason.
        """
        if self.n_estimated or self.table.empty:
            return
        n_unseen = sum(part.n_unseen for part in self.features.recordings)
        note = Note(
            "driver.no_estimate",
            n=len(self.table),
            n_unseen=n_unseen,
            reasons=[*([missing] if (missing := self._missing()) else []), *self._of_heat()],
        )
        raise InputError(phrase(note, PEDESTRIAN))

    def counts_json(self) -> dict[str, Any]:
        """Return counts of estimates, and doubts about them, as JSON values for a record."""
        counts = {
            "n": self.n_estimated,
            "n_light_unknown": self.n_light_unknown,
            "outside": self.outside_by_feature,
        }
        widths = other_widths(self.features.recordings, self.estimator)
        doubts = {part.name: part.light_doubt for part in self.features.recordings}
        more = {
            "other_width": widths,
            "light_doubts": {name: doubt for name, doubt in doubts.items() if doubt},
            "picture_doubts": {
                part.name: part.picture_doubt
                for part in self.features.recordings
                if part.picture_doubt
            },
        }
        return counts | {name: entries for name, entries in more.items() if entries}

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
    """Refuse feature settings that differ from those that an estimator was trained on.

    Raises
    ------
    ParameterError
        With the first setting that differs.
    """
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
    features: FeatureRun,
    estimator: Estimator,
    *,
    interpolate: bool = False,
) -> EstimateRun:
    """Estimate the detectability of every pedestrian box from its features.

    Parameters
    ----------
    features
        The run, of `nvcore.driver.run.run_features`: a row for each box, with its features and how
        long the eyes have adapted.
    estimator
        Trained on pictures of the same size and angle of view.
    interpolate
        Whether to interpolate between the estimators of the periods before and after; else that of
        the nearest period is taken.

    Returns
    -------
    Detectability of each row, 0..1, with its standard deviation. Without an estimate are boxes that
    lack a feature which it needs, and those in grey pictures that nobody calls visible:
    far-infrared ones say nothing about what eyes see.

    Raises
    ------
    ParameterError
        If the features are of other settings than those that it was trained on.
    """
    check_settings(features.settings.features, estimator)
    table = features.table
    period_s = table["period_s"].to_numpy(np.float64)
    values = table[list(FEATURE_KEYS)].to_numpy(np.float64, copy=True)
    parts = [(len(recording.table), recording.may_be_of_heat) for recording in features.recordings]
    n_boxes, may_be_of_heat = zip(*parts, strict=True)
    values[np.repeat(may_be_of_heat, n_boxes)] = np.nan
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
    own = own[list(DETECTABILITY_COLUMNS)]
    return EstimateRun(features, own, estimator, interpolate, steps)


def _names(outside: NDArray[np.bool_]) -> NDArray[np.object_]:
    """Join for each row the keys of the features outside the training range to one text.

    Empty if no feature of the row is outside.
    """
    bits = 1 << np.arange(len(FEATURE_KEYS))
    choices, place = np.unique(outside @ bits, return_inverse=True)
    keys = np.array(FEATURE_KEYS)
    names = [SEPARATOR.join(keys[(choice & bits) > 0].tolist()) for choice in choices]
    of_rows: NDArray[np.object_] = np.array(names, dtype=object)[place]
    return of_rows
