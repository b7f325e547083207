"""The Detection page, driven without a browser."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest
from streamlit.testing.v1 import AppTest

from nvcore.curve_summary import SUMMARY_ROWS, summarise_curve
from nvcore.curves import detection_curve
from nvcore.loading import effective_params, load
from nvcore.protocols import PROTOCOLS
from nvcore.session_file import read_session
from ui.state import SAMPLE

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(autouse=True)
def surroundings(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NVCORE_UPLOAD_DIR", str(tmp_path / "uploads"))


def opened() -> AppTest:
    app = AppTest.from_file(str(ROOT / "ui" / "main.py"), default_timeout=60).run()
    return checked(app.switch_page(str(ROOT / "pages" / "detection.py")).run())


def checked(page: AppTest) -> AppTest:
    assert not page.exception
    assert not page.error
    return page


def figures(page: AppTest) -> pd.DataFrame:
    return page.dataframe[0].value


def captions(page: AppTest) -> str:
    return " ".join(one.value for one in page.caption)


def test_the_table_holds_the_librarys_figures():
    session = read_session(SAMPLE)
    dataset = load(session)
    params = effective_params(session, dataset)
    curve = detection_curve(dataset, "FIR", params, PROTOCOLS["all"])
    summary = summarise_curve(curve, params.threshold_x)
    expected = [format(getattr(summary, name), form) for name, _, _, form in SUMMARY_ROWS]
    assert figures(opened())["X"].tolist() == expected


def test_a_protocol_says_what_it_leaves_out_and_changes_the_figures():
    page = opened()
    before = figures(page)["X"].tolist()
    assert "8,172 pedestrians in 3,000 images" in captions(page)
    checked(page.selectbox(key="protocol").set_value("reasonable").run())
    assert "height 50 or more px" in captions(page).replace("\\", "")
    assert "ignored: flagged in the ground truth 136, height" in captions(page)
    assert figures(page)["X"].tolist() != before


def test_own_filters_are_taken():
    page = opened()
    checked(page.selectbox(key="protocol").set_value("own filters").run())
    assert "8,172 pedestrians" in captions(page)
    checked(page.number_input(key="own_low").set_value(100.0).run())
    assert "height 100 or more px" in captions(page).replace("\\", "")
    assert "8,172 pedestrians" not in captions(page)


def test_lowest_above_highest_gives_way():
    page = opened()
    checked(page.selectbox(key="protocol").set_value("own filters").run())
    page.number_input(key="own_low").set_value(100.0)
    checked(page.number_input(key="own_high").set_value(50.0).run())
    assert "height 50 to 50 px" in captions(page).replace("\\", "")


def test_windows_are_counted_or_given():
    page = opened()
    checked(page.button_group(key="curve_kind").set_value("roc_windows").run())
    # 640 x 480, scale 1: ((640 - 32) / 4 + 1) * ((480 - 64) / 4 + 1) windows
    checked(page.text_input(key="window_scales").set_value("1, 1, 1").run())
    assert f"{153 * 105:,} windows per image" in captions(page)
    checked(page.text_input(key="window_scales").set_value("many").run())
    assert "three numbers" in page.warning[0].value
    checked(page.number_input(key="windows_given").set_value(1000).run())
    assert not page.warning


def test_the_threshold_moves_the_figures_at_it_and_not_the_curve():
    page = opened()
    before = figures(page).set_index("figure")["X"]
    checked(page.slider(key="threshold_x").set_value(0.7).run())
    after = figures(page).set_index("figure")["X"]
    changed = before.index[before != after]
    assert len(changed) == 4
    assert all("at the threshold" in name for name in changed)
