"""Write the evaluation of estimators of detectability as one HTML file."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any, Final

import pandas as pd

from nvcore import __version__
from nvcore.common.output.files import write_whole
from nvcore.common.wording import capitalised, percent
from nvcore.notes import Note, say
from nvcore.report.html.page import render_page
from nvcore.report.section import Chart, Columns, Paragraphs, Row, Section, Table, listing
from nvcore.settings.objects import PEDESTRIAN
from nvcore.subjects.driver.estimators.training import origin_of
from nvcore.subjects.driver.evaluation import Evaluation, evaluation_tables, figures
from nvcore.subjects.driver.evaluation.estimator_report import (
    ERROR,
    ERROR_TITLES,
    basis_of_errors,
    describe_evaluated,
    learning,
)
from nvcore.subjects.driver.evaluation.tables import errors_table

TITLE: Final = "How well estimators know whom the driver sees"


def _period(otherwise: str) -> Callable[[Row], str]:
    return lambda row: otherwise if pd.isna(row["period_s"]) else f"{row['period_s']:g}"


_CHARTS: Final[dict[str, tuple[Callable[..., Any], str, str]]] = {
    "errors": (figures.estimator_errors_plot, "errors", "Errors by period."),
    "estimates": (figures.estimates_plot, "estimates", "Detectability over its estimate."),
    "periods": (figures.detectability_plot, "periods", "Mean detectability by period."),
    "histograms": (
        figures.detectability_histograms_plot,
        "histograms",
        "Histograms of detectability by period.",
    ),
    "pairs": (figures.feature_pairs_plot, "pairs", "Error and rank of every pair of features."),
    "ranks": (
        figures.pair_ranks_plot,
        "pair_ranks",
        "Rank correlations of the pairs between periods.",
    ),
}
"""Figure, its table, and description, by identifier within the page."""
_COLUMNS: Final[dict[str, Columns]] = {
    "errors": {"Period (s)": (_period("mean"), ""), "Pedestrians": ("n", "d")},
    "periods": {
        "Period (s)": (_period("mean"), ""),
        "Pedestrians": ("n", "d"),
        "Mean": ("mean", ".2f"),
        "Standard deviation": ("sd", ".2f"),
        "Seen by nobody": (lambda row: percent(row["share_zero"]), ""),
        "Seen by everybody": (lambda row: percent(row["share_one"]), ""),
    },
    "choices": {
        "Period (s)": (_period("single"), ""),
        "Features": "features",
        "Pedestrians": ("n", "d"),
        "Share": (lambda row: percent(row["share"]), ""),
    },
    "subjects": {
        "Subject": "subject",
        "Trials": ("n", "d"),
        "Right": ("share", ".2f"),
        "Expected from the others": ("share_expected", ".2f"),
        "Off time": ("n_off_time", "d"),
        "Odd": "odd",
    },
}
"""Columns of a table that the page shows."""


def write_evaluation_html(evaluation: Evaluation, path: Path) -> None:
    """Write figures and tables of an evaluation to an HTML file, replacing an existing one.

    The same trials, seed and version give the same bytes.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    page = render_page(
        "evaluation.html",
        PEDESTRIAN,
        sections=_sections(evaluation),
        title=TITLE,
        version=__version__,
        fingerprint=origin_of(evaluation.table, evaluation.search).fingerprint,
        summary=_summary(evaluation),
    )
    write_whole(path, page.encode())


def _summary(evaluation: Evaluation) -> list[str]:
    """Return sentences on the mean errors, then on the data behind them."""
    mean = errors_table(evaluation).iloc[-1][["switched", "single", "constant"]]
    return [
        say(Note("driver.mean_errors", **mean), PEDESTRIAN),
        *(f"{capitalised(text)}." for text in describe_evaluated(evaluation)),
    ]


def _sections(evaluation: Evaluation) -> list[Section]:
    tables = evaluation_tables(evaluation)
    errors = tables["errors"]
    learned = learning(errors) or [Note("driver.all_learned")]
    texts = tuple(f"{say(note, PEDESTRIAN)}." for note in learned)
    of_errors: Columns = {
        capitalised(title): (name, ERROR)
        for name, title in ERROR_TITLES.items()
        if name in errors and errors[name].notna().any()
    }

    def chart(name: str) -> Chart:
        plot, table, words = _CHARTS[name]
        return Chart(name, partial(plot, tables[table], theme="light"), words)

    def rows(
        title: str, name: str, more: Columns | None = None, notes: Sequence[str] = ()
    ) -> Table:
        return listing(title, tables[name], {**_COLUMNS[name], **(more or {})}, notes=notes)

    errors_blocks = (
        Paragraphs(texts),
        chart("errors"),
        rows("Mean squared error; 0 is best", "errors", of_errors, basis_of_errors(errors)),
        chart("estimates"),
    )
    seen = chart("periods"), chart("histograms"), rows("Detectability", "periods")
    choices = "Features that were chosen, and for how many of the pedestrians left out"
    features = rows(choices, "choices"), chart("pairs"), chart("ranks")
    subjects = (rows("How each subject responded", "subjects"),)
    title = "Error on pedestrians left out"
    return [
        Section("errors", title, Note("driver.errors_section"), errors_blocks),
        Section("seen", "What the subjects saw", Note("driver.seen_section"), seen),
        Section("features", "Which features", Note("driver.features_section"), features),
        Section("subjects", "Subjects", Note("driver.subjects_section"), subjects),
    ]
