"""A detector run over recordings: every evaluated frame that has a picture, in order."""

from __future__ import annotations

import os
import threading
from concurrent.futures import CancelledError
from dataclasses import dataclass, field
from itertools import chain, count
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from picture_files import number_in, numbered, write_numbered_video, write_picture

from nvcore.common.errors import InputError
from nvcore.dataset import Dataset
from nvcore.dataset.provenance import About
from nvcore.inputs.load import load
from nvcore.inputs.session import Session
from nvcore.inputs.session.toml import read_session
from nvcore.pictures import Picture, RecordingPictures, session_pictures
from nvcore.subjects.detectors.base import Detections, threads_for_a_picture
from nvcore.subjects.detectors.running import run as run_module
from nvcore.subjects.detectors.running.run import Expectation, expect, run_detector
from nvcore.subjects.detectors.suppression import sorted_detections

LOCK = threading.Condition()
PATIENCE_S = 60.0


@dataclass
class Numbers:
    """Finds as many boxes as the number in the picture says, up to 3.

    The first pictures wait until as many are looked at at once as `together` says.
    """

    about: About = field(default_factory=lambda: About("test", "Numbers", ("sign",), {}, "f"))
    together: int = 1
    n_now: int = 0
    most_at_once: int = 0
    seen: list[int] = field(default_factory=list)
    threads: set[int] = field(default_factory=set)

    def detect(self, picture: Picture) -> Detections:
        number = number_in(picture)
        with LOCK:
            self.n_now += 1
            self.most_at_once = max(self.most_at_once, self.n_now)
            self.seen.append(number)
            self.threads.add(threads_for_a_picture())
            LOCK.notify_all()
            LOCK.wait_for(lambda: self.most_at_once >= self.together, PATIENCE_S)
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


@pytest.mark.parametrize(("n_threads", "each"), [(1, os.cpu_count()), (3, 1)])
def test_every_frame_with_a_picture_is_run_in_order(place: Path, n_threads: int, each: int):
    detector, told = Numbers(together=n_threads), list[tuple[float, str]]()
    progress = {"progress": lambda *said: told.append(said)}
    run = run_detector(detector, *opened(place), n_threads=n_threads, **progress)
    night, day = run.recordings
    assert (night.name, day.name) == ("night", "day")
    assert night.frames.tolist() == [*range(12)]
    assert night.boxes["frame"].tolist() == np.repeat(range(12), np.arange(12) % 4).tolist()
    assert night.boxes["score"].tolist()[:3] == [1.0, 2.1, 2.0]
    assert sorted(detector.seen) == sorted([*range(12), 10, 11, 13])
    assert detector.most_at_once == n_threads
    assert detector.threads == {each}  # of several pictures at a time each takes one thread
    assert threads_for_a_picture() == os.cpu_count()
    shares = [share for share, _ in told]
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    assert any(words.startswith("night: 12 of 15 pictures, 0 s left") for _, words in told)


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


@dataclass
class Plain:
    """Pictures that are all alike."""

    seen: list[int] = field(default_factory=list)
    n, width, height, name, is_video, numbers, notes = 400, 64, 48, "plain", False, None, ()

    def another(self) -> Plain:
        return self

    def read(self, index: int) -> np.ndarray:
        self.seen.append(index)
        return numbered(1)

    def close(self) -> None:
        pass


@pytest.mark.parametrize(
    ("n_pictures", "each_s", "n_timed"), [(15, 0.25, 4), (15, 1.0, 3), (1, 5.0, 1)]
)
def test_the_expected_time_is_that_of_the_pictures_after_the_first(
    monkeypatch: pytest.MonkeyPatch, n_pictures: int, each_s: float, n_timed: int
):
    told_s: list[float] = []
    times_s = chain([0.0], count(5.0, each_s))  # the first picture takes five seconds

    def now_s() -> float:
        told_s.append(next(times_s))
        return told_s[-1]

    monkeypatch.setattr(run_module, "time", SimpleNamespace(perf_counter=now_s))
    pictures = RecordingPictures({0: Plain()}, {0: np.arange(n_pictures)})  # type: ignore[dict-item]
    expected = expect(Numbers(), pictures, n_threads=1)
    assert expected == Expectation(n_pictures, 1, 1, each_s)
    assert expected.seconds == n_pictures * each_s
    assert len(told_s) == 1 + n_timed


def test_pictures_are_timed_all_over_the_recordings(monkeypatch: pytest.MonkeyPatch):
    now_s = count(0, 0.25)
    monkeypatch.setattr(run_module, "time", SimpleNamespace(perf_counter=lambda: next(now_s)))
    source, indices = Plain(), {0: np.arange(400), 1: np.arange(400)}
    pictures = RecordingPictures({0: source, 1: source}, indices)  # type: ignore[dict-item]
    expected = expect(Numbers(), pictures, n_threads=1)
    # 800 pictures in thirds: their middles are 133 of the first, 0 and 266 of the second recording
    assert {133, 0, 266} <= {*source.seen}
    assert len(source.seen) <= 3 * 7  # 4 until half a second has passed, and those decoded ahead
    assert str(expected) == (
        "800 pictures of 2 recordings on 1 thread: about 200 s (0.25 s a picture)"
    )


def test_timing_may_be_cancelled(place: Path):
    def cancel(share: float, words: str) -> None:
        assert (share, words) == (0, "timing it")
        raise CancelledError

    with pytest.raises(CancelledError):
        expect(Numbers(), opened(place)[1], n_threads=1, progress=cancel)
