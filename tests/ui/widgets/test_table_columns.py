"""Headings, formats and help texts of the tables that the pages show."""

from __future__ import annotations

import tomllib

import pandas as pd
import pytest
from places import ROOT

from nvcore.palette import rgb
from nvcore.tables.columns import report_columns
from ui.widgets.table_columns import as_shown, column_config, heading, rows_told, table_height


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
    config = column_config(file)
    assert list(config) == [column.name for column in report_columns()[file]]
    labels = [one["label"] for one in config.values()]
    assert len(set(labels)) == len(labels)
    assert not [label for label in labels if "_" in label]
    assert all(one["help"] for one in config.values())


def test_a_help_text_says_which_way_is_better_and_when_a_cell_is_empty():
    text = column_config("encounters.csv")["lag_s_x"]["help"]
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
    assert shown["coverage_x"].iloc[0] == 25
    assert shown["miss_class_y"].iloc[0] == "lost early"
    assert shown["miss_class_y"].isna().tolist() == [False, True]
    assert shown["lag_s_x"].tolist() == [0.5, 0.5]
    assert table["coverage_x"].iloc[0] == 0.25


def test_truth_values_are_said_in_words_and_what_is_not_known_stays_empty():
    values = pd.array([True, False, None], dtype="boolean")
    shown = as_shown(pd.DataFrame({"within_sd": values, "detected_x": [True, False, True]}))
    assert shown["within_sd"].tolist()[:2] == ["yes", "no"]
    assert shown["within_sd"].isna().tolist() == [False, False, True]
    assert shown["detected_x"].tolist() == ["yes", "no", "yes"]
    assert column_config("encounters.csv")["within_sd"]["type_config"]["type"] == "text"


def test_a_table_grows_up_to_ten_rows():
    assert table_height(0) == table_height(1) < table_height(10) == table_height(5000)


def test_no_row_of_a_table_is_cut_in_two():
    """Streamlit's rows, and its heading, are 2.1875 rem high, in whole pixels."""
    theme = tomllib.loads((ROOT / ".streamlit" / "config.toml").read_text("utf-8"))["theme"]
    row_px = round(2.1875 * theme["baseFontSize"])
    assert [table_height(n) - 2 for n in (1, 3, 10, 12)] == [n * row_px for n in (2, 4, 11, 11)]


def test_a_table_that_is_cut_short_says_so():
    assert rows_told(5000, "first") == ""
    told = rows_told(12345, "most salient")
    assert told == "The most salient 5,000 of 12,345 are listed; Export has them all."


def luminance(colour: list[float]) -> float:
    linear = [
        part / 12.92 if part <= 0.03928 else ((part + 0.055) / 1.055) ** 2.4
        for part in (channel / 255 for channel in colour)
    ]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


@pytest.mark.parametrize("shade", ["light", "dark"])
def test_the_first_columns_of_tables_can_be_read(shade: str):
    """Streamlit draws pinned columns with 60 % of the text's colour; WCAG 2.2 asks for 4.5."""
    theme = tomllib.loads((ROOT / ".streamlit" / "config.toml").read_text("utf-8"))["theme"][shade]
    text, ground = rgb(theme["textColor"]), rgb(theme["backgroundColor"])
    faded = [0.6 * one + 0.4 * other for one, other in zip(text, ground, strict=True)]
    light, dark = sorted((luminance(faded), luminance([*ground])), reverse=True)
    assert (light + 0.05) / (dark + 0.05) >= 4.5
