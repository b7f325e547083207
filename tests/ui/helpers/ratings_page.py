"""The Ratings page for its tests: opened, and read."""

from __future__ import annotations

import pandas as pd
from places import ROOT
from streamlit.testing.v1 import AppTest

from pages import checked, part, tables, texts
from ui.subjects.ratings import source

SIMULATED = ROOT / "sample_data" / "ratings_simulated.csv"


def opened(**address: str) -> AppTest:
    """The results."""
    return checked(part("ui.subjects.ratings.results.draw(RESULT)", **address).run())


def words(page: AppTest) -> str:
    return texts(page).replace("**", "")


def warnings(page: AppTest) -> str:
    return " ".join(text.value for text in page.warning).replace("\\", "").replace("**", "")


def metrics(page: AppTest) -> dict[str, str]:
    return {metric.label: metric.value for metric in page.metric}


def keys(page: AppTest) -> list[str | None]:
    return [button.key for button in page.button]


def only(page: AppTest, name: str) -> str:
    return "".join(page.query_params[name])


def show_source(page: AppTest, name: str) -> AppTest:
    return checked(page.button_group(key="ratings_source_4").set_value(name).run())


def from_file(content: bytes, name: str = "ratings.csv", page: AppTest | None = None) -> AppTest:
    page = show_source(opened() if page is None else page, source.FILE)
    return checked(
        page.file_uploader(key="ratings_file").set_value((name, content, "text/csv")).run()
    )


def table(page: AppTest, column: str) -> pd.DataFrame:
    return next(table for table in tables(page) if column in table)
