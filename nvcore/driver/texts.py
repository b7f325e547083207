"""Estimators of what the driver sees in words, and the files of their evaluation."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np
import pandas as pd

from nvcore.driver.estimators.model import Estimator, Origin
from nvcore.driver.estimators.model_file import SAMPLE_NAME, fingerprint
from nvcore.driver.estimators.training import Training
from nvcore.driver.estimators.words import caution_of, words_of
from nvcore.driver.evaluation import PUBLISHED_NOTE, Evaluation, evaluation_tables
from nvcore.driver.evaluation.tables import errors_table
from nvcore.driver.trials import TrainingTable
from nvcore.output.csv_text import to_csv_bytes
from nvcore.wording import (
    MOST_NAMED,
    capitalised,
    count_text,
    duration_text,
    number,
    one_line,
    percent,
)

TABLES: Final = (
    *("errors", "choices", "pairs", "pair_ranks"),
    *("periods", "histograms", "estimates", "subjects"),
)
"""Names of the tables of an evaluation."""
SUMMARY: Final = "summary.txt"
EVALUATION_FILES: Final = (*(f"{name}.csv" for name in TABLES), SUMMARY)
"""What an evaluation writes into its folder."""
SAMPLING_NOTE: Final = (
    "Few subjects: what even the true probabilities would err by, since these subjects stand for "
    "all. No estimator can do better."
)
ERROR: Final = ".4f"
"""Format of a mean squared error."""
_OF_TRIALS: Final = {
    "no": "",
    "all": " by a simulated observer, not by people",
    "some": ", some by a simulated observer",
}


def render_table(table: TrainingTable) -> list[str]:
    """What there is to learn from, and whose responses are odd."""
    lines = [
        f"{count_text(table.n_trials, 'trial')}{_OF_TRIALS[table.simulated]}: "
        f"{count_text(table.n_subjects, 'subject')}, "
        f"{count_text(table.n_pedestrians, 'pedestrian')}, "
        f"{count_text(len(table.periods_s), 'adaptation period')}",
        _responses(table),
    ]
    if table.n_off_time:
        lines.append(
            f"{count_text(table.n_off_time, 'trial')} came more than 50 ms early or late; they "
            "count as any other"
        )
    if table.n_unanswered:
        lines.append(
            f"{count_text(table.n_unanswered, 'trial')} without an answer in time: learned from as "
            "not seen"
        )
    if table.n_outside and table.picture_px is not None:
        width, height = table.picture_px
        lines.append(
            f"{count_text(table.n_outside, 'touch', 'touches')} outside the picture of {width:,} x "
            f"{height:,} px: are touch_x and touch_y in its pixels?"
        )
    return [*lines, *_subjects(table)]


def _subjects(table: TrainingTable) -> list[str]:
    """Who is left out, and whose responses are odd; where most are, that before a few of them."""
    rows = table.subjects[["subject", "odd"]].to_numpy().tolist()
    lines = [
        one_line(_subject(name, odd, is_left_out=name in table.left_out))
        for name, odd in rows
        if odd or name in table.left_out
    ]
    n_odd = len(table.odd_subjects)
    if n_odd <= max(1, table.n_subjects / 2):
        return lines
    head = (
        f"{n_odd:,} of {count_text(table.n_subjects, 'subject')} are odd: rather the data are "
        "wrong than the people. Are touch_x and touch_y in pixels of the picture, the boxes "
        "those of these pictures, and the square large enough?"
    )
    more = len(lines) - MOST_NAMED
    return [head, *lines[:MOST_NAMED], *([f"and {more:,} more (subjects.csv)"] if more > 0 else [])]


def _responses(table: TrainingTable) -> str:
    """How many responses a detectability is the share of."""
    fewest, most = table.responses
    if most == 1:
        return (
            "1 response to each pedestrian at a period: detectability is 0 or 1 everywhere, and "
            "the scatter of single answers is in every error"
        )
    n = f"{fewest:,} to {most:,}" if fewest < most else f"{most:,}"
    return f"{n} responses to each pedestrian at a period"


def _subject(name: str, odd: str, *, is_left_out: bool) -> str:
    """A subject who is odd, or whose responses are not used."""
    if is_left_out:
        return f"subject {name} is left out" + (f": {odd}" if odd else "")
    return f"subject {name} is odd: {odd}. The responses count all the same"


def render_training(training: Training) -> str:
    """What was learned from what, and how well it does on pedestrians left out."""
    estimator = training.estimator
    errors = pd.DataFrame(
        {
            "period_s": estimator.periods_s,
            "switched": training.switched_errors,
            "single": training.single_errors,
            "constant": training.constant_errors,
        }
    )
    mean = {name: errors[name].mean() for name in ("switched", "single", "constant")}
    errors = pd.concat([errors, pd.DataFrame([mean])], ignore_index=True)
    lines = [
        *render_table(training.table),
        *map(capitalised, training.notes),
        *_feature_settings(estimator),
        "mean squared error on pedestrians left out, in five folds; 0 is best:",
        *_errors(errors),
        *_choices(estimator),
        *describe_learning(errors),
        *(
            ["features and settings were chosen by a quick search"]
            if estimator.origin.search
            else []
        ),
        f"trained in {duration_text(training.seconds)}",
    ]
    return "\n".join(lines)


def render_estimator(estimator: Estimator) -> str:
    """What an estimator is: what it was trained on, how well it does, and what it takes."""
    origin = estimator.origin
    errors = pd.DataFrame(
        {
            "period_s": [*estimator.periods_s, np.nan],
            "own": [quality.error for quality in estimator.qualities],
            "own_constant": [quality.constant_error for quality in estimator.qualities],
        }
    )
    caution = caution_of(estimator)
    lines = [
        f"{one_line(estimator.name)}: estimates what the driver sees by himself "
        "(nvcore driver estimate)",
        f"fingerprint: {fingerprint(estimator)}",
        f"trained on: {count_text(origin.n_trials, 'trial')}{_OF_TRIALS[origin.simulated]}: "
        f"{count_text(origin.n_subjects, 'subject')}, "
        f"{count_text(origin.n_pedestrians, 'pedestrian')}",
        _pictures(origin),
        f"a response is right within a square of {origin.square_px:g} px that overlaps the "
        f"pedestrian's middle ({percent(origin.centre_share)} of his box)",
        *_feature_settings(estimator),
        "mean squared error on pedestrians left out, in five folds; 0 is best:",
        *_errors(errors, last="single"),
        "single: one for all periods, and one constant for all",
        *_choices(estimator),
        *([f"its estimates are {caution}"] if caution else []),
    ]
    return "\n".join(lines)


def _pictures(origin: Origin) -> str:
    if origin.picture_px is None:
        return "of pictures whose size is not known, or not the same in all"
    width, height = origin.picture_px
    return f"of pictures of {width:,} x {height:,} px: estimates are for such ones"


def render_estimators() -> str:
    """The estimators that ship."""
    return (
        "driver: estimators of what the driver sees (.npz), as nvcore driver estimate takes them\n"
        f"  {SAMPLE_NAME:14} of a simulated observer, on the sample's drawings: not of people"
    )


def _feature_settings(estimator: Estimator) -> list[str]:
    """What is to be said where nobody knows how the features were computed."""
    if estimator.feature_settings is not None:
        return []
    return [
        "the settings of the features are not known: no record of nvcore driver features lies "
        "beside their file"
    ]


def _errors(errors: pd.DataFrame, last: str = "mean") -> list[str]:
    """A line for each period, that without one last; columns that are all empty are left out."""
    titles = {
        "own": "estimator",
        "own_constant": "constant",
        "switched": "switched",
        "single": "single",
        "constant": "constant",
        "sampling": "few subjects",
        "published_switched": "paper, switched",
        "published_single": "paper, single",
    }
    shown = [name for name in titles if name in errors and errors[name].notna().any()]
    lines = ["  period   " + "  ".join(f"{titles[name]:>15}" for name in shown)]
    for row in errors.to_dict("records"):
        period = f"{last:6}" if pd.isna(row["period_s"]) else f"{row['period_s']:g} s "
        cells = "  ".join(f"{number(row[name], ERROR):>15}" for name in shown)
        lines.append(f"  {period:>8} {cells}")
    return lines


def _choices(estimator: Estimator) -> list[str]:
    """Features and settings of each regression."""
    lines = ["chosen:"]
    names = [*(f"{period:g} s" for period in estimator.periods_s), "single"]
    for name, regression in zip(names, estimator.regressions, strict=True):
        s = regression.settings
        gamma = f", gamma {s.gamma:.2g}" if s.kernel == "rbf" else ""
        lines.append(
            f"  {name:>7}  {words_of(regression.features)} ({s.kernel}, C {s.cost:.2g}, "
            f"epsilon {s.epsilon:.2g}{gamma})"
        )
    return lines


def describe_learning(errors: pd.DataFrame) -> list[str]:
    """Where nothing was learned: the constant does as well, or better.

    Parameters
    ----------
    errors
        ``period_s``, ``switched``, ``single`` and ``constant``; the last row is the mean.
    """
    of_periods = errors[errors["period_s"].notna()]
    constant = of_periods["constant"]
    lines = []
    if (is_useless := of_periods["switched"] >= constant).any():
        lines.append(
            f"at {_periods(of_periods[is_useless])} the estimator is no better than the mean of "
            "the others' detectability: it has learned nothing there"
        )
    mean = errors.iloc[-1]
    if mean["switched"] >= mean["constant"]:
        lines.append(
            f"over all periods, too: {number(mean['switched'], ERROR)} on average against "
            f"{number(mean['constant'], ERROR)}; as a whole it is of no use"
        )
    if (is_worse := of_periods["single"] > constant).any():
        lines.append(
            f"at {_periods(of_periods[is_worse])} the single estimator, which does not know the "
            "period, is worse than the mean of the others' detectability at that period"
        )
    return lines


def _periods(errors: pd.DataFrame) -> str:
    return ", ".join(f"{period:g}" for period in errors["period_s"]) + " s"


def describe_evaluated(evaluation: Evaluation) -> list[str]:
    """What was evaluated on, whose responses are odd, and how features and settings were chosen."""
    search = evaluation.search
    quick = f"by a quick search of {count_text(search.n_settings, 'setting')}"
    return [
        *render_table(evaluation.table),
        *map(capitalised, evaluation.samples.notes),
        *([quick] if search.is_quick else []),
    ]


def render_evaluation(evaluation: Evaluation) -> str:
    """Errors at each period beside those of the paper, and what differs."""
    errors = errors_table(evaluation)
    lines = [
        *describe_evaluated(evaluation),
        "mean squared error, leaving out one pedestrian at a time; 0 is best:",
        *_errors(errors),
        *describe_learning(errors),
        *([SAMPLING_NOTE] if errors["sampling"].notna().any() else []),
        PUBLISHED_NOTE,
        f"evaluated in {duration_text(evaluation.seconds)}",
    ]
    return "\n".join(lines)


def evaluation_files(evaluation: Evaluation) -> Iterator[tuple[str, bytes]]:
    """Names and contents of `EVALUATION_FILES`."""
    for name, table in evaluation_tables(evaluation).items():
        yield f"{name}.csv", to_csv_bytes(table)
    # without the duration, so that equal data give equal files
    text = render_evaluation(evaluation).rpartition("\n")[0]
    yield SUMMARY, f"{text}\n".encode()
