"""The Ratings page for its tests: opened, and read."""

from __future__ import annotations

import pandas as pd
from places import ROOT
from streamlit.testing.v1 import AppTest

import pages
from pages import checked
from ui.ratings import source

SIMULATED = ROOT / "sample_data" / "ratings_simulated.csv"


def opened(**address: str) -> AppTest:
    return checked(pages.opened("ratings", **address))


def words(page: AppTest) -> str:
    shown = (*page.markdown, *page.caption, *page.info, *page.warning, *page.error, *page.success)
    return " ".join(one.value for one in shown).replace("\\", "")


def warnings(page: AppTest) -> str:
    return " ".join(one.value for one in page.warning).replace("\\", "").replace("**", "")


def metrics(page: AppTest) -> dict[str, str]:
    return {one.label: one.value for one in page.metric}


def keys(page: AppTest) -> list[str | None]:
    return [one.key for one in page.button]


def only(page: AppTest, name: str) -> str:
    return "".join(page.query_params[name])


def from_file(content: bytes, name: str = "ratings.csv", page: AppTest | None = None) -> AppTest:
    page = opened() if page is None else page
    checked(page.button_group(key="ratings_source_4").set_value(source.FILE).run())
    return checked(
        page.file_uploader(key="ratings_file").set_value((name, content, "text/csv")).run()
    )


def table(page: AppTest, column: str) -> pd.DataFrame:
    return next(one.value for one in page.dataframe if column in one.value)
