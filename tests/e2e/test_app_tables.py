"""Tables in a browser: rows in sight, sorting, keys, clicks."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from app_server import ROOT, serve
from app_visit import Visit
from playwright.sync_api import BrowserContext, Locator, expect

from nvcore.wording import minus
from ui.widgets.script import read_script

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


@pytest.fixture(scope="module")
def address(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    script: Path = tmp_path_factory.mktemp("tables") / "tables.py"
    script.write_text(SCRIPT, encoding="utf-8")
    with serve(script) as served:
        yield served


@pytest.fixture
def table(person: BrowserContext, address: str) -> Iterator[Locator]:
    one = Visit(person, address)
    one.go("")
    grid = one.table("many")
    expect(grid).to_have_attribute("aria-rowcount", str(N_ROWS + 1))
    yield grid
    assert one.complaints == []
    one.close()


def hears(table: Locator) -> Callable[[str], None]:
    return lambda text: expect(table.page.get_by_role("heading", level=1)).to_have_text(text)


def first_row(table: Locator) -> list[str]:
    return table.locator("tbody.rows tr").first.locator("th, td").all_inner_texts()


def test_only_rows_in_sight_are_elements_and_all_can_be_scrolled_to(table: Locator):
    rows = table.locator("tbody.rows tr")
    assert rows.count() < 40
    assert first_row(table) == ["row 0", "+25.0"]
    table.get_by_role("rowheader", name="row 5", exact=True).press("End")
    table.locator("..").evaluate("holder => holder.scrollTop = holder.scrollHeight")
    expect(table.get_by_role("rowheader", name=f"row {N_ROWS - 1}")).to_be_visible()
    assert rows.count() < 40
    assert rows.last.get_attribute("aria-rowindex") == str(N_ROWS + 1)


def test_a_heading_sorts_up_then_down_then_not_and_what_is_undefined_is_last(table: Locator):
    heading = table.get_by_role("columnheader", name="Value")
    heading.click()
    expect(heading).to_have_attribute("aria-sort", "ascending")
    assert first_row(table)[1] == "−99.5"
    heading.click()
    expect(heading).to_have_attribute("aria-sort", "descending")
    assert first_row(table)[1] == "∞"
    table.locator("..").evaluate("holder => holder.scrollTop = holder.scrollHeight")
    expect(table.locator("tbody.rows tr").last.locator("td")).to_have_text("–")
    heading.click()
    expect(heading).not_to_have_attribute("aria-sort", re.compile("."))
    expect(heading).to_be_focused()


def test_a_click_tells_the_row_whatever_the_order(table: Locator):
    for _ in range(2):
        table.get_by_role("columnheader", name="Value").click()
    assert first_row(table)[0] == "row 2"
    table.get_by_role("rowheader", name="row 2", exact=True).click()
    hears(table)("2 name")


def test_numbers_are_written_as_by_python(table: Locator):
    script = read_script(ROOT / "ui" / "widgets" / "number_format.js")
    values = [n / 8 for n in range(-40, 4000, 7)] + [0.145, 1.555, 2.675, 1e6 / 3, -0.004, 0.285]
    cases = [
        (value, form) for value in values for form in (".0f", ".1f", ".2f", ".3f", ".0%", ".1%")
    ]
    written = table.page.evaluate(
        f"cases => {{ {script}\n return cases.map(([value, form]) => formatted(value, form)); }}",
        cases,
    )
    expected = (minus(format(value, f"z,{form}")) for value, form in cases)
    assert written == [text.replace("%", " %") for text in expected]


def test_keys_reach_every_cell_by_one_stop(table: Locator):
    assert table.locator("[tabindex='0']").count() == 1
    table.locator("[tabindex='0']").focus()
    page = table.page
    for key in ("ArrowDown", "ArrowRight", *["PageDown"] * 3, "ArrowDown"):
        page.keyboard.press(key)
    cell = table.locator("tr:has([tabindex='0'])")
    expect(cell).to_have_attribute("aria-rowindex", "33")
    expect(table.locator("[tabindex='0']")).to_be_focused()
    expect(table.locator("[tabindex='0']")).to_be_in_viewport()
    page.keyboard.press("Enter")
    hears(table)("31 value")
