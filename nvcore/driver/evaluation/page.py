"""Write the evaluation of estimators of detectability as one HTML file."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
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
from nvcore.report.html.page import render_page
from nvcore.report.section import Chart, Columns, Paragraphs, Row, Section, listing
from nvcore.wording import capitalised, percent

TITLE: Final = "How well estimators know whom the driver sees"
_ERROR_TITLES: Final = {
    "switched": "Switched",
    "single": "Single",
    "constant": "Constant",
    "sampling": "Few subjects",
    "published_switched": "Paper, switched",
    "published_single": "Paper, single",
}
"""Columns of errors, with their titles."""


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
    mean = errors_table(evaluation).iloc[-1]
    of = {name: mean[name] for name in ("switched", "single", "constant")}
    return [
        say(Note("driver.mean_errors", **of), PEDESTRIAN),
        *(f"{capitalised(text)}." for text in describe_evaluated(evaluation)),
    ]


def _sections(evaluation: Evaluation) -> list[Section]:
    tables = evaluation_tables(evaluation)
    errors = tables["errors"]
    learned = learning(errors) or [Note("driver.all_learned")]
    texts = tuple(f"{say(note, PEDESTRIAN)}." for note in learned)
    n: tuple[str, str] = ("n", "d")
    of_errors: Columns = {
        "Period (s)": (_period("mean"), ""),
        "Pedestrians": n,
        **{of: (name, ERROR) for name, of in _ERROR_TITLES.items() if errors[name].notna().any()},
    }
    of_periods: Columns = {
        "Period (s)": (_period("mean"), ""),
        "Pedestrians": n,
        "Mean": ("mean", ".2f"),
        "Standard deviation": ("sd", ".2f"),
        "Seen by nobody": (lambda row: percent(row["share_zero"]), ""),
        "Seen by everybody": (lambda row: percent(row["share_one"]), ""),
    }
    of_choices: Columns = {
        "Period (s)": (_period("single"), ""),
        "Features": "features",
        "Pedestrians": n,
        "Share": (lambda row: percent(row["share"]), ""),
    }
    of_subjects: Columns = {
        "Subject": "subject",
        "Trials": n,
        "Right": ("share", ".2f"),
        "Expected from the others": ("share_expected", ".2f"),
        "Off time": ("n_off_time", "d"),
        "Odd": "odd",
    }
    chosen = "Features that were chosen, and for how many of the pedestrians left out"
    return [
        Section(
            "errors",
            "Error on pedestrians left out",
            Note("driver.errors_section"),
            (
                Paragraphs(texts),
                _chart("errors", estimator_errors_plot, errors, "Errors by period."),
                listing(
                    "Mean squared error; 0 is best",
                    errors,
                    of_errors,
                    notes=basis_of_errors(errors),
                ),
                _chart(
                    "estimates",
                    estimates_plot,
                    tables["estimates"],
                    "Detectability over its estimate.",
                ),
            ),
        ),
        Section(
            "seen",
            "What the subjects saw",
            Note("driver.seen_section"),
            (
                _chart(
                    "periods",
                    detectability_plot,
                    tables["periods"],
                    "Mean detectability by period.",
                ),
                _chart(
                    "histograms",
                    detectability_histograms_plot,
                    tables["histograms"],
                    "Histograms of detectability by period.",
                ),
                listing("Detectability", tables["periods"], of_periods),
            ),
        ),
        Section(
            "features",
            "Which features",
            Note("driver.features_section"),
            (
                listing(chosen, tables["choices"], of_choices),
                _chart(
                    "pairs",
                    feature_pairs_plot,
                    tables["pairs"],
                    "Error and rank of every pair of features.",
                ),
                _chart(
                    "ranks",
                    pair_ranks_plot,
                    tables["pair_ranks"],
                    "Rank correlations of the pairs between periods.",
                ),
            ),
        ),
        Section(
            "subjects",
            "Subjects",
            Note("driver.subjects_section"),
            (listing("How each subject responded", tables["subjects"], of_subjects),),
        ),
    ]


def _chart(name: str, plot: Callable[..., Any], table: pd.DataFrame, words: str) -> Chart:
    return Chart(name, partial(plot, table, theme="light"), words)


def _period(otherwise: str) -> Callable[[Row], str]:
    return lambda row: otherwise if pd.isna(row["period_s"]) else f"{row['period_s']:g}"
