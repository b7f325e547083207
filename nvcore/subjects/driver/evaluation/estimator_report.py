"""Text reports on trials, trainings, estimators and evaluations, and an evaluation's files."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Final

import click
import numpy as np
import pandas as pd

from nvcore.cli.models import Models
from nvcore.common.output.csv_text import to_csv_bytes
from nvcore.common.wording import MOST_NAMED, duration_text, number, one_line
from nvcore.notes import Note, phrase, say
from nvcore.settings.objects import PEDESTRIAN
from nvcore.subjects.driver.estimators.model import Estimator, Origin
from nvcore.subjects.driver.estimators.model_file import (
    SAMPLE_NAME,
    estimator_path,
    fingerprint,
    is_estimator_file,
    read_estimator,
)
from nvcore.subjects.driver.estimators.training import Training
from nvcore.subjects.driver.evaluation import PUBLISHED_NOTE, Evaluation, evaluation_tables
from nvcore.subjects.driver.evaluation.tables import TABLES, errors_table
from nvcore.subjects.driver.features import words_of
from nvcore.subjects.driver.trials import TrainingTable

SUMMARY: Final = "summary.txt"
EVALUATION_FILES: Final = (*(f"{name}.csv" for name in TABLES), SUMMARY)
"""Files that an evaluation writes into its folder."""
ERROR: Final = ".4f"
"""Number format of a mean squared error."""
ERROR_TITLES: Final = {
    "own": "estimator",
    "own_constant": "constant",
    "switched": "switched",
    "single": "single",
    "constant": "constant",
    "sampling": "few subjects",
    "published_switched": "paper, switched",
    "published_single": "paper, single",
}
"""Titles of the error columns."""


def render_table(table: TrainingTable) -> list[str]:
    """Render training data and subjects with odd responses as lines of text."""
    fewest, most = table.responses
    n_periods = len(table.periods_s)
    notes = [
        _trials(table, n_periods=n_periods),
        Note("driver.responses", fewest=fewest, most=most),
    ]
    if table.n_off_time:
        notes.append(Note("driver.off_time", n=table.n_off_time))
    if table.n_unanswered:
        notes.append(Note("driver.unanswered", n=table.n_unanswered))
    if table.n_outside and table.picture_px is not None:
        n, size_px = table.n_outside, table.picture_px
        notes.append(Note("driver.touches_outside", n=n, size_px=size_px))
    return _lines([*notes, *_subjects(table)])


def _trials(of: TrainingTable | Origin, n_periods: int | None = None) -> Note:
    """Return a note on the number of trials, subjects and pedestrians."""
    counts = {"n": of.n_trials, "n_subjects": of.n_subjects, "n_pedestrians": of.n_pedestrians}
    return Note("driver.trials", **counts, simulated=of.simulated, n_periods=n_periods)


def _subjects(table: TrainingTable) -> list[Note]:
    """Return notes on odd subjects and on those left out, led by a note if most are odd."""
    notes = [
        Note(
            "driver.subject",
            name=one_line(name),
            odd=one_line(odd),
            is_left_out=name in table.left_out,
        )
        for name, odd in table.subjects[["subject", "odd"]].to_numpy().tolist()
        if odd or name in table.left_out
    ]
    n, n_odd, more = table.n_subjects, len(table.odd_subjects), len(notes) - MOST_NAMED
    if n_odd <= max(1, n / 2):
        return notes
    rest = [Note("driver.more_subjects", n=more)] if more > 0 else []
    return [Note("driver.most_odd", n_odd=n_odd, n=n), *notes[:MOST_NAMED], *rest]


def _lines(notes: Iterable[Note]) -> list[str]:
    return [phrase(note, PEDESTRIAN) for note in notes]


def render_training(training: Training) -> str:
    """Render a training: its data, errors on pedestrians left out, and chosen features."""
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
    notes = learning(errors)
    if estimator.origin.search:
        notes.append(Note("driver.quick_search"))
    lines = [
        *render_table(training.table),
        *(say(note, PEDESTRIAN) for note in training.notes),
        *_lines(_feature_settings(estimator)),
        "mean squared error on pedestrians left out, in five folds; 0 is best:",
        *_errors(errors),
        *_choices(estimator),
        *_lines(notes),
        f"trained in {duration_text(training.seconds)}",
    ]
    return "\n".join(lines)


def render_estimator(estimator: Estimator) -> str:
    """Render an estimator's training, error and settings."""
    origin = estimator.origin
    errors = pd.DataFrame(
        {
            "period_s": [*estimator.periods_s, np.nan],
            "own": [quality.error for quality in estimator.qualities],
            "own_constant": [quality.constant_error for quality in estimator.qualities],
        }
    )
    about = [
        Note("driver.pictures_of_training", size_px=origin.picture_px),
        Note("driver.square", side_px=origin.square_px, centre_share=origin.centre_share),
        *_feature_settings(estimator),
    ]
    caution = estimator.caution()
    lines = [
        f"{one_line(estimator.name)}: estimates what the driver sees unaided "
        "(nvcore driver estimate)",
        f"fingerprint: {fingerprint(estimator)}",
        f"trained on: {phrase(_trials(origin), PEDESTRIAN)}",
        *_lines(about),
        "mean squared error on pedestrians left out, in five folds; 0 is best:",
        *_errors(errors, last="single"),
        "single: one for all periods, and one constant for all",
        *_choices(estimator),
        *_lines([Note("driver.estimates", whose="its", caution=caution)] if caution else []),
    ]
    return "\n".join(lines)


def _describe(model: str, settings: Mapping[str, str]) -> str:
    if settings:
        raise click.UsageError("--set: an estimator has no settings")
    return render_estimator(read_estimator(estimator_path(model)))


MODELS: Final = Models(
    list_all=lambda: (
        "driver: estimators of what the driver sees (.npz), as nvcore driver estimate takes them\n"
        f"  {SAMPLE_NAME:14} of a simulated observer, on the sample's drawings: not of people"
    ),
    has=lambda model: is_estimator_file(estimator_path(model)),
    describe=_describe,
)
"""Entries on estimators for ``nvcore models``."""


def _feature_settings(estimator: Estimator) -> list[Note]:
    """Return a note if it is unknown how the features were computed."""
    is_known = estimator.feature_settings is not None
    return [] if is_known else [Note("driver.unknown_feature_settings")]


def _errors(errors: pd.DataFrame, last: str = "mean") -> list[str]:
    """Render a table of errors with a row per period, without empty columns.

    `last` labels the row that has no period.
    """
    shown = [name for name in ERROR_TITLES if name in errors and errors[name].notna().any()]
    lines = ["  period   " + "  ".join(f"{ERROR_TITLES[name]:>15}" for name in shown)]
    for row in errors.to_dict("records"):
        period = f"{last:6}" if pd.isna(row["period_s"]) else f"{row['period_s']:g} s "
        cells = "  ".join(f"{number(row[name], ERROR):>15}" for name in shown)
        lines.append(f"  {period:>8} {cells}")
    return lines


def _choices(estimator: Estimator) -> list[str]:
    """Return lines with the chosen features and settings of each regression."""
    lines = ["chosen:"]
    names = [*(f"{period:g} s" for period in estimator.periods_s), "single"]
    for name, regression in zip(names, estimator.regressions, strict=True):
        note = Note(
            "driver.regression",
            features=words_of(regression.features),
            settings=regression.settings,
        )
        lines.append(f"  {name:>7}  {phrase(note, PEDESTRIAN)}")
    return lines


def learning(errors: pd.DataFrame) -> list[Note]:
    """Return notes on periods at which an estimator is no better than a constant.

    Parameters
    ----------
    errors
        ``period_s``, ``switched``, ``single`` and ``constant``; the last row is the mean.
    """
    rows, mean = errors[errors["period_s"].notna()], errors.iloc[-1]
    useless_s, worse_s = (
        [f"{period_s:g}" for period_s in rows.loc[is_in, "period_s"]]
        for is_in in (rows["switched"] >= rows["constant"], rows["single"] > rows["constant"])
    )
    notes = [Note("driver.nothing_learned", periods_s=useless_s)] if useless_s else []
    if mean["switched"] >= mean["constant"]:
        notes.append(Note("driver.of_no_use", error=mean["switched"], constant=mean["constant"]))
    return notes + ([Note("driver.worse_single", periods_s=worse_s)] if worse_s else [])


def describe_evaluated(evaluation: Evaluation) -> list[str]:
    """Describe an evaluation's data and odd subjects, and note a quick search for settings."""
    search = evaluation.search
    quick = [Note("driver.searched", n=search.n_settings)] if search.is_quick else []
    return [
        *render_table(evaluation.table),
        *(say(note, PEDESTRIAN) for note in evaluation.samples.notes),
        *_lines(quick),
    ]


def render_evaluation(evaluation: Evaluation) -> str:
    """Render an evaluation: its data, and errors at each period beside those of the paper."""
    errors = errors_table(evaluation)
    lines = [
        *describe_evaluated(evaluation),
        "mean squared error, leaving out one pedestrian at a time; 0 is best:",
        *_errors(errors),
        *_lines(learning(errors)),
        *basis_of_errors(errors),
        f"evaluated in {duration_text(evaluation.seconds)}",
    ]
    return "\n".join(lines)


def basis_of_errors(errors: pd.DataFrame) -> list[str]:
    """Return sentences that explain the error due to few subjects and the errors of the paper."""
    has_sampling = errors["sampling"].notna().any()
    notes = [Note("driver.few_subjects")] if has_sampling else []
    return [*(say(note, PEDESTRIAN) for note in notes), PUBLISHED_NOTE]


def evaluation_files(evaluation: Evaluation) -> Iterator[tuple[str, bytes]]:
    """Yield the name and content of each of `EVALUATION_FILES`."""
    for name, table in evaluation_tables(evaluation).items():
        yield f"{name}.csv", to_csv_bytes(table)
    # without the duration, so that equal data give equal files
    text = render_evaluation(evaluation).rpartition("\n")[0]
    yield SUMMARY, f"{text}\n".encode()
