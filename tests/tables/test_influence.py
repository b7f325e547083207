"""Whether who is ahead in mean similarity rests on a single recording."""

from __future__ import annotations

import pytest
from builders import Box, Place, at, make_dataset, result_of

from nvcore.comparison.compare import Result
from nvcore.notes import say
from nvcore.settings.objects import PEDESTRIAN
from nvcore.tables.influence import leads, similarity_without_each

PLACES = [Place(range(10)), Place([]), Place(range(5))]
TRUTH = [at(i, 50, track=1) for i in range(10)]
TRUTH += [at(i, 50, track=1, recording=2) for i in range(5)]


def missing(x: list[tuple[int, int]], y: list[tuple[int, int]]) -> Result:
    """X and Y miss the pedestrian in these frames, given as (recording, frame)."""

    def seen(missed: list[tuple[int, int]]) -> list[Box]:
        return [box for box in TRUTH if (box.recording, box.frame) not in missed]

    return result_of(make_dataset(TRUTH, seen(x), seen(y), places=PLACES))


def test_without_a_recording_the_mean_is_that_of_the_other_frames():
    """A frame with a miss has a similarity of 0.1."""
    table = similarity_without_each(missing([(0, 4)], [(2, 1), (2, 2), (2, 3)]))
    assert table["recording"].tolist() == ["r0", "r2"]
    assert table["x"].to_numpy() == pytest.approx([1, 9.1 / 10])
    assert table["y"].to_numpy() == pytest.approx([2.3 / 5, 1])


def words(result: Result, key: str) -> str:
    return " ".join(say(note, PEDESTRIAN) for note in leads(result) if note.key == key)


@pytest.mark.parametrize(
    ("x", "y", "text"),
    [
        (
            [(0, 4)],
            [(2, 1), (2, 2), (2, 3)],
            "X is ahead by 0.120 in mean similarity, but that rests on one recording: without r2 Y "
            "would be, by 0.090.",
        ),
        (
            [(0, 4), (0, 5), (2, 1)],
            [(0, 4)],
            "Y is ahead by 0.120 in mean similarity, whichever recording is left out: by 0.090 or "
            "more (least without r2).",
        ),
        (
            [],
            [(0, 4)],
            "X is ahead by 0.060 in mean similarity, but that rests on one recording: without r0 "
            "neither would be.",
        ),
        ([(0, 4)], [(2, 4)], ""),
    ],
    ids=["one decides", "none decides", "all of it is of one", "nobody is ahead"],
)
def test_it_is_said_whether_one_recording_decides_who_is_ahead(
    x: list[tuple[int, int]], y: list[tuple[int, int]], text: str
):
    assert words(missing(x, y), "moments.lead") == text


def test_of_a_single_recording_nothing_is_said():
    truth = [at(i, 50, track=1) for i in range(4)]
    result = result_of(make_dataset(truth, truth, truth[:2]))
    assert similarity_without_each(result).empty
    assert leads(result) == ()


def test_it_is_said_of_encounters_severity_and_false_alerts_too():
    """X misses the second pedestrian for good; Y misses the first in 4 of 10 frames."""
    result = missing([(2, frame) for frame in range(5)], [(0, frame) for frame in range(4)])
    assert words(result, "moments.other_leads") == (
        "Who is ahead in encounters detected and severity rests on one recording."
    )
    result = missing([], [(0, 4), (2, 4)])
    assert (
        words(result, "moments.other_leads") == "With any one left out, X stays ahead in severity."
    )
