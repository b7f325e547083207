"""Ratings that are typed in on the Ratings page."""

from __future__ import annotations

import pandas as pd
import pytest
from ratings_page import metrics, opened, show_source, warnings, words
from streamlit.testing.v1 import AppTest

from pages import checked
from ui.subjects.ratings import source, typed


class Editor:
    """In place of the table: gives back what was typed, else what it was given."""

    def __init__(self) -> None:
        self.typed: pd.DataFrame | None = None
        self.shown = pd.DataFrame()
        self.key = ""

    def __call__(self, shown: pd.DataFrame, *, key: str, **_: object) -> pd.DataFrame:
        if self.key not in ("", key):  # a table of its own, in which nothing is typed
            self.typed = None
        self.shown, self.key = shown, key
        return shown if self.typed is None else self.typed


@pytest.fixture
def editor(monkeypatch: pytest.MonkeyPatch) -> Editor:
    made = Editor()
    monkeypatch.setattr(typed.st, "data_editor", made)
    return made


def opened_typed() -> AppTest:
    return show_source(opened(), source.TYPED)


def rows(*of: tuple[str | None, str | None, str | None, float | None]) -> pd.DataFrame:
    return pd.DataFrame(of, columns=list(typed.COLUMNS))


def add_rows(page: AppTest, name: str) -> AppTest:
    page.text_input(key="ratings_typed_name").set_value(name)
    return checked(
        next(button for button in page.button if "Add a row" in button.label).click().run()
    )


def test_ratings_typed_in_are_checked(editor: Editor):
    editor.typed = rows(
        ("A", "odd_pose", "FIR", 1.0), ("A", "odd_pose", "FIR", 2.0), (None, None, None, None)
    )
    page = opened_typed()
    assert "line 2: A rates the clip odd_pose with the boxes of FIR a second time" in words(page)
    editor.typed.loc[1, "clip"] = "rural_road"
    assert metrics(checked(page.run()))["clips"] == "2"


def test_a_participant_gets_a_row_for_each_clip_and_no_second_one(editor: Editor):
    page = opened_typed()
    assert len(editor.shown) == 0
    assert "download" not in words(page)  # there is nothing to download
    add_rows(page, "Anna")
    assert len(editor.shown) == 20
    assert editor.shown["participant"].unique().tolist() == ["Anna"]
    assert not editor.shown.duplicated(["clip", "system"]).any()
    assert editor.shown["rating"].isna().all()
    assert "There is no rating yet" in words(page)
    editor.typed = editor.shown.drop(index=3).assign(rating=2.0)
    checked(page.run())
    assert "download it under" in words(page)
    add_rows(page, "anna ")
    assert len(editor.shown) == 20
    assert editor.shown["participant"].unique().tolist() == ["Anna"]
    assert editor.shown["rating"].notna().sum() == 19
    add_rows(page, "ANNA")
    assert "Anna has a row for each clip already" in words(page)


def test_incomplete_rows_are_told_and_left_out(editor: Editor):
    editor.typed = rows(
        ("A", "odd_pose", "FIR", 1.0), (None, "rural_road", "FIR", 2.0), (None, None, None, None),
        ("A", None, None, 3.0), ("A", "rural_road", "NIR", None),
    )  # fmt: skip
    page = opened_typed()
    assert (
        "2 incomplete rows left out: row 2 (no participant), row 4 (no clip, whose boxes?)."
        in warnings(page)
    )
    assert "1 row without a rating yet" in words(page)
    assert metrics(page)["clips"] == "1"
