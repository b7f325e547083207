"""Groups on the Ratings page, which need neither ratings nor a comparison."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest
from ratings_page import words

from pages import alone, begin_with, checked, part, rows, tables, write
from ui.session.store import RATINGS_PART
from ui.subjects.ratings import groups

MEANS = "condition,n,mean,sd\nvisual,11,1678,755.1\naudio,11,2171,766.2\nhaptic,11,1245,389.5\n"
"""Reaction times of docs/groups.md."""


def test_groups_of_a_file_are_compared_as_the_command_does():
    page = checked(part("ui.subjects.ratings.groups.draw()").run())
    assert not page.subheader
    sent = ("means.csv", MEANS.encode(), "text/csv")
    checked(page.file_uploader(key="groups_file").set_value(sent).run())
    assert "Welch's ANOVA and Games–Howell comparisons fit, because they do not" in words(page)
    assert "audio is 926 above haptic (p = 0.0075)" in words(page)
    assert [heading.value for heading in page.subheader] == [*groups.HEADINGS.values()]
    tests = tables(page)[1]
    assert tests["c0"].tolist() == ["one-way ANOVA", "★ Welch's ANOVA"]
    assert tests["c1"].tolist() == ["F = 5.412", "F = 6.607"]
    checked(page.number_input(key="groups_difference").set_value(500.0).run())
    assert "500" in words(page)
    sent = ("means.csv", MEANS.replace("755.1", "wide").encode(), "text/csv")
    checked(page.file_uploader(key="groups_file").set_value(sent).run())
    assert "means.csv, line 2: sd: expected a number, found 'wide'" in words(page)


def test_values_typed_in_are_compared_without_a_comparison_of_systems(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    begin_with(write(tmp_path, {"one": ""}, truth=rows(300)), monkeypatch)
    typed = pd.DataFrame(
        {
            "participant": None,
            "condition": ["a"] * 3 + ["b"] * 3 + [None],
            "value": [1.5, 2.5, 3.5, 7, 8, 9, None],
        }
    )
    monkeypatch.setattr(groups.st, "data_editor", lambda *_, **__: typed)
    page = alone("ratings")
    page.session_state[RATINGS_PART.key] = "groups"
    checked(page.run())
    checked(page.button_group(key="groups_source").set_value(groups.VALUES).run())
    assert "A comparison needs two" not in words(page)
    assert "6 values of value in 2 conditions, treated as numbers" in words(page)
    assert tables(page)[0]["c0"].tolist() == ["a", "b"]
