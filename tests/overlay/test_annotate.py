"""Annotated frames and videos: the right picture, the right boxes, and where they come from."""

from __future__ import annotations

import json
import math
from concurrent.futures import CancelledError
from pathlib import Path
from typing import Any

import av
import cv2
import numpy as np
import pytest
from builders import Place, make_dataset, result_of
from picture_files import number_in, numbered, write_numbered_video, write_picture

from nvcore import __version__
from nvcore.common.errors import MediaError, ParameterError
from nvcore.comparison.compare import Result
from nvcore.figures.overlay import annotate, frame_png, write_video
from nvcore.figures.overlay.brush import BLANK_RGB, X_RGB, Y_RGB
from nvcore.pictures import open_pictures


def result(n_frames: int = 10, **params: float) -> Result:
    """A pedestrian at the right whom X finds and Y misses, in frames 0 and 1."""
    person = [(frame, 50.0, 10.0, 8.0, 30.0, 7) for frame in (0, 1)]
    return result_of(
        make_dataset(person, [box[:5] for box in person], n_frames=n_frames, width=64, height=48),
        **params,
    )


def block_number(canvas: np.ndarray) -> int:
    """The number in the pixels of a drawing that is enlarged eight times."""
    return number_in(canvas[:384:8, ::8])


def test_a_frame_shows_its_picture(tmp_path: Path):
    video = open_pictures(write_numbered_video(tmp_path / "a.mp4", n=10))
    for row in (7, 2, 9):
        drawn = annotate(result(), video, row, row, layers=())
        assert block_number(drawn) == row


def test_layers_choose_what_is_drawn():
    def has(colour: tuple[int, int, int], *layers: str) -> bool:
        drawn = annotate(result(), None, -1, 0, layers=layers, caption=False)
        return bool(np.all(drawn == colour, axis=2).any())

    assert has(X_RGB, "x")
    assert has(Y_RGB, "truth")  # the mark of Y's miss
    assert not has(Y_RGB, "x", "y")
    assert not has(X_RGB, "truth", "y")
    assert not has(Y_RGB, "truth", "x")  # nor Y's misses where X is shown alone


def test_the_caption_is_below_and_can_be_left_out():
    plain = annotate(result(), None, -1, 0, caption=False)
    whole = annotate(result(), None, -1, 0)
    assert plain.shape == (384, 512, 3)
    assert whole.shape[0] > 384
    assert whole.shape[0] % 2 == 0
    np.testing.assert_array_equal(whole[:384], plain)
    assert np.any(whole[384:] != BLANK_RGB)


def test_a_changed_setting_changes_the_caption():
    usual, changed = (annotate(result(alpha=a), None, -1, 5)[384:] for a in (0.9, 0.5))
    assert usual.shape != changed.shape or np.any(usual != changed)


def test_many_changed_settings_are_told_in_further_lines():
    few = result(alpha=0.8)
    more = {"lag_s": 1.0, "gap_s": 1.0, "coverage": 0.4, "window": 2.0, "iou": 0.4}
    many = result(alpha=0.8, low=0.7, tolerance=0.1, threshold_x=0.25, threshold_y=0.75, **more)
    heights = [annotate(made, None, -1, 5).shape[0] for made in (few, many)]
    assert heights[0] < heights[1]


def test_labels_are_written_if_asked_for():
    plain, labelled = (
        annotate(result(), None, -1, 0, labels=labels, caption=False) for labels in (0, 1)
    )
    assert np.any(plain != labelled)


def test_a_dim_picture_is_stretched(tmp_path: Path):
    picture = numbered(5) // 8
    pictures = open_pictures(write_picture(tmp_path / "0.png", picture))
    unspread = annotate(result(2), pictures, 0, 0, layers=(), caption=False)
    spread = annotate(result(2), pictures, 0, 0, layers=(), caption=False, lo=0, hi=99)
    assert (unspread.max(), spread.max()) == (31, 255)


def test_a_picture_that_cannot_be_decoded_leaves_a_dark_blank(tmp_path: Path):
    for number in range(3):
        write_picture(tmp_path / f"{number}.png", numbered(255))
    (tmp_path / "1.png").write_bytes(b"\x89PNG\r\n\x1a\n")
    pictures = open_pictures(tmp_path)
    drawn = annotate(result(3), pictures, 1, 1, layers=(), caption=False)
    assert np.all(drawn[100:] == BLANK_RGB)


def test_a_frame_as_png_holds_version_and_settings():
    made = result(alpha=0.75)
    content = frame_png(annotate(made, None, -1, 0), made)
    start = content.index(b"tEXtComment\0") + 12
    told = json.loads(content[start : content.index(b"}}", start) + 2])
    assert told["program"] == f"nvcore {__version__}"
    assert told["fingerprint"] == made.dataset.fingerprint
    assert told["parameters"]["alpha"] == 0.75
    decoded = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_COLOR)
    np.testing.assert_array_equal(decoded[..., ::-1], annotate(made, None, -1, 0))


def test_a_video_holds_the_frames_asked_for_and_where_they_come_from(tmp_path: Path):
    video = open_pictures(write_numbered_video(tmp_path / "a.mp4", n=10))
    shares: list[float] = []
    path = tmp_path / "out.mp4"

    def note(share: float, _what: str) -> None:
        shares.append(share)

    made, every = result(alpha=0.75), np.arange(10)
    write_video(made, {0: video}, 0, 3, 8, path, fps=12.5, progress=note, indices=every)
    assert shares == sorted(shares)
    assert {*shares} >= {0.2, 0.4, 0.6, 0.8, 1.0}
    with av.open(str(path)) as container:
        stream = container.streams.video[0]
        assert (float(stream.average_rate), stream.codec.name) == (12.5, "vp9")
        told = json.loads(container.metadata["comment"])
        assert told["parameters"]["alpha"] == 0.75
        assert container.metadata["title"] == f"r0, frames 3 to 7: x and y, nvcore {__version__}"
        shown = [frame.to_ndarray(format="rgb24") for frame in container.decode(stream)]
    assert [block_number(picture) for picture in shown] == [3, 4, 5, 6, 7]


def test_a_video_shows_the_pictures_that_are_said_to_be_of_its_frames(tmp_path: Path):
    source = open_pictures(write_numbered_video(tmp_path / "in.mp4", n=10))
    path = tmp_path / "out.mp4"
    write_video(result(), {0: source}, 0, 4, 6, path, fps=20, indices=np.arange(-1, 9))
    with av.open(str(path)) as video:
        shown = [block_number(frame.to_ndarray(format="rgb24")) for frame in video.decode(video=0)]
    assert shown == [3, 4]


@pytest.mark.parametrize("error", [CancelledError, KeyboardInterrupt])
def test_stopping_and_an_error_on_the_way_leave_no_file(tmp_path: Path, error: type[BaseException]):
    def stop(share: float, _what: str) -> None:
        if share >= 0.5:
            raise error

    path = tmp_path / "out.mp4"
    path.write_bytes(b"of an earlier run")
    with pytest.raises(error):
        write_video(result(), {}, 0, 0, 10, path, fps=20, progress=stop)
    assert not path.exists()


@pytest.mark.parametrize(
    ("given", "words"),
    [
        *(({"fps": fps}, r"fps: expected 0\.1 to 240") for fps in (0.0, -1.0, math.nan, 1000.0)),
        ({"indices": np.arange(3)}, "expected 10 pictures, got 3"),
    ],
)
def test_an_impossible_frame_rate_and_pictures_of_other_frames_are_refused(
    tmp_path: Path, given: dict[str, Any], words: str
):
    with pytest.raises(ParameterError, match=words):
        write_video(result(), {}, 0, 0, 2, tmp_path / "out.mp4", **{"fps": 20, **given})


def test_a_video_without_pictures_is_boxes_on_a_dark_blank(tmp_path: Path):
    write_video(result(), {}, 0, 0, 2, tmp_path / "out.mp4", fps=20)
    picture = open_pictures(tmp_path / "out.mp4").read(1)
    assert np.abs(picture[200, 20].astype(int) - BLANK_RGB).max() < 8


def test_a_video_is_as_high_as_its_longest_caption(tmp_path: Path):
    made = result_of(make_dataset(places=[Place([0, 10**9], 64, 48)]))
    heights = [annotate(made, None, -1, row).shape[0] for row in (0, 1)]
    write_video(made, {}, 0, 0, 2, tmp_path / "out.mp4", fps=20)
    pictures = open_pictures(tmp_path / "out.mp4")
    assert heights[0] < heights[1] == pictures.height
    pictures.close()


@pytest.mark.parametrize("name", ["missing/out.mp4", "."])
def test_a_place_that_cannot_be_written_to_is_an_error(tmp_path: Path, name: str):
    with pytest.raises(MediaError, match="the video cannot be written; is there room"):
        write_video(result(), {}, 0, 0, 2, tmp_path / name, fps=20)


@pytest.mark.parametrize(("start", "stop"), [(0, 0), (3, 2), (2, 6), (-1, 2)])
def test_frames_of_another_recording_are_refused(tmp_path: Path, start: int, stop: int):
    places = [Place(range(5), 64, 48), Place(range(5), 64, 48)]
    made = result_of(make_dataset(places=places))
    with pytest.raises(ParameterError, match="expected frames of the recording, rows 0 to 5"):
        write_video(made, {}, 0, start, stop, tmp_path / "out.mp4", fps=20)
    write_video(made, {}, 1, 5, 7, tmp_path / "out.mp4", fps=20)
    assert (tmp_path / "out.mp4").exists()
