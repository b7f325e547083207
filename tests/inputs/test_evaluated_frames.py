"""Which frames are evaluated."""

from __future__ import annotations

import gzip
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from inputs import write

from nvcore.common.errors import FormatError, InputError, MissingFactError
from nvcore.common.findings import Remedy, Step
from nvcore.inputs import evaluated_frames
from nvcore.inputs.evaluated_frames import (
    MIN_SAMPLED,
    frames_there,
    infer_frames,
    nth,
    parse_frames,
)
from nvcore.inputs.facts import is_frame_range

HERE = Path()


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("0:3", [0, 1, 2, 3]),
        ("9:49:20", [9, 29, 49]),
        ("9:48:20", [9, 29]),
        ("-2:0", [-2, -1, 0]),
        (" 5 : 5 ", [5]),
    ],
)
def test_a_range_includes_its_last_frame(text: str, expected: list[int]):
    assert parse_frames(text, HERE).tolist() == expected


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (":12", [10, 11, 12]),
        ("13:", [13, 14]),
        ("11::2", [11, 13]),
        (":", [10, 11, 12, 13, 14]),
        ("20:", []),
        ("9:11", [9, 10, 11]),
    ],
)
def test_a_missing_end_is_that_of_the_recording(text: str, expected: list[int]):
    assert parse_frames(text, HERE, np.arange(10, 15)).tolist() == expected


def test_without_a_recording_both_ends_are_needed():
    with pytest.raises(InputError, match="frames ':12': expected both ends here"):
        parse_frames(":12", HERE)


def test_frames_that_are_there_are_said_of_all_or_of_a_few():
    same = {name: np.arange(10, 15) for name in "abcdefgh"}
    assert frames_there(same) == "a, b, c, d, e and 3 more have frames 10 to 14"
    assert frames_there({**same, "i": np.arange(3)}).endswith("10 to 14 and i has frames 0 to 2")
    many = {name: np.arange(place) for place, name in enumerate("abcdefgh", 1)}
    assert frames_there(many).startswith("a has frames 0 to 0, b has frames 0 to 1, ")
    assert frames_there(many).endswith("e has frames 0 to 4 and 3 more")


@pytest.mark.parametrize(
    "content", [b"29\n\n 9 \n29\n", b"\xef\xbb\xbf9\r\n29\r\n"], ids=["LF", "BOM and CRLF"]
)
def test_a_file_gives_its_numbers_sorted_and_once(tmp_path: Path, content: bytes):
    (tmp_path / "frames.txt").write_bytes(content)
    assert parse_frames("frames.txt", tmp_path).tolist() == [9, 29]


def test_every_space_around_a_number_is_one(tmp_path: Path):
    (tmp_path / "frames.txt").write_text("\x1f1\n\u00a03\x1d\n")
    assert parse_frames("frames.txt", tmp_path).tolist() == [1, 3]
    assert parse_frames("\x1f0:\x1d2", tmp_path).tolist() == [0, 1, 2]


@pytest.mark.parametrize("line", ["nine", "9.5", "9 10", "9" * 5000])
def test_a_line_that_is_no_frame_number_is_named(tmp_path: Path, line: str):
    write(tmp_path / "frames.txt", "9", line)
    with pytest.raises(FormatError, match=r"frames\.txt, line 2: expected a frame number, found"):
        parse_frames("frames.txt", tmp_path)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("3:0", "frames '3:0': expected first:last"),
        ("0:3:0", "frames '0:3:0': expected first:last"),
        ("0:100000000000", "expected at most 10000000 frames"),
        ("empty.txt", r"empty\.txt: holds no frame number"),
        ("no.txt", r"no\.txt: .*first:last.*\(No such file or directory\)"),
        ("a\0b", "cannot be read as a frame list"),
        ("a" * 5000, "cannot be read as a frame list"),
        ("a.png", "not UTF-8 text"),
    ],
)
def test_what_gives_no_frames_is_an_input_error(tmp_path: Path, text: str, words: str):
    write(tmp_path / "empty.txt", "")
    (tmp_path / "a.png").write_bytes(b"\x89PNG\r\n\x1a\n")
    with pytest.raises(InputError, match=words):
        parse_frames(text, tmp_path)


@pytest.mark.parametrize("ending", [b"\n", b"\r\n", b"\r", b"\x0b", "\u2028".encode()])
def test_a_list_of_too_many_lines_is_refused_before_it_is_split(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ending: bytes
):
    monkeypatch.setattr(evaluated_frames, "MAX_FRAMES", 2)
    (tmp_path / "frames.txt.gz").write_bytes(gzip.compress(b"1" + ending + b"2" + ending))
    assert parse_frames("frames.txt.gz", tmp_path).tolist() == [1, 2]
    (tmp_path / "frames.txt.gz").write_bytes(gzip.compress(ending * 3))
    with pytest.raises(InputError, match="expected at most 2 lines"):
        parse_frames("frames.txt.gz", tmp_path)


def test_every_frame_from_the_first_to_the_last_annotated_one_is_evaluated():
    frames, reason = infer_frames(np.array([3, 4, 7]))
    assert frames.tolist() == [3, 4, 5, 6, 7]
    assert reason == "every frame from the first to the last annotated, 3 to 7"


def test_annotation_of_every_20th_frame_is_evaluated_at_that_step():
    # KAIST: I00019, I00039, ...; one of them without a pedestrian
    annotated = np.delete(np.arange(19, 300, 20), 5)
    frames, reason = infer_frames(annotated)
    assert frames.tolist() == list(range(19, 300, 20))
    assert reason.startswith("every 20th frame from 19 to 299: annotation is sampled")


def test_too_few_annotated_frames_are_not_taken_for_sampling():
    frames, _ = infer_frames(np.arange(MIN_SAMPLED - 1) * 20)
    assert len(frames) == (MIN_SAMPLED - 2) * 20 + 1


def test_a_frame_number_gone_astray_does_not_fill_the_memory():
    with pytest.raises(MissingFactError, match="reaches from frame 1 to 9000000") as raised:
        infer_frames(np.array([1, 900_000_000_000_000]))
    assert raised.value.steps == (Step(Remedy.FRAMES),)


@given(st.sets(st.integers(0, 2000), min_size=1, max_size=60))
def test_every_annotated_frame_is_evaluated(annotated: set[int]):
    frames, _ = infer_frames(np.array(sorted(annotated)))
    assert annotated <= set(frames.tolist())
    assert (frames[0], frames[-1]) == (min(annotated), max(annotated))


@pytest.mark.parametrize("text", ["frames.txt", "0", "1:2:3:4", "0:x", "1" * 20 + ":2"])
def test_other_texts_are_names_of_files(text: str):
    assert not is_frame_range(text)


@pytest.mark.parametrize(
    ("step", "text"),
    [(2, "2nd"), (3, "3rd"), (4, "4th"), (12, "12th"), (21, "21st"), (112, "112th")],
)
def test_a_step_is_told_as_an_ordinal_number(step: int, text: str):
    assert nth(step) == text
