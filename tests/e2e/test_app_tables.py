"""Tables in a browser: rows in sight, sorting, keys, clicks."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from app_server import serve
from app_visit import Visit
from playwright.sync_api import BrowserContext, Locator, expect

N_ROWS = 5000
SCRIPT = f"""
import numpy as np
import pandas as pd
import streamlit as st
from ui.widgets.table import TableColumn, draw_table

n = np.arange({N_ROWS})
rows = pd.DataFrame({{"name": [f"row {{i}}" for i in n], "value": (n * 7919) % {N_ROWS} - 100.5}})
rows.loc[0, "value"] = 25.0
rows.loc[2, "value"] = float("inf")
rows.loc[3, "value"] = float("nan")
columns = {{"name": TableColumn("Name", is_head=True), "value": TableColumn("Value", form="+.1f")}}
draw_table(
    rows, columns, key="many", name="Many rows",
    on_click=lambda row, column: st.session_state.update(heard=f"{{row}} {{column}}"),
)
st.title(st.session_state.get("heard", "nothing"))
"""


@pytest.fixture
def table(person: BrowserContext, tmp_path: Path) -> Iterator[Locator]:
    script = tmp_path / "tables.py"
    script.write_text(SCRIPT, encoding="utf-8")
    with serve(script) as address:
        one = Visit(person, address)
        one.go("")
        grid = one.table("many")
        expect(grid).to_have_attribute("aria-rowcount", str(N_ROWS + 1))
        yield grid
        one.close()
    assert one.complaints == []


def hears(table: Locator, text: str) -> None:
    expect(table.page.get_by_role("heading", level=1)).to_have_text(text)


def first_row(table: Locator) -> list[str]:
    return table.locator("tbody.rows tr").first.locator("th, td").all_inner_texts()


def scroll(table: Locator, to: str) -> None:
    table.locator("..").evaluate(f"holder => holder.scrollTop = {to}")


END = "holder.scrollHeight"


def test_a_long_table_is_scrolled_walked_through_by_keys_sorted_and_clicked(table: Locator):
    # only rows in sight are elements
    rows = table.locator("tbody.rows tr")
    assert rows.count() < 40
    assert first_row(table) == ["row 0", "+25.0"]

    # keys reach every cell by one stop
    page = table.page
    stop = table.locator("[tabindex='0']")
    assert stop.count() == 1
    stop.focus()
    for key in ("ArrowDown", "ArrowRight", *["PageDown"] * 3, "ArrowDown"):
        page.keyboard.press(key)
    cell = table.locator("tr:has([tabindex='0'])")
    expect(cell).to_have_attribute("aria-rowindex", "33")
    expect(stop).to_be_focused()
    expect(stop).to_be_in_viewport()
    page.keyboard.press("Enter")
    hears(table, "31 value")

    # all rows can be scrolled to
    scroll(table, END)
    expect(table.get_by_role("rowheader", name=f"row {N_ROWS - 1}")).to_be_visible()
    assert rows.count() < 40
    assert rows.last.get_attribute("aria-rowindex") == str(N_ROWS + 1)

    scroll(table, "0")
    expect(table.get_by_role("rowheader", name="row 0", exact=True)).to_be_visible()

    # a heading sorts up, then down, then not, and what is undefined is last
    heading = table.get_by_role("columnheader", name="Value")
    heading.click()
    expect(heading).to_have_attribute("aria-sort", "ascending")
    assert first_row(table)[1] == "−99.5"
    heading.click()
    expect(heading).to_have_attribute("aria-sort", "descending")
    assert first_row(table) == ["row 2", "∞"]
    scroll(table, END)
    expect(rows.last.locator("td")).to_have_text("–")

    # a click tells the row whatever the order
    table.get_by_role("rowheader").last.click()
    hears(table, "3 name")
    heading.click()
    expect(heading).not_to_have_attribute("aria-sort", re.compile("."))
    expect(heading).to_be_focused()
