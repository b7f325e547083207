"""Headings, formats and help texts of the tables that the pages show."""

from __future__ import annotations

import pandas as pd
import pytest

from nvcore.tables.columns import report_columns
from ui.widgets.table_columns import as_shown, columns_of, heading, rows_told


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("recording", "Recording"),
        ("lag_s_x", "X lag (s)"),
        ("miss_class_y", "Y miss class"),
        ("lead_time_s", "Lead of X (s)"),
        ("first_frame", "First frame"),
        ("driver_frame", "Driver sees in frame"),
    ],
)
def test_headings_are_words(name: str, words: str):
    assert heading(name) == words


@pytest.mark.parametrize("file", ["encounters.csv", "events.csv"])
def test_every_column_has_its_own_heading_and_a_help_text(file: str):
    columns = columns_of(file)
    assert list(columns) == [column.name for column in report_columns()[file]]
    labels = [column.label for column in columns.values()]
    assert len(set(labels)) == len(labels)
    assert not [label for label in labels if "_" in label]
    assert all(column.help for column in columns.values())


def test_a_help_text_says_which_way_is_better_and_when_a_cell_is_empty():
    text = columns_of("encounters.csv")["lag_s_x"].help
    assert "Lower is better" in text
    assert "Empty: too far to count, or matched in no frame that counts" in text


def test_shares_are_shown_in_percent_and_classes_in_words():
    table = pd.DataFrame(
        {
            "category": ["x_only", "distant"],
            "coverage_x": [0.25, float("nan")],
            "miss_class_y": ["lost_early", None],
            "lag_s_x": [0.5, 0.5],
        }
    )
    shown = as_shown(table)
    assert shown["category"].tolist() == ["only X", "distant"]
    assert shown["miss_class_y"].iloc[0] == "lost early"
    assert shown["miss_class_y"].isna().tolist() == [False, True]
    assert shown["lag_s_x"].tolist() == [0.5, 0.5]
    assert columns_of("encounters.csv", "coverage_x")["coverage_x"].form == ".0%"


def test_truth_values_are_said_in_words_and_what_is_not_known_stays_empty():
    values = pd.array([True, False, None], dtype="boolean")
    shown = as_shown(pd.DataFrame({"within_sd": values, "detected_x": [True, False, True]}))
    assert shown["within_sd"].tolist()[:2] == ["yes", "no"]
    assert shown["within_sd"].isna().tolist() == [False, False, True]
    assert shown["detected_x"].tolist() == ["yes", "no", "yes"]


def test_a_table_that_is_cut_short_says_so():
    assert rows_told(5000, "first") == ""
    told = rows_told(12345, "most salient")
    assert told == "The most salient 5,000 of 12,345 are listed; Export has them all."
