"""A run over pictures: in order, several at a time, and what cannot be read is skipped."""

from __future__ import annotations

import threading
from concurrent.futures import CancelledError
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from picture_files import number_in, numbered, write_picture

from nvcore.common.progress import no_progress
from nvcore.pictures import Picture, open_pictures
from nvcore.pictures.run import PictureRun, speed_text


def test_pictures_that_cannot_be_read_are_skipped_and_no_longer_counted(tmp_path: Path):
    for number in range(8):
        write_picture(tmp_path / f"{number}.png", numbered(number))
    source, faults = open_pictures(tmp_path), list[str]()
    (tmp_path / "3.png").write_bytes(b"\x89PNG damaged")
    told: list[tuple[float, str]] = []
    run = PictureRun(8, lambda *said: told.append(said))
    indices = zip(range(100, 108), range(8), strict=True)
    seen = run.over(source, indices, lambda *of: (of[0], number_in(of[1])), "night", faults)
    assert list(seen) == [(100 + index, index) for index in range(8) if index != 3]
    assert (run.n_done, run.n_pictures, run.seconds > 0) == (7, 7, True)
    assert len(faults) == 1
    assert faults[0].startswith("3.png: ")
    shares, words = zip(*told, strict=True)
    assert list(shares) == sorted(shares)
    assert shares[-1] == 7 / 8
    assert words[-1].startswith("night: 7 of 8 pictures, ")
    assert words[-1].endswith(" left")
    assert list(run.over(source, [(0, 0)], lambda *of: of[0], "dusk", faults)) == [0]
    assert run.n_pictures == 7  # the fault of the night counts once
    assert list(run.over(None, [(0, 0)], number_in, "day", faults)) == []  # type: ignore[arg-type]


@pytest.mark.parametrize("n_threads", [1, 3])
def test_results_come_in_order_whoever_is_first(n_threads: int):
    is_last_done = threading.Event()

    def work(number: int, picture: Picture) -> int:
        if number == n_threads - 1:  # the last of those at work lets the others go on
            is_last_done.set()
        assert is_last_done.wait(30)
        return number + int(picture[0])

    pictures = ((number, np.array([10 * number])) for number in range(20))
    results = PictureRun(20, no_progress, n_threads=n_threads).map(work, pictures, "")
    assert list(results) == [11 * number for number in range(20)]


def test_few_pictures_are_decoded_ahead():
    decoded: list[int] = []

    def pictures():
        for number in range(20):
            decoded.append(number)
            yield number, np.zeros(1)

    for n, _ in enumerate(
        PictureRun(20, no_progress, n_threads=2).map(lambda *of: of, pictures(), "")
    ):
        assert len(decoded) <= n + 5


def test_a_cancelled_run_ends_while_a_picture_is_slow():
    def cancel(share: float, words: str) -> None:
        assert (share, words) == (0, "night: 0 of 1,000 pictures")
        raise CancelledError

    done = threading.Event()
    pictures = ((number, np.zeros(1)) for number in range(1000))
    run = PictureRun(1000, cancel, n_threads=1)
    with pytest.raises(CancelledError):
        list(run.map(lambda *_: done.wait(0.2), pictures, "night"))


def test_the_time_left_is_that_of_the_other_pictures(monkeypatch: pytest.MonkeyPatch):
    now_s = iter([0.0])
    clock = SimpleNamespace(perf_counter=lambda: next(now_s, 10.0))
    monkeypatch.setattr("nvcore.pictures.run.time", clock)
    told: list[tuple[float, str]] = []
    run = PictureRun(4, lambda *said: told.append(said), n_threads=1)
    next(run.map(lambda *of: of, ((number, np.zeros(1)) for number in range(4)), "night"))
    assert told[-1] == (0.25, "night: 1 of 4 pictures, 30 s left")
    assert speed_text(30, 2.0) == "in 2 s (15.0 pictures a second)"
    assert speed_text(0, 0.0) == "in 0 s (0.0 pictures a second)"


def test_a_run_has_a_reader_of_its_own_and_closes_it():
    class Source:
        n_open = 0

        def another(self) -> Source:
            self.n_open += 1
            return self

        def read(self, index: int) -> np.ndarray:
            return np.full(1, index)

        def close(self) -> None:
            self.n_open -= 1

    source = Source()
    indices = ((number, number) for number in range(9))
    results = PictureRun(9, no_progress).over(source, indices, lambda *of: of, "", [])  # type: ignore[arg-type]
    next(results)
    assert source.n_open == 1
    results.close()
    assert source.n_open == 0


def test_an_error_of_the_work_is_that_of_the_run():
    def work(number: int, picture: Picture) -> int:
        raise ValueError(f"picture {number}")

    pictures = ((number, np.zeros(1)) for number in range(9))
    with pytest.raises(ValueError, match="picture 0"):
        list(PictureRun(9, no_progress, n_threads=2).map(work, pictures, ""))
