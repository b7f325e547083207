"""One pass over pictures: in order, several at a time, and what cannot be read is passed over."""

from __future__ import annotations

import threading
from concurrent.futures import CancelledError
from pathlib import Path

import numpy as np
import pytest
from picture_files import number_in, numbered, write_picture

from nvcore.pictures import Picture, open_pictures
from nvcore.pictures.passes import PictureClock, in_order, pictures_of


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for number in range(8):
        write_picture(tmp_path / f"{number}.png", numbered(number))
    return tmp_path


def test_pictures_that_cannot_be_read_are_passed_over_and_said(folder: Path):
    (folder / "3.png").write_bytes(b"\x89PNG damaged")
    faults: list[str] = []
    pictures = pictures_of(
        open_pictures(folder), zip(range(100, 108), range(8), strict=True), faults
    )
    assert [(number, number_in(picture)) for number, picture in pictures] == [
        (100 + index, index) for index in range(8) if index != 3
    ]
    assert len(faults) == 1
    assert faults[0].startswith("3.png: ")


@pytest.mark.parametrize("n_threads", [1, 3])
def test_results_come_in_order_whoever_is_first(n_threads: int):
    is_last_done = threading.Event()

    def work(number: int, picture: Picture) -> int:
        if number == n_threads - 1:  # the last of those at work lets the others go on
            is_last_done.set()
        assert is_last_done.wait(30)
        return number + int(picture[0])

    pictures = ((number, np.array([10 * number])) for number in range(20))
    results = in_order(work, pictures, lambda: None, n_threads=n_threads)
    assert list(results) == [11 * number for number in range(20)]


def test_a_wish_to_stop_ends_the_pass():
    def poll() -> None:
        raise CancelledError

    slow = threading.Event()
    pictures = ((number, np.zeros(1)) for number in range(1000))
    with pytest.raises(CancelledError):
        for _ in in_order(lambda *_: slow.wait(0.2), pictures, poll, n_threads=1):
            pass


def test_an_error_of_the_work_is_that_of_the_pass():
    def work(number: int, picture: Picture) -> int:
        raise ValueError(f"picture {number}")

    with pytest.raises(ValueError, match="picture 0"):
        list(in_order(work, ((n, np.zeros(1)) for n in range(9)), lambda: None, n_threads=2))


def test_the_clock_counts_and_says_what_is_left():
    told: list[tuple[float, str]] = []
    clock = PictureClock(4, lambda share, words: told.append((share, words)))
    clock.count(0, "night")
    clock.count(3, "night")
    assert [share for share, _ in told] == [0.0, 0.75]
    assert told[0][1] == "night: 0 of 4 pictures"
    assert told[1][1].startswith("night: 3 of 4 pictures, ")
