"""Evidence frames: which are chosen, and that the pictures are the right ones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from builders import Box, Place, at, make_dataset, result_of
from inputs import drive, session_of

from nvcore.comparison.compare import Result
from nvcore.inputs.load import load
from nvcore.inputs.session import RecordingEntry
from nvcore.pictures import RecordingPictures, open_pictures, session_pictures
from nvcore.report.decisive_moments import EXCLUSIVE, MOST, Moment, decisive_moments
from nvcore.report.html.frames import MOST_BYTES, photo
from nvcore.report.sections.evidence import frames_section


def decoded(jpeg: bytes) -> np.ndarray:
    return cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR)


def missed_by_one(who_misses: str, centres: Sequence[float], *, recording: int = 0) -> Result:
    """One pedestrian on its way, missed by one system in all frames; the other finds it."""
    truth = [at(t, c, track=7, recording=recording) for t, c in enumerate(centres)]
    detections = [at(t, c, recording=recording) for t, c in enumerate(centres)]
    x, y = ([], detections) if who_misses == "x" else (detections, [])
    return result_of(make_dataset(truth, x, y, n_frames=len(centres)))


@pytest.mark.parametrize(("loser", "winner"), [("x", "Y"), ("y", "X")])
def test_of_an_encounter_that_one_detects_the_frame_that_costs_most_is_shown(loser, winner):
    # the farther from the border, the more a miss costs: 40 of 50 px in frame 2
    first = decisive_moments(missed_by_one(loser, [10, 25, 40, 30, 5]))[0]
    assert (first.row, first.title, first.encounter) == (2, f"Only {winner} detects", 0)
    assert first.text == (
        f"Pedestrian 7: {winner} matches 100 % of the frames that count, {loser.upper()} 0 % "
        "(never)."
    )


def test_a_frame_that_both_miss_does_not_tell_the_two_apart():
    truth = [at(t, 30 if t else 50, track=1) for t in range(4)]
    x = [at(t, 30) for t in (1, 2, 3)]  # frame 0, which would cost most, is missed by both
    first = decisive_moments(result_of(make_dataset(truth, x, [], n_frames=4)))[0]
    assert (first.title, first.row) == ("Only X detects", 1)


def test_the_encounter_whose_failure_weighs_more_comes_first():
    truth = [at(t, 30, track=1) for t in range(10)]
    truth += [at(t, 50, track=2, recording=1) for t in range(5)]
    # straight ahead Y misses but a frame more than X, beside that somebody all the time
    x = [at(t, 30) for t in range(10)] + [at(t, 50, recording=1) for t in range(3)]
    y = [at(t, 50, recording=1) for t in (3, 4)]
    places = [Place([*range(10)]), Place([*range(5)])]
    first, second = decisive_moments(result_of(make_dataset(truth, x, y, places=places)))[:2]
    assert [first.encounter, second.encounter] == [0, 1]
    assert second.text == ("Pedestrian 2: X matches 60 % of the frames that count, Y 40 % (brief).")


def test_there_are_a_dozen_at_most_and_no_frame_twice():
    centres = [10 + 3 * i for i in range(14)]
    truth = [at(0, c, track=1, recording=i) for i, c in enumerate(centres)]
    x = [at(0, c, recording=i) for i, c in enumerate(centres) if i % 2]
    y = [at(0, c, recording=i) for i, c in enumerate(centres) if not i % 2]
    places = [Place([0])] * 14
    moments = decisive_moments(result_of(make_dataset(truth, x, y, places=places)))
    titles = [moment.title for moment in moments]
    assert (
        titles[: 2 * EXCLUSIVE] == ["Only X detects"] * EXCLUSIVE + ["Only Y detects"] * EXCLUSIVE
    )
    assert len(moments) <= MOST
    assert len({moment.row for moment in moments}) == len(moments)
    # the clearest first: those in the middle
    assert [moment.row for moment in moments[:EXCLUSIVE]] == [13, 11, 9, 7]


@pytest.fixture
def pictures(tmp_path: Path) -> RecordingPictures:
    """Six grey pictures, the brightness tells which."""
    for i in range(6):
        cv2.imwrite(str(tmp_path / f"{i}.png"), np.full((100, 100), 30 * i, np.uint8))
    return RecordingPictures({0: open_pictures(tmp_path)}, {0: np.arange(5, 0, -1)}, (0.0, 100.0))


def test_the_picture_is_that_of_the_frame(pictures):
    result = missed_by_one("x", [10, 25, 40, 30, 5])
    moment = decisive_moments(result)[0]
    drawn = photo(result, moment, pictures)
    assert decoded(drawn.jpeg)[-20, 20].mean() == pytest.approx(30 * 3, abs=6)  # row 2: picture 3
    assert drawn.place == "r0, frame 2, 0.20 s"
    assert drawn.measures == (
        "similarity of this frame: X 0.28 (lost to misses 0.720, to false alarms 0.000), "
        "Y 1.00 (lost to misses 0.000, to false alarms 0.000)"
    )
    # the pedestrian is 40 of 50 px from the edge, with nothing of X anywhere
    assert drawn.boxes.head[:5] == ("ped", "term X", "term Y", "cost", "missed by")
    assert drawn.boxes.rows == (("7", "0.80", "0.00", "0.80", "X", "1.00", "40", "–", "0"),)


def test_below_a_picture_stand_the_pedestrians_that_cost_most():
    crowd = [at(0, 5 * i, track=i) for i in range(1, 10)]
    boxes = photo(
        result_of(make_dataset(crowd, crowd, [])), Moment(0, "", "", 0, "y"), RecordingPictures()
    ).boxes
    assert [row[0] for row in boxes.rows] == ["9", "8", "7", "6", "5"]
    assert boxes.note == "The 5 with the largest terms, 4 left out."
    empty = result_of(make_dataset([], [at(0, 50)], []))
    assert photo(empty, Moment(0, "", "", -1, "x"), RecordingPictures()).boxes is None


def test_without_pictures_boxes_stand_on_a_light_ground_and_that_is_said_once():
    result = missed_by_one("x", [50, 50, 50])
    drawn = photo(result, decisive_moments(result)[0], RecordingPictures())
    shown = decoded(drawn.jpeg)
    assert drawn.why_blank == "no picture for this frame"
    assert shown[-20, 20].min() > 230
    assert shown.min() < 90  # boxes and the ellipse
    text, block = frames_section(result, [drawn, drawn], ()).worded(result.objects).blocks
    assert text.texts[0].startswith("There are no pictures of these frames")
    assert [photo.why_blank for photo in block.photos] == ["", ""]
    (mixed,) = frames_section(result, [drawn, replace(drawn, why_blank="")], ()).blocks
    assert [photo.why_blank for photo in mixed.photos] == [drawn.why_blank, ""]
    trouble, *_ = frames_section(result, [drawn], ["rural: there is no such file"]).blocks
    assert trouble.texts == ("Some pictures cannot be shown.", "rural: there is no such file")


def test_a_wide_picture_has_a_row_of_its_own():
    truth = [Box(0, 200, 40, 20, 50, 1)]
    for height, is_wide in ((120.0, True), (300.0, False)):
        dataset = make_dataset(truth, truth, [], width=400.0, height=height, n_frames=1)
        result = result_of(dataset, midpoint=10.0, spread=2.0)
        drawn = photo(result, decisive_moments(result)[0], RecordingPictures())
        assert drawn.is_wide is is_wide
        assert decoded(drawn.jpeg).shape[1] == pytest.approx(1200 if is_wide else 880, abs=1)


def test_frames_of_one_scene_are_shown_once():
    # at 10 fps, frames 0 and 15 are 1.5 s apart, 0 and 40 are 4 s apart
    truth = [at(t, 50, track=t) for t in (0, 15, 40)]
    moments = decisive_moments(result_of(make_dataset(truth, truth, [], n_frames=60)))
    assert [moment.row for moment in moments] == [0, 40]


def test_a_scene_may_speak_against_both_systems():
    truth = [at(0, 30, track=1), at(5, 60, track=2)]
    result = result_of(make_dataset(truth, truth[:1], truth[1:], n_frames=6))
    assert {(moment.row, moment.loser) for moment in decisive_moments(result)[:2]} == {
        (0, "y"),
        (5, "x"),
    }


def test_a_small_difference_is_not_shown_as_one():
    shown = {}
    for shift in (0, 2, 4):  # px, of 50 to the border: similarity is lower by 0.04 and by 0.08
        truth = [Box(t, 40, 40, 20, 50, 1) for t in range(3)]
        near = [Box(t, 40 + shift, 40, 20, 50) for t in range(3)]
        moments = decisive_moments(result_of(make_dataset(truth, truth, near)))
        shown[shift] = [moment.title for moment in moments]
    assert shown == {0: [], 2: [], 4: ["X better than Y (1.00 to 0.92)"]}


def test_a_worst_moment_is_shown_in_a_frame_with_its_pedestrian():
    # X misses track 1 in frames 0..9; the false alarm makes frame 5, without it, the lowest
    truth = [at(t, 40, track=1) for t in range(10) if t != 5]
    x = [at(5, 50)]
    result = result_of(make_dataset(truth, x, truth, n_frames=10), alpha=0.5)
    about = [moment for moment in decisive_moments(result) if moment.encounter == 0]
    assert about
    assert all(moment.row != 5 for moment in about)


def encircled(result: Result, moment: Moment, other: Moment) -> tuple[np.ndarray, np.ndarray]:
    """Rows and columns, as shares of the picture, that tell it from that of another moment."""
    drawn, plain = (
        decoded(photo(result, at_moment, RecordingPictures()).jpeg).astype(int)
        for at_moment in (moment, other)
    )
    rows, columns = np.nonzero(np.abs(drawn - plain).max(axis=-1) > 80)
    return rows / drawn.shape[0], columns / drawn.shape[1]


def test_the_pedestrian_meant_is_encircled():
    truth = [Box(0, 40, 40, 20, 50, 1)]  # of a picture of 100 x 100 px
    result = result_of(make_dataset(truth, truth, [], n_frames=1))
    moment = decisive_moments(result)[0]
    rows, columns = encircled(result, moment, moment._replace(encounter=-1))
    assert rows.min() < 0.4 < 0.9 < rows.max()
    assert columns.min() < 0.4 < 0.6 < columns.max()


def test_the_false_alarm_meant_is_encircled():
    alarms = [at(0, 10), at(0, 50)]  # the one in the middle counts more
    result = result_of(make_dataset([], alarms, [], n_frames=1), alpha=0)
    (moment, *_) = decisive_moments(result)
    assert (moment.row, moment.encounter, moment.loser) == (0, -1, "x")
    assert "false alarm" in moment.text
    _, columns = encircled(result, moment, moment._replace(loser="y"))
    assert columns.mean() == pytest.approx(0.5, rel=0.05)


def test_a_false_alarm_that_hangs_out_of_the_picture_can_be_the_one_meant():
    # half rural: its centre counts as at the edge, 25 px, the other one 20 px from the pedestrian
    alarms = [at(0, 40), Box(0, 95, 40, 50, 50)]
    result = result_of(make_dataset([at(0, 60, track=1)], alarms, [], n_frames=1), edge_weight=0.5)
    moment = Moment(0, "A worst moment of X", "", -1, "x")
    assert encircled(result, moment, moment._replace(loser="y"))[1].min() > 0.5


def test_a_noisy_picture_takes_no_more_room_than_it_may(tmp_path: Path):
    noise = np.random.default_rng(1).integers(0, 255, (1080, 1920, 3), dtype=np.uint8)
    cv2.imwrite(str(tmp_path / "0.png"), noise)
    source = open_pictures(tmp_path / "0.png")
    result = missed_by_one("x", [50])
    many = RecordingPictures({0: source}, {0: np.zeros(1, int)}, (0.0, 100.0))
    drawn = photo(result, decisive_moments(result)[0], many)
    assert len(drawn.jpeg) <= 1.5 * MOST_BYTES
    assert decoded(drawn.jpeg).shape[0] <= 800


def test_the_wanted_pictures_of_a_session_are_opened_and_what_cannot_be_is_told(tmp_path: Path):
    drive(tmp_path)
    cv2.imwrite(str(tmp_path / "0.png"), np.zeros((480, 640), np.uint8))
    facts = (
        RecordingEntry("urban", pictures="0.png"),
        RecordingEntry("rural", pictures="absent.mp4"),
    )
    session = session_of(tmp_path, recordings=facts)
    dataset = load(session)
    urban = dataset.recordings["name"].tolist().index("urban")
    opened = session_pictures(session, dataset)
    assert list(opened.sources) == [urban]
    rural = 1 - urban
    assert opened.troubles == {rural: "absent.mp4: there is no such file or folder of pictures"}
    opened.close()
    wanted = session_pictures(session, dataset, {urban})
    assert (list(wanted.sources), wanted.troubles) == ([urban], {})
    wanted.close()
