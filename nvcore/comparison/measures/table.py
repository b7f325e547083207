"""Every measure of a comparison, defined once in `MEASURES`.

A measure is a number that describes a system (a figure is a chart). Its entry defines the row of
the scorecard, the key of ``summary.json``, the columns of ``recordings.csv``, the name in rules of
the gate, the rows of the table of evidence and of its groups, the axes of forest plots and of the
report's intervals, and the tables of ``docs/report.md``. `nvcore.evidence` resamples and tests its
difference. The entry only provides the summands of the measure.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from itertools import chain
from typing import Any, Final

import numpy as np
import pandas as pd

from nvcore.common.errors import ParameterError
from nvcore.common.subject import subjects
from nvcore.common.wording import LEAST_HOURLY_S, did_you_mean, difference, duration_text, one_line
from nvcore.comparison.compare import Result
from nvcore.comparison.measures.entry import HOUR_S, PER_HOUR, Inference, Measure, MeasureTable
from nvcore.comparison.measures.of_alarms import ALARM_MEASURES
from nvcore.comparison.measures.of_curves import CURVE_MEASURES
from nvcore.comparison.measures.of_encounters import DETECTED, ENCOUNTER_MEASURES
from nvcore.comparison.measures.of_frames import FRAME_MEASURES
from nvcore.settings.params import Params
from nvcore.settings.primary import Primary, now_text

MEASURES: Final[tuple[Measure, ...]] = (
    *FRAME_MEASURES,
    *ENCOUNTER_MEASURES,
    *chain(*(subject.scores().measures for subject in subjects())),
    *ALARM_MEASURES,
    *CURVE_MEASURES,
)

_BY_KEY: Final = {measure.key: measure for measure in MEASURES}
_INFERENCE: Final = {
    measure.key: measure.inference for measure in MEASURES if measure.inference is not None
}

EVIDENCE_KEYS: Final = tuple(sorted(_INFERENCE, key=lambda key: not key.startswith(DETECTED)))
"""Keys of the table of evidence: encounters detected first, then in the order of `MEASURES`."""


CLAIMABLE: Final = {
    key.removesuffix("_by_unit"): key for key, inference in _INFERENCE.items() if inference.noun
}
"""Keys of the measures whose differences the verdict may claim, by the users' names."""


def claimable_key(name: str) -> str:
    """Look up the key of a measure in `CLAIMABLE` by its name or key.

    Raises
    ------
    ParameterError
        If there is none.
    """
    return key_in(CLAIMABLE, name, "no verdict can rest on")


def key_in(keys: Mapping[str, str], name: str, refusal: str) -> str:
    """Look up the key of a measure by its name or key, or raise ParameterError with the refusal."""
    if name in keys.values():
        return name
    if name not in keys:
        hint = did_you_mean(name, keys, f"the measures are {', '.join(keys)}")
        raise ParameterError(f"{refusal} {one_line(name)!r}: {hint}")
    return keys[name]


def choose_primary(primary: Primary, name: str | None) -> Primary:
    """Return the primary measure called `name`, or `primary` if `name` is None.

    Raises
    ------
    ParameterError
        If no verdict can rest on it.
    """
    own = replace(primary, key=claimable_key(primary.key))
    return own if name is None else own.choose(claimable_key(name), fixed_at=now_text())


def label_words(result: Result, units: str = "") -> dict[str, Any]:
    """Return the settings and counts of a result that labels of measures mention.

    Parameters
    ----------
    units
        Resampled units: ``recordings`` or ``blocks``.
    """

    def count() -> dict[str, int]:
        counts = {name: int(members(result).sum()) for name, members in counted().items()}
        return counts | {"n_near": result.venn.n_near, "n_boxes": int(result.n_truth.sum())}

    return words_of(result.params, result.keep("label_counts", count), units)


def words_of(params: Params, counts: Mapping[str, int], units: str) -> dict[str, Any]:
    """Return the values for `label_words` from settings and counts."""
    aggregate = "largest event" if params.saliency_aggregate == "max" else "sum of events"
    own = {"low": params.low, "window": params.window, "aggregate": aggregate, "units": units}
    return own | dict(counts)


def counted() -> dict[str, Callable[[Result], np.ndarray]]:
    """Return functions that select encounters for subjects' counts, by name in labels and `per`.

    Each is bool, shape (n_encounters,).
    """
    return dict(chain(*(subject.scores().counts.items() for subject in subjects())))


def count_recordings(result: Result) -> int:
    """Return the number of recordings that have frames."""
    return int(np.count_nonzero(np.diff(result.dataset.frame_columns.first)))


def has_several_recordings(result: Result) -> bool:
    """Return whether at least two recordings contain frames."""
    return count_recordings(result) > 1


def measures_in(table: MeasureTable) -> tuple[Measure, ...]:
    """Return the measures listed in a table."""
    return tuple(measure for measure in MEASURES if table in measure.tables)


def measure_of(key: str) -> Measure:
    """Return the measure with this key."""
    return _BY_KEY[key]


def applies_to(result: Result, measure: Measure) -> bool:
    """Return whether a measure applies to a comparison. Some need urgent encounters."""
    return measure.applies is None or measure.applies(result)


def doubt_of(result: Result, measure: Measure) -> str:
    """Return why a measure is too doubtful for claims or for a better value, or "" if it is not."""
    doubts = chain(*(subject.report().doubts for subject in subjects()))
    return next(filter(None, (doubt(result, measure) for doubt in doubts)), "")


def hides_rate(measure: Measure, duration_s: float | np.ndarray) -> Any:
    """Return True for a rate per hour that rests on less than ten minutes of recording.

    Such a rate has no value in tables, files and rules.
    """
    return measure.unit == PER_HOUR and (duration_s > 0) & (duration_s < LEAST_HOURLY_S)


def is_usable(result: Result, measure: Measure) -> bool:
    """Return whether a gate rule can use a measure: it has a value and no doubts."""
    has_value = applies_to(result, measure) and not hides_rate(measure, result.duration_s)
    return has_value and not doubt_of(result, measure)


def evidence_keys(result: Result) -> tuple[str, ...]:
    """Return those of the `EVIDENCE_KEYS` that apply to a comparison."""
    return tuple(key for key in EVIDENCE_KEYS if applies_to(result, _BY_KEY[key]))


def inference_of(key: str) -> Inference:
    """Return the method for testing the difference of a measure of `EVIDENCE_KEYS`."""
    return _INFERENCE[key]


def repeated_by(key: str) -> str:
    """Return the key of another measure that tests the same hypothesis, or "" if there is none."""
    return _INFERENCE[key].repeats if key in _INFERENCE else ""


def evidence_form(key: str) -> str:
    """Return the number format of a measure of `EVIDENCE_KEYS` where its evidence is shown."""
    return inference_of(key).form or _BY_KEY[key].form


def evidence_label(key: str, result: Result, units: str) -> str:
    """Return the label of a measure of `EVIDENCE_KEYS` where its evidence is shown.

    Parameters
    ----------
    units
        Resampled units: ``recordings`` or ``blocks``.
    """
    template = inference_of(key).label or _BY_KEY[key].label
    return result.objects.say(template, **label_words(result, units))


def shown_as(key: str, result: Result) -> tuple[float, str]:
    """Return the factor by which a measure's values are multiplied when shown, and their suffix.

    If recordings last seconds, the number "in 7.2 s" is shown instead of a rate per hour.
    """
    if not hides_rate(measure_of(key), result.duration_s):
        return 1.0, inference_of(key).noun_unit
    return result.duration_s / HOUR_S, f" in {duration_text(result.duration_s)}"


def as_shown(result: Result, evidence: pd.DataFrame) -> pd.DataFrame:
    """Convert the rates in a table of evidence to the units of `shown_as`."""
    figures = evidence["figure"].tolist()
    shown = [shown_as(key, result) if key in _BY_KEY else (1.0, "") for key in figures]
    factors = np.array([factor for factor, _ in shown])
    if (factors == 1).all():
        return evidence
    known = evidence.get("label", figures)
    labels = [
        label if factor == 1 else f"{inference_of(key).noun}{unit}"
        for key, label, (factor, unit) in zip(figures, known, shown, strict=True)
    ]
    numbers = ("x", "y", "difference", "low", "high")
    return evidence.assign(label=labels, **{name: evidence[name] * factors for name in numbers})


def difference_text(value: float, key: str) -> str:
    """Format a difference in a measure of `EVIDENCE_KEYS` with sign and unit, shares in points."""
    return difference(value, 0, evidence_form(key)) + inference_of(key).noun_unit


def size_text(value: float, key: str) -> str:
    """Format the size of a difference in a measure of `EVIDENCE_KEYS`, without its sign."""
    return difference_text(abs(value), key).removeprefix("+")
