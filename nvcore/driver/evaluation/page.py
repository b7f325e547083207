"""The evaluation of estimators of what the driver sees as one HTML file."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from pathlib import Path
from typing import Any, Final

import pandas as pd

from nvcore import __version__
from nvcore.driver.estimator_report import (
    ERROR,
    basis_of_errors,
    describe_evaluated,
    learning,
)
from nvcore.driver.estimators.training import origin_of
from nvcore.driver.evaluation import Evaluation, evaluation_tables
from nvcore.driver.evaluation.figures import (
    detectability_histograms_plot,
    detectability_plot,
    estimates_plot,
    estimator_errors_plot,
    feature_pairs_plot,
    pair_ranks_plot,
)
from nvcore.driver.evaluation.tables import errors_table
from nvcore.notes import Note, say
from nvcore.objects import PEDESTRIAN
from nvcore.output.files import write_whole
from nvcore.report.html.blocks import Chart, Intro, Section, Sentences, Table, table
from nvcore.report.html.page import render_page
from nvcore.wording import capitalised, number, percent

TITLE: Final = "How well estimators know whom the driver sees"
MEAN: Final = "mean"
SINGLE: Final = "single"
_ERROR_TITLES: Final = {
    "switched": "Switched",
    "single": "Single",
    "constant": "Constant",
    "sampling": "Few subjects",
    "published_switched": "Paper, switched",
    "published_single": "Paper, single",
}
"""Columns of errors, with their titles."""
ERRORS: Final = Intro(
    what="How far estimates are from the share of the subjects who saw the pedestrian: the mean of "
    "the squared differences.",
    how="Every pedestrian is estimated by regressions that were chosen and trained without him. "
    "Switched: the regression of the adaptation period, the time since it became dark. Single: one "
    "for all periods, which does not know the period. Constant: the mean of the other pedestrians' "
    "detectability at that period, without any picture.",
    best="0; an error at or above the constant's means that nothing was learned.",
    limits="It says nothing of other cameras, roads or people than those of the trials.",
)
SEEN: Final = Intro(
    what="Detectability is the share of the subjects who found the pedestrian that long after it "
    "became dark: 0 nobody, 1 everybody.",
)
FEATURES: Final = Intro(
    what="Which features of the pedestrian in the picture the estimators were chosen to look at.",
    how="The choice is made anew without each pedestrian. The ranking of the pairs is of their own "
    "errors: read it as a ranking; what an honest choice is worth is the error of switched, above.",
)
SUBJECTS: Final = Intro(
    what="Who responded, and whose responses are unlike those of the others. Nobody is left out "
    "for being odd.",
)
_Row = Mapping[Hashable, Any]


def write_evaluation_html(evaluation: Evaluation, path: Path) -> None:
    """Write figures and tables of an evaluation; an existing file is replaced.

    The same trials, seed and version give the same bytes.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    page = render_page(
        "evaluation.html",
        sections=_sections(evaluation),
        title=TITLE,
        version=__version__,
        fingerprint=origin_of(evaluation.table, evaluation.search).fingerprint,
        summary=_summary(evaluation),
    )
    write_whole(path, page.encode())


def _summary(evaluation: Evaluation) -> list[str]:
    """What came out, then what it rests on."""
    mean = errors_table(evaluation).iloc[-1]
    of = {name: mean[name] for name in ("switched", "single", "constant")}
    return [
        say(Note("driver.mean_errors", **of), PEDESTRIAN),
        *(f"{capitalised(text)}." for text in describe_evaluated(evaluation)),
    ]


def _sections(evaluation: Evaluation) -> list[Section]:
    tables = evaluation_tables(evaluation)
    errors, pairs = tables["errors"], tables["pairs"]
    return [
        Section(
            "errors",
            "Error on pedestrians left out",
            ERRORS,
            (
                Sentences(_learned(errors)),
                Chart("errors", estimator_errors_plot(errors, theme="light"), "Errors by period."),
                _errors(errors),
                Chart(
                    "estimates",
                    estimates_plot(tables["estimates"], theme="light"),
                    "Detectability over its estimate.",
                ),
            ),
        ),
        Section(
            "seen",
            "What the subjects saw",
            SEEN,
            (
                Chart(
                    "periods",
                    detectability_plot(tables["periods"], theme="light"),
                    "Mean detectability by period.",
                ),
                Chart(
                    "histograms",
                    detectability_histograms_plot(tables["histograms"], theme="light"),
                    "Histograms of detectability by period.",
                ),
                _periods(tables["periods"]),
            ),
        ),
        Section(
            "features",
            "Which features",
            FEATURES,
            (
                _choices(tables["choices"]),
                Chart(
                    "pairs",
                    feature_pairs_plot(pairs, theme="light"),
                    "Error and rank of every pair of features.",
                ),
                Chart(
                    "ranks",
                    pair_ranks_plot(tables["pair_ranks"], theme="light"),
                    "Rank correlations of the pairs between periods.",
                ),
            ),
        ),
        Section("subjects", "Subjects", SUBJECTS, (_subjects(tables["subjects"]),)),
    ]


def _learned(errors: pd.DataFrame) -> tuple[str, ...]:
    """Where nothing was learned, or that something was everywhere."""
    notes = learning(errors) or [Note("driver.all_learned")]
    return tuple(f"{say(note, PEDESTRIAN)}." for note in notes)


def _errors(errors: pd.DataFrame) -> Table:
    shown = [name for name in _ERROR_TITLES if errors[name].notna().any()]
    return _table(
        "Mean squared error; 0 is best",
        errors,
        {
            "Period (s)": lambda row: _period(row["period_s"], MEAN),
            "Pedestrians": lambda row: f"{row['n']:,}",
            **{_ERROR_TITLES[name]: _number_of(name, ERROR) for name in shown},
        },
        note=" ".join(basis_of_errors(errors)),
    )


def _periods(periods: pd.DataFrame) -> Table:
    return _table(
        "Detectability",
        periods,
        {
            "Period (s)": lambda row: _period(row["period_s"], MEAN),
            "Pedestrians": lambda row: f"{row['n']:,}",
            "Mean": _number_of("mean", ".2f"),
            "Standard deviation": _number_of("sd", ".2f"),
            "Seen by nobody": lambda row: percent(row["share_zero"]),
            "Seen by everybody": lambda row: percent(row["share_one"]),
        },
    )


def _choices(choices: pd.DataFrame) -> Table:
    return _table(
        "Features that were chosen, and for how many of the pedestrians left out",
        choices,
        {
            "Period (s)": lambda row: _period(row["period_s"], SINGLE),
            "Features": lambda row: str(row["features"]),
            "Pedestrians": lambda row: f"{row['n']:,}",
            "Share": lambda row: percent(row["share"]),
        },
        texts=(1,),
    )


def _subjects(subjects: pd.DataFrame) -> Table:
    return _table(
        "How each subject responded",
        subjects,
        {
            "Subject": lambda row: str(row["subject"]),
            "Trials": lambda row: f"{row['n']:,}",
            "Right": _number_of("share", ".2f"),
            "Expected from the others": _number_of("share_expected", ".2f"),
            "Off time": lambda row: f"{row['n_off_time']:,}",
            "Odd": lambda row: str(row["odd"]),
        },
        texts=(0, 5),
    )


def _table(
    title: str,
    rows: pd.DataFrame,
    columns: Mapping[str, Callable[[_Row], str]],
    *,
    texts: tuple[int, ...] = (),
    note: str = "",
) -> Table:
    """A table with a column for each function; numbers, but for the columns of `texts`."""
    cells = [[cell(row) for cell in columns.values()] for row in rows.to_dict("records")]
    right = [column for column in range(len(columns)) if column not in texts]
    return table(title, tuple(columns), cells, right=right, note=note)


def _number_of(column: str, form: str) -> Callable[[_Row], str]:
    return lambda row: number(row[column], form)


def _period(period_s: float, otherwise: str) -> str:
    return otherwise if pd.isna(period_s) else f"{period_s:g}"
