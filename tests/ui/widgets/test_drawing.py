"""Pictures of frames that pages draw."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import small_estimator

from pages import begin_with, checked, scripted
from ui.widgets.drawing import cut_out

CHANGES = """
import streamlit as st
from ui.session import settings, state
from ui.widgets import drawing
settings.begin_run()
st.text(drawing.visible_of(0).change_s.tolist())
"""


def test_a_cut_out_lies_around_the_pedestrian_and_within_the_picture():
    picture = np.arange(100 * 200).reshape(100, 200)
    middle = cut_out(picture, np.array([95, 40, 10, 20]))
    assert middle.shape == (44, 70)
    assert middle[22, 35] == picture[50, 100]
    corner = cut_out(picture, np.array([190, 90, 10, 20]))
    assert (corner[-1, -1], corner.shape) == (picture[-1, -1], (44, 70))
    tall = cut_out(np.zeros((100, 120)), np.array([10, 0, 40, 100]))
    assert tall.shape == (100, 120)


def test_a_real_change_of_light_between_the_frames_is_known_to_the_viewer(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    """Frames at 0, 2 and 4 s are evaluated; by the light meter it is dark from 2.5 to 3 s."""
    session = small_estimator.write_session(tmp_path)
    lines = [f"{time / 10},{10 if 25 <= time < 30 else 1000}" for time in range(-40, 60)]
    (tmp_path / "lux.csv").write_text("\n".join(["time_s,lux", *lines]) + "\n")
    text = session.read_text().replace('frames = "0:59"', 'frames = "0:59:20"')
    session.write_text(text)
    begin_with(session, monkeypatch)
    page = checked(scripted(CHANGES).run())
    assert [item.value for item in page.text] == ["[2.5]"]
