"""A detector run over recordings: every evaluated frame that has a picture, in order."""

from __future__ import annotations

import os
import threading
import time
from concurrent.futures import CancelledError
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest
from picture_files import number_in, numbered, write_numbered_video, write_picture

from nvcore.dataset import Dataset
from nvcore.dataset.provenance import About
from nvcore.detectors.base import Detections, DetectorError, threads_for_a_picture
from nvcore.detectors.run import run_detector
from nvcore.detectors.suppression import sorted_detections
from nvcore.detectors.timing import TIMED_PER_THREAD, expect
from nvcore.errors import InputError
from nvcore.inputs.load import load
from nvcore.inputs.session import Session
from nvcore.inputs.session_toml import read_session
from nvcore.pictures import Picture, RecordingPictures, session_pictures

LOCK = threading.Condition()
PATIENCE_S = 60.0


@dataclass
class Numbers:
    """Finds as many boxes as the number in the picture says, up to 3; slower for odd ones.

    The first pictures wait until as many are looked at at once as `together` says.
    """

    about: About = field(default_factory=lambda: About("test", "Numbers", ("sign",), {}, "f"))
    together: int = 1
    delay_s: float = 0.0
    n_now: int = 0
    most_at_once: int = 0
    seen: list[int] = field(default_factory=list)

    def detect(self, picture: Picture) -> Detections:
        number = number_in(picture)
        with LOCK:
            self.n_now += 1
            self.most_at_once = max(self.most_at_once, self.n_now)
            self.seen.append(number)
            LOCK.notify_all()
            LOCK.wait_for(lambda: self.most_at_once >= self.together, PATIENCE_S)
        time.sleep(self.delay_s * (1 + number % 2))
        with LOCK:
            self.n_now -= 1
        n = number % 4
        box = np.tile([8.0, 4.0, 16.0, 12.0], (n, 1))
        return sorted_detections(box, number + np.arange(n) / 10)


@pytest.fixture
def place(tmp_path: Path) -> Path:
    """A session with two recordings: a video of 12 pictures, and three pictures of six frames."""
    (tmp_path / "truth.csv").write_text(
        "recording,frame,x,y,w,h\nnight,0,1,1,5,9\nnight,11,1,1,5,9\nday,10,1,1,5,9\n"
    )
    write_numbered_video(tmp_path / "night.mp4", n=12)
    for number in (10, 11, 13):
        write_picture(tmp_path / "day" / f"{number}.png", numbered(number))
    (tmp_path / "session.toml").write_text(
        '[defaults]\nsize = "64x48"\nfps = 20\n[truth]\npath = "truth.csv"\n'
        '[[recording]]\nname = "night"\nframes = "0:11"\npictures = "night.mp4"\n'
        '[[recording]]\nname = "day"\nframes = "10:15"\npictures = "day"\n'
    )
    return tmp_path / "session.toml"


def opened(place: Path) -> tuple[Dataset, RecordingPictures]:
    dataset = load(read_session(place, needs_system=False))
    assert isinstance(dataset.settings, Session)
    return dataset, session_pictures(dataset.settings, dataset)


@pytest.mark.parametrize("n_threads", [1, 3])
def test_every_frame_with_a_picture_is_run_in_order(place: Path, n_threads: int):
    detector = Numbers(together=n_threads)
    run = run_detector(detector, *opened(place), n_threads=n_threads)
    night, day = run.recordings
    assert (night.name, day.name) == ("night", "day")
    assert night.frames.tolist() == [*range(12)]
    assert night.boxes["frame"].tolist() == np.repeat(range(12), np.arange(12) % 4).tolist()
    assert night.boxes["score"].tolist()[:3] == [1.0, 2.1, 2.0]
    assert sorted(detector.seen) == sorted([*range(12), 10, 11, 13])
    assert detector.most_at_once == n_threads


def test_frames_without_a_picture_are_counted_and_said(place: Path):
    run = run_detector(Numbers(), *opened(place))
    day = run.recordings[1]
    assert day.frames.tolist() == [10, 11, 13]
    assert (day.n_listed, run.n_pictures, run.n_without) == (6, 15, 3)
    assert "3 of 6 listed frames have no picture" in day.note
    assert run.recordings[0].note == ""


def test_boxes_are_in_pixels_of_the_recording(place: Path):
    text = place.read_text().replace('size = "64x48"', 'size = "128x48"')
    place.write_text(text)
    boxes = run_detector(Numbers(), *opened(place)).recordings[0].boxes
    assert boxes.iloc[0][["x", "y", "w", "h"]].tolist() == [16, 4, 32, 12]


def test_pictures_that_cannot_be_read_are_no_misses(place: Path):
    (place.parent / "day" / "11.png").write_bytes(b"\x89PNG damaged")
    day = run_detector(Numbers(), *opened(place)).recordings[1]
    assert day.frames.tolist() == [10, 13]
    assert "1 picture cannot be read: 11.png" in day.note


def test_recordings_without_pictures_are_left_out(place: Path):
    place.write_text(place.read_text().replace('pictures = "day"\n', ""))
    run = run_detector(Numbers(), *opened(place))
    assert run.recordings[1].frames.tolist() == []
    assert run.recordings[1].note == "no pictures are named for it"
    assert run.n_without == 6


def test_no_picture_at_all_is_an_error(place: Path):
    text = place.read_text().replace('pictures = "day"\n', "")
    place.write_text(text.replace("night.mp4", "gone.mp4"))
    for function in (run_detector, lambda *inputs: expect(inputs[0], *inputs[2:])):
        dataset, pictures = opened(place)
        with pytest.raises(InputError, match=r"has a picture: gone\.mp4: there is no"):
            function(Numbers(), dataset, pictures)


def test_what_the_detector_refuses_ends_the_run(place: Path):
    class Refusing(Numbers):
        def detect(self, picture: Picture) -> Detections:
            raise DetectorError(f"cannot work on {picture.shape}")

    with pytest.raises(DetectorError, match="cannot work"):
        run_detector(Refusing(), *opened(place), n_threads=2)


def test_progress_says_recording_pictures_and_time_left(place: Path):
    told: list[tuple[float, str]] = []
    run_detector(
        Numbers(), *opened(place), progress=lambda share, words: told.append((share, words))
    )
    shares = [share for share, _ in told]
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    assert any(words.startswith("night: 12 of 15 pictures, 0 s left") for _, words in told)


def test_a_cancelled_run_ends_soon(place: Path):
    detector = Numbers(delay_s=0.05)

    def cancel(share: float, _: str) -> None:
        if share > 0.1:
            raise CancelledError

    with pytest.raises(CancelledError):
        run_detector(detector, *opened(place), n_threads=1, progress=cancel)
    assert len(detector.seen) < 8


def test_a_slow_picture_is_no_obstacle_to_cancelling(place: Path):
    def cancel(_share: float, _words: str) -> None:
        if detector.seen:
            raise CancelledError

    detector = Numbers(delay_s=0.5)
    with pytest.raises(CancelledError):
        run_detector(detector, *opened(place), n_threads=1, progress=cancel)
    assert len(detector.seen) == 1


def test_the_expected_time_is_that_of_the_pictures(place: Path):
    dataset, pictures = opened(place)
    began = time.perf_counter()
    expected = expect(Numbers(delay_s=0.02), pictures, n_threads=1)
    most = (time.perf_counter() - began) / TIMED_PER_THREAD  # a busy machine is slower
    assert expected.n_pictures == 15
    assert 0.02 <= expected.seconds_each < most
    assert expected.seconds == 15 * expected.seconds_each
    assert dataset.systems == ()


def test_pictures_are_timed_all_over_the_recordings(place: Path):
    class Plain:
        n, width, height, name, is_video, numbers, notes = 400, 64, 48, "plain", False, None, ()

        def another(self) -> Plain:
            return self

        def read(self, index: int) -> np.ndarray:
            seen.append(index)
            return numbered(1)

        def close(self) -> None:
            pass

    seen: list[int] = []
    indices = {0: np.arange(400), 1: np.arange(400)}
    pictures = RecordingPictures({0: Plain(), 1: Plain()}, indices)  # type: ignore[dict-item]
    expected = expect(Numbers(delay_s=0.1), pictures, n_threads=1)
    assert (expected.n_pictures, expected.n_recordings) == (800, 2)
    # 800 pictures in thirds: their middles are 133 of the first, 0 and 266 of the second recording
    assert {133, 0, 266} <= {*seen}
    assert len(seen) < 60


def test_timing_is_cancelled_while_a_slow_picture_is_timed(place: Path):
    def cancel(_share: float, _words: str) -> None:
        if detector.seen:
            raise CancelledError

    detector = Numbers(delay_s=0.5)
    _, pictures = opened(place)
    with pytest.raises(CancelledError):
        expect(detector, pictures, n_threads=1, progress=cancel)
    assert len(detector.seen) == 1


@pytest.mark.parametrize(("n_threads", "each"), [(1, os.cpu_count()), (2, 1)])
def test_of_several_pictures_at_a_time_each_takes_one_thread(place: Path, n_threads: int, each):
    class Counting(Numbers):
        def detect(self, picture: Picture) -> Detections:
            counts.add(threads_for_a_picture())
            return super().detect(picture)

    counts: set[int] = set()
    run_detector(Counting(), *opened(place), n_threads=n_threads)
    assert counts == {each}
    assert threads_for_a_picture() == os.cpu_count()
