"""Protocols: what each filter leaves out, that nothing is deleted, and what they say."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from builders import Box, Place, make_dataset, tagged

from nvcore.common.errors import InputError, ParameterError
from nvcore.dataset import Dataset
from nvcore.metrics.detection.curves import detection_curve
from nvcore.metrics.detection.filtered_truth import (
    ASPECT,
    BORDER,
    FLAGGED,
    HEIGHT,
    OCCLUSION,
    filter_truth,
    has_tags,
    known_tags,
)
from nvcore.settings.params import Params
from nvcore.settings.protocols import OWN, PROTOCOLS, Protocol, protocol_from

SIZE = {"width": 640.0, "height": 512.0}


def person(h: float = 60, *, x: float = 100, y: float = 100, w: float = 25, **more: object) -> Box:
    return Box(0, x, y, w, h, **more)  # type: ignore[arg-type]


def counted(protocol: Protocol, *boxes: Box, **size: float) -> list[bool]:
    return filter_truth(make_dataset(boxes, **{**SIZE, **size}), protocol).counts.tolist()


def drives() -> Dataset:
    """Three recordings with 2, 1 and 0 pedestrians in 4, 3 and 2 frames."""
    truth = [person(recording=0), Box(3, 200, 100, 25, 60), person(recording=1)]
    return tagged(
        make_dataset(truth, places=[Place(range(n), 640, 512) for n in (4, 3, 2)]),
        ("night", "rain"), ("day", "rain"), ("night",),
    )  # fmt: skip


KAIST = PROTOCOLS["kaist-reasonable"]  # boxes of 25 x 60 px within x 5 to 635, y 5 to 507


@pytest.mark.parametrize(
    ("protocol", "side", "yes", "no"),
    [
        (Protocol("p", height_px=(50, 80)), "h", [50, 80], [49.9, 80.1]),
        (Protocol("p", occlusion=(0, 1)), "occlusion", [-1, 0, 1], [2]),  # unknown: none
        (Protocol("p", occlusion=(1, 2)), "occlusion", [1, 2], [-1, 0]),
        (KAIST, "x", [5, 610], [4.9, 610.1]),
        (KAIST, "y", [5, 447], [4.9, 447.1]),
        (PROTOCOLS["all"], "x", [-10], []),
        (Protocol("p", aspect=(2.0, 3.0)), "h", [50, 75], [76, 49]),
    ],
)
def test_boxes_at_the_limits_of_a_filter_count(protocol, side, yes, no):
    boxes = [person(**{"h": 60, side: value}) for value in (*yes, *no)]
    assert counted(protocol, *boxes) == [True] * len(yes) + [False] * len(no)


def test_the_border_moves_with_the_size_of_the_picture():
    assert counted(Protocol("p", border_px=(0, 0, 10, 0)), person(), width=134.0) == [False]
    assert counted(Protocol("p", border_px=(0, 0, 10, 0)), person(), width=135.0) == [True]


def test_left_out_boxes_stay_as_ignored_ones_and_keep_their_rows():
    dataset = make_dataset([person(30), person(60), person(60, ignore=True)], **SIZE)
    filtered = filter_truth(dataset, PROTOCOLS["reasonable"])
    assert filtered.truth.ignore.tolist() == [True, False, True]
    assert np.array_equal(filtered.truth.h, dataset.truth.h)
    assert dataset.truth.ignore.tolist() == [False, False, True]  # nothing changed in place


def test_a_detection_of_a_left_out_pedestrian_is_neither_right_nor_wrong():
    dataset = make_dataset([person(30)], [person(30, score=0.9)], **SIZE)
    curve = detection_curve(dataset, "x", Params(), Protocol("p", height_px=(50, math.inf)))
    assert (len(curve), curve.n_truth) == (0, 0)


def test_expanded_filtering_leaves_out_detections_of_quite_another_size():
    dataset = make_dataset(
        [person(60)], [person(h, x=300, score=0.5) for h in (39, 40, 100, 101)], **SIZE
    )
    protocol = Protocol("p", height_px=(50, 80), expand=1.25)
    curve = detection_curve(dataset, "x", Params(), protocol)
    assert curve.fp.tolist() == [2]
    assert detection_curve(dataset, "x", Params(), replace(protocol, expand=None)).fp[0] == 4


def test_tags_choose_recordings_with_all_their_frames():
    dataset = drives()
    assert known_tags(dataset) == ("day", "night", "rain")
    assert has_tags(dataset, ("night",)).tolist() == [True, False, True]
    night = filter_truth(dataset, Protocol("p", tags=("night",)))
    assert (night.n_truth, night.n_images) == (2, 4 + 2)
    both = filter_truth(dataset, Protocol("p", tags=("night", "rain")))
    assert (both.n_truth, both.n_images) == (2, 4)


def test_recordings_are_chosen_by_name_beside_their_tags():
    dataset = drives()
    names = tuple(dataset.recordings["name"])
    last = filter_truth(dataset, Protocol("p", recordings=names[1:]))
    assert (last.n_truth, last.n_images) == (1, 3 + 2)
    both = filter_truth(dataset, Protocol("p", tags=("night",), recordings=names[1:]))
    assert both.n_images == 2


def test_a_chosen_recording_that_there_is_not_is_an_error():
    with pytest.raises(InputError, match="there is no recording 'drive_9'; there are 3"):
        filter_truth(drives(), Protocol("p", recordings=("drive_9",)))


def test_a_title_names_one_recording_and_counts_more():
    assert replace(PROTOCOLS["near"], recordings=("a",)).title == "near, a"
    assert replace(PROTOCOLS["near"], recordings=("a", "b")).title == "near, 2 recordings"
    assert "only recording a" in replace(PROTOCOLS["near"], recordings=("a",)).filters
    assert "only recordings a, b" in replace(PROTOCOLS["near"], recordings=("a", "b")).filters
    many = tuple(f"drive_{i}" for i in range(20))
    told = replace(PROTOCOLS["all"], recordings=many).filters
    assert told == ("only 20 recordings, from drive_0 to drive_19",)


def test_what_is_left_out_is_told_with_how_many_boxes_that_are():
    boxes = [person(ignore=True), person(30), person(30, occlusion=2), person(100)]
    rest = [person(x=0), person(w=70)]
    narrow = replace(PROTOCOLS["kaist-reasonable"], aspect=(1, 5))
    filtered = filter_truth(make_dataset([*boxes, *rest], **SIZE), narrow)
    assert dict(filtered.n_left_out) == {FLAGGED: 1, HEIGHT: 2, OCCLUSION: 1, BORDER: 1, ASPECT: 1}
    assert filtered.n_truth == 1
    filtered = filter_truth(make_dataset(boxes, **SIZE), PROTOCOLS["kaist-reasonable"])
    assert filtered.left_out == (
        "3 ignored: 1 flagged in the ground truth, 2 by height, 1 by occlusion (a box that "
        "several of these leave out is counted for each)"
    )
    whole = filter_truth(make_dataset(boxes, **SIZE), PROTOCOLS["all"])
    assert whole.left_out == "1 ignored: flagged in the ground truth"
    assert filter_truth(make_dataset([person()], **SIZE), PROTOCOLS["all"]).left_out == ""


def test_tags_that_no_recording_has_are_an_error_that_lists_the_tags():
    words = r"no recording .* has the tags fog \(there are tags day, night, rain\)"
    with pytest.raises(InputError, match=words):
        filter_truth(drives(), Protocol("p", tags=("fog",)))
    with pytest.raises(InputError, match="none has tags, which a session file gives"):
        filter_truth(make_dataset(n_frames=1), Protocol("p", tags=("fog",)))


def test_a_mask_without_a_recording_is_an_error():
    with pytest.raises(InputError, match="no recording with frames is chosen"):
        filter_truth(drives(), Protocol("p"), recordings=np.zeros(3, dtype=bool))


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"height_px": (80, 50)}, "height_px: expected 0 <= lowest <= highest, got 80 and 50"),
        ({"height_px": (math.nan, 50)}, "height_px"),
        ({"aspect": (-1, 50)}, "aspect"),
        ({"occlusion": ()}, "occlusion: expected one or more of 0, 1, 2"),
        ({"occlusion": (3,)}, "occlusion"),
        ({"border_px": (5, 5, 5, -1)}, "border_px: expected four margins"),
        ({"expand": 0.8}, "expand: expected 1 or more, got 0.8"),
    ],
)
def test_filters_that_mean_nothing_are_refused(wrong, words):
    with pytest.raises(ParameterError, match=words):
        Protocol("p", **wrong)


def test_filters_are_said_in_words():
    assert PROTOCOLS["all"].filters == ()
    assert PROTOCOLS["kaist-reasonable"].filters == (
        "height 55 or more px", "occlusion none or partial",
        "whole box at least 5 px inside the picture",
    )  # fmt: skip
    assert "detections 24 to 100 px high" in PROTOCOLS["medium"].filters
    odd = Protocol("p", border_px=(0, 1, 2, 3), aspect=(0, 5), tags=("night", "rain"))
    assert odd.filters == (
        "whole box at least 0, 1, 2, 3 px (left, top, right, bottom) inside the picture",
        "height / width 5 or less", "recordings tagged night and rain",
    )  # fmt: skip


def test_every_named_protocol_says_what_it_is_in_one_sentence():
    assert list(PROTOCOLS) == [
        "all", "reasonable", "near", "medium", "far", "occlusion", "kaist-reasonable",
    ]  # fmt: skip
    for name, protocol in PROTOCOLS.items():
        assert protocol.name == name
        assert protocol.text.endswith(".")


@pytest.mark.parametrize(
    "protocol",
    [
        *PROTOCOLS.values(),
        replace(PROTOCOLS["near"], tags=("night", "wet road")),
        replace(PROTOCOLS["far"], tags=("night",), recordings=("drive\n1", "2")),
        Protocol(OWN, height_px=(10, 20), recordings=("2",)),
        Protocol(OWN, height_px=(10, math.inf), tags=("night",)),
        Protocol(OWN, occlusion=(2,), border_px=(1, 2, 3, 4), aspect=(0, 3), expand=2),
    ],
    ids=lambda protocol: protocol.title,
)
def test_what_a_session_file_says_of_a_protocol_makes_it_again(protocol):
    assert protocol_from(protocol.given()) == protocol


def test_a_filter_beside_a_name_replaces_that_of_the_named_protocol():
    protocol = protocol_from({"name": "reasonable", "height_px": [40, 90]})
    assert protocol == replace(PROTOCOLS["reasonable"], name=OWN, text="", height_px=(40, 90))


def test_own_filters_that_leave_nothing_out_are_the_protocol_all():
    assert protocol_from(Protocol(OWN).given()) == PROTOCOLS["all"]


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"name": 3}, "there is no protocol 3"),
        ({"text": "mine"}, "there is no filter 'text'"),
        ({"height_px": [50]}, "height_px: expected two numbers"),
        ({"height_px": [math.nan, 60]}, "height_px: expected 0 <= lowest <= highest"),
        ({"height_px": [math.inf, math.inf]}, "height_px: expected 0 <= lowest <= highest"),
        ({"expand": 10**400}, "expand: expected a number, got too large a number"),
        ({"aspect": [True, 2]}, "aspect: expected two numbers"),
        ({"border_px": [1, 2, 3]}, "border_px: expected four numbers"),
        ({"occlusion": [0.5]}, "occlusion: expected levels"),
        ({"tags": "night"}, "tags: expected a list of words"),
        ({"recordings": [1]}, "recordings: expected a list of names"),
        ({"expand": [1]}, "expand: expected a number"),
    ],
)
def test_values_that_a_filter_cannot_have_are_refused(values, words):
    with pytest.raises(ParameterError, match=re.escape(words)):
        protocol_from(values)
