"""The Data page: a file in the wrong field is said at the field, before anything is opened."""

from __future__ import annotations

import pytest
from data_page import READING, sent, space_of

from pages import checked, part, texts

SCORED = b"frame,x,y,w,h,score\n0,9,9,40,90,0.9\n1,9,9,40,90,0.75\n2,9,9,40,90,0.5\n"
TRACKED = b"frame,x,y,w,h,track\n0,9,9,40,90,1\n1,9,9,40,90,1\n2,9,9,40,90,1\n"
MOT_DETECTIONS = b"1,-1,9,9,40,90,0.91,-1,-1,-1\n2,-1,9,9,40,90,0.42,-1,-1,-1\n"


@pytest.mark.parametrize(
    ("truth", "words"),
    [(SCORED, "3 of its rows have a score"), (MOT_DETECTIONS, "2 of its rows have a score")],
)
def test_detections_as_ground_truth_are_said_at_the_field(truth: bytes, words: str):
    page = sent(truth)
    assert f"This looks like a system's detections: {words}" in texts(page)


def test_ground_truth_as_detections_is_said_at_the_field():
    page = sent(TRACKED, ("x.csv", TRACKED))
    assert "This looks like ground truth: every box has a track id" in texts(page)


def test_a_reload_says_which_chosen_files_it_dropped():
    page = sent(TRACKED, ("x.csv", SCORED))
    assert "loaded again" not in texts(page)
    again = part(*READING)
    again.session_state["workspace"] = space_of(page)
    again = checked(again.run())
    assert "truth.csv and x.csv were chosen here and not opened yet" in texts(again)


def test_files_in_their_fields_raise_no_doubt():
    page = sent(TRACKED, ("x.csv", SCORED))
    assert "This looks like" not in texts(page)
