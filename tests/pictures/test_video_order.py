"""Pictures of videos as cameras, phones and editors write them are those that players show."""

from __future__ import annotations

import random
from collections.abc import Callable, Collection
from fractions import Fraction
from functools import cache
from pathlib import Path
from shutil import copy

import av
import cv2
import numpy as np
import pytest
from picture_files import number_in, write_numbered_video
from video_files import (
    cut_without_reencoding,
    edited,
    field_pictures,
    hiding,
    remux,
    rewrite_chunks,
    with_empty_chunks,
    with_packed_pictures,
    with_uncoded_pictures,
)

from nvcore.common.errors import MediaError
from nvcore.pictures import Pictures, open_pictures
from nvcore.pictures.notes import PictureNote, PictureTrait
from nvcore.pictures.video_frames import frame_rate, time_notes, usual_step

CODINGS = {
    "h264.mp4": {"g": "12", "bf": "2"},
    "open_gop.mp4": {"x264-params": "open-gop=1:keyint=12:bframes=3:scenecut=0"},
    "long.mov": {"g": "250", "bf": "3"},
    "no_b.mp4": {"g": "12", "bf": "0"},
    "hevc.mp4": {"codec": "libx265", "x265-params": "keyint=30:bframes=3:log-level=none"},
    "hevc_open.mp4": {
        "codec": "libx265",
        "x265-params": "keyint=12:open-gop=1:bframes=4:log-level=none",
    },
}
EDITS: dict[str, list[tuple[int, int | None]]] = {
    "begins later": [(10, None), (100, 0)],
    "middle": [(50, 30)],
    "skips": [(20, 10), (20, 60)],
    "repeats": [(30, 10), (30, 25)],
    "goes back": [(10, 50), (10, 5), (20, 70)],
}


def numbers_of(video: Pictures) -> list[int]:
    """As read one after another; each is the same when it is read out of order."""
    numbers = [number_in(video.read(index)) for index in range(video.n)]
    for index in random.Random(3).choices(range(video.n), k=20):
        assert number_in(video.read(index)) == numbers[index]
    return numbers


def played(path: Path) -> list[int]:
    """The numbers as the file is decoded from its start to its end."""
    with av.open(str(path)) as video:
        return [
            number_in(frame.to_ndarray(format="gray", threads=1)) for frame in video.decode(video=0)
        ]


def captured(path: Path) -> list[int]:
    """The numbers as OpenCV reads them."""
    capture, numbers = cv2.VideoCapture(str(path)), []
    while (read := capture.read())[0]:
        numbers.append(number_in(read[1]))
    return numbers


@pytest.fixture(scope="module")
def whole_video(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    """The video of a name of `CODINGS`, coded once."""
    folder = tmp_path_factory.mktemp("whole")
    return cache(lambda name: write_numbered_video(folder / name, **CODINGS[name]))


@pytest.mark.parametrize("first", [1, 25])
@pytest.mark.parametrize("name", CODINGS)
def test_pictures_before_a_cut_are_hidden_and_those_after_it_shown(
    tmp_path: Path, whole_video, name: str, first: int
):
    path = cut_without_reencoding(whole_video(name), tmp_path / f"cut_{name}", first)
    video = open_pictures(path)
    assert numbers_of(video) == played(path) == captured(path) == [*range(first, 100)]
    assert (video.notes, video.fps) == ((), 20)


@pytest.mark.parametrize("edits", EDITS.values(), ids=EDITS)
@pytest.mark.parametrize("name", ["open_gop.mp4", "long.mov", "no_b.mp4", "hevc_open.mp4"])
def test_an_edit_list_is_followed_as_players_do(
    tmp_path: Path, whole_video, name: str, edits: list[tuple[int, int | None]]
):
    path = edited(Path(copy(whole_video(name), tmp_path)), edits)
    video = open_pictures(path)
    assert numbers_of(video) == played(path)
    assert not any(note.trait is PictureTrait.CUT for note in video.notes)


def test_a_cut_file_with_an_edit_list_is_still_said_to_be_cut(tmp_path: Path):
    path = write_numbered_video(tmp_path / "a.mp4", g="12", bf="0")
    path = cut_without_reencoding(path, tmp_path / "b.mp4", 5)
    path = remux(path, tmp_path / "c.mp4", movflags="+faststart")
    path.write_bytes(path.read_bytes()[: path.stat().st_size * 3 // 4])
    video = open_pictures(path)
    assert [note.trait for note in video.notes] == [PictureTrait.CUT]
    assert numbers_of(video) == [*range(5, 5 + video.n)]


@pytest.mark.parametrize(
    ("packets", "whole"),
    [
        ("both times", ()),
        ("first time", ()),
        ("same time", ()),
        ("joined", ()),
        ("both times", range(1, 24)),
        ("both times", range(12)),
        ("first time", {*range(24)} - {13}),
    ],
)
@pytest.mark.parametrize("ending", ["ts", "mp4", "mkv"])
def test_two_fields_are_one_picture_also_among_whole_frames(
    tmp_path: Path, ending: str, packets: str, whole: Collection[int]
):
    path = field_pictures(tmp_path / f"a.{ending}", packets=packets, whole=whole)
    video = open_pictures(path)
    assert numbers_of(video) == played(path) == [*range(24)]
    assert (video.fps, video.notes) == (25, ())


def test_small_packets_of_mpeg4_keep_the_rate_of_its_times(tmp_path: Path):
    path = tmp_path / "a.mkv"
    with av.open(str(path), "w") as output:
        stream = output.add_stream("mpeg4", rate=1000)
        stream.width, stream.height, stream.pix_fmt = 16, 16, "yuv420p"
        for number in range(20):
            frame = av.VideoFrame.from_ndarray(np.full((16, 16), 90, np.uint8), format="gray")
            frame.pts, frame.time_base = 50 * number, Fraction(1, 1000)
            output.mux(stream.encode(frame))
        output.mux(stream.encode(None))
    assert (open_pictures(path).n, open_pictures(path).fps) == (20, 20)


@pytest.mark.parametrize(("ending", "per_second"), [("ts", 25), ("mkv", 60)])
def test_fields_at_other_times_than_the_stream_states_are_shown_at_its_rate(
    tmp_path: Path, ending: str, per_second: int
):
    video = open_pictures(field_pictures(tmp_path / f"a.{ending}", per_second=per_second))
    assert (video.n, video.fps) == (24, 25)


@pytest.mark.parametrize("share", [0.2, 0.6])
def test_a_stream_that_begins_in_the_middle_shows_what_can_be_decoded(tmp_path: Path, share: float):
    path = field_pictures(tmp_path / "a.ts")
    content = path.read_bytes()
    path.write_bytes(content[188 * int(len(content) * share / 188) :])
    numbers = numbers_of(open_pictures(path))
    assert numbers == [*range(24 - len(numbers), 24)]
    assert abs(len(numbers) - 24 * (1 - share)) < 2


@pytest.mark.parametrize("ending", ["avi", "mkv", "mp4"])
def test_packed_pictures_are_shown_in_their_order(tmp_path: Path, ending: str):
    path = write_numbered_video(tmp_path / "a.avi", "mpeg4", g="12", bf="1")
    path = with_packed_pictures(path)
    if ending != "avi":
        path = remux(path, tmp_path / f"b.{ending}")
    video = open_pictures(path)
    assert numbers_of(video) == captured(path) == [*range(100)]
    assert video.notes == ()


@pytest.mark.parametrize(
    "empty", [{20, 21, 40}, {0, 1, 50}, {58, 59, 60}], ids=["within", "first", "last"]
)
@pytest.mark.parametrize(
    ("codec", "options"),
    [
        ("mjpeg", {"pixels": "yuvj420p"}),
        ("mpeg4", {"bf": "2"}),
        ("libx264", {"bf": "0", "x264-params": "b-adapt=0:scenecut=0"}),
        ("libx264", {"bf": "2", "x264-params": "b-adapt=0:scenecut=0"}),
    ],
)
def test_an_empty_chunk_of_an_avi_repeats_the_picture_before(
    tmp_path: Path, codec: str, options: dict[str, str], empty: set[int]
):
    path = write_numbered_video(tmp_path / "a.avi", codec, n=61, **options)
    video = open_pictures(
        rewrite_chunks(
            path, lambda chunks: [b"" if n in empty else chunks.pop(0) for n in range(61)]
        )
    )
    held = [n for n in range(61) if n not in empty]
    right = np.maximum(np.searchsorted(held, range(61), "right") - 1, 0)
    assert numbers_of(video) == right.tolist()
    assert video.notes == (PictureNote(PictureTrait.REPEATED, 3, 61, tuple(sorted(empty))),)


@pytest.mark.parametrize("is_packed", [False, True])
def test_empty_chunks_that_fill_the_delay_of_an_encoder_are_no_pictures(
    tmp_path: Path, is_packed: bool
):
    path = write_numbered_video(tmp_path / "a.avi", "mpeg4", n=61, g="12", bf="1")
    path = with_packed_pictures(path) if is_packed else path
    video = open_pictures(rewrite_chunks(path, lambda chunks: [chunks[0], b"", b"", *chunks[1:-2]]))
    assert numbers_of(video) == captured(path) == played(path)
    assert video.notes == ()


def test_empty_chunks_that_fill_a_rate_of_no_pictures_are_none(tmp_path: Path):
    path = write_numbered_video(tmp_path / "a.avi", "mjpeg", n=20, pixels="yuvj420p")
    path = rewrite_chunks(path, lambda chunks: [part for c in chunks for part in (c, *[b""] * 9)])
    video = open_pictures(path)
    assert numbers_of(video) == captured(path) == [*range(20)]
    assert (video.notes, video.fps) == ((), 2)


@pytest.mark.parametrize("b", ["0", "2"])
def test_mpeg4_that_begins_between_key_pictures_is_counted_as_decoders_do(tmp_path: Path, b: str):
    path = write_numbered_video(tmp_path / "a.avi", "mpeg4", n=60, g="12", bf=b)
    video = open_pictures(rewrite_chunks(path, lambda chunks: chunks[17:]))
    numbers = played(path)
    assert numbers_of(video)[: len(numbers)] == captured(path) == numbers


@pytest.mark.parametrize("share", [0.8, 1])
def test_a_picture_of_mpeg4_that_is_not_coded_repeats_the_one_before(tmp_path: Path, share: float):
    path = write_numbered_video(tmp_path / "a.avi", "mpeg4", g="1", bf="0")
    path = with_uncoded_pictures(path, {20, 21, 40})
    path.write_bytes(path.read_bytes()[: int(path.stat().st_size * share)])
    video = open_pictures(path)
    right = [{20: 19, 21: 19, 40: 39}.get(number, number) for number in range(video.n)]
    assert numbers_of(video) == right
    notes = [PictureNote(PictureTrait.REPEATED, 3, video.n, (20, 21, 40))]
    if share < 1:
        notes.insert(0, PictureNote(PictureTrait.CUT, video.n, 100))
    assert video.notes == (*notes,)
    assert (video.n == 100) == (share == 1)


@pytest.mark.parametrize("ending", ["webm", "mkv"])
def test_a_picture_that_only_helps_to_decode_others_is_not_counted(tmp_path: Path, ending: str):
    path = write_numbered_video(tmp_path / f"a.{ending}", "libvpx", g="25", deadline="realtime")
    path = hiding(path, tmp_path / f"b.{ending}", 30)
    right = [number for number in range(100) if number != 30]
    assert numbers_of(open_pictures(path)) == played(path) == captured(path) == right


def test_h264_in_an_avi_with_empty_chunks_is_counted_by_decoding(tmp_path: Path):
    path = write_numbered_video(tmp_path / "a.avi", g="12", bf="2")
    path = with_empty_chunks(path, {40, 50})
    video = open_pictures(path)
    assert numbers_of(video) == played(path)
    assert [note.trait for note in video.notes] == [PictureTrait.GAP]


@pytest.mark.parametrize("ending", ["mp4", "mkv", "ts"])
def test_pictures_that_were_not_recorded_do_not_slow_the_rate_down(tmp_path: Path, ending: str):
    times = [*range(20), *range(30, 60)]
    path = write_numbered_video(tmp_path / f"a.{ending}", n=50, times=times)
    video = open_pictures(path)
    assert video.fps == 20
    assert video.notes == (PictureNote(PictureTrait.GAP, 10, 60, (20,)),)
    np.testing.assert_allclose(video.times_s, np.array(times) / 20, atol=1e-3)


def test_a_gap_near_the_end_of_a_whole_file_is_no_damage(tmp_path: Path):
    times = [*range(48), 70, 71]
    video = open_pictures(write_numbered_video(tmp_path / "a.mp4", n=50, times=times, bf="3"))
    assert video.notes == (PictureNote(PictureTrait.GAP, 22, 72, (48,)),)
    assert numbers_of(video) == [*range(50)]


def test_a_rate_that_varies_is_noted(tmp_path: Path):
    times = np.cumsum(np.random.default_rng(1).integers(2, 6, 50)).tolist()
    [note] = open_pictures(write_numbered_video(tmp_path / "a.mp4", n=50, times=times)).notes
    assert (note.trait, note.total) == (PictureTrait.UNEVEN, 49)


@pytest.mark.parametrize("second", [1000, 20, 0, -500])
def test_joined_files_are_shown_one_after_the_other(tmp_path: Path, second: int):
    parts = b""
    for start in (500, 500 + second):
        times = [*range(start, start + 50)]
        part = write_numbered_video(tmp_path / "part.ts", n=50, times=times, g="25", bf="2")
        parts += part.read_bytes()
    path = tmp_path / "a.ts"
    path.write_bytes(parts)
    assert numbers_of(open_pictures(path)) == played(path) == captured(path) == [*range(50)] * 2


def two_streams(path: Path, default: int) -> Path:
    with av.open(str(path), "w") as output:
        streams = []
        for number in range(2):
            stream = output.add_stream("mpeg4", rate=20)
            stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv420p"
            stream.disposition = av.stream.Disposition(number == default)
            streams.append(stream)
        for number, stream in enumerate(streams):
            for _ in range(5):
                grey = np.full((48, 64), 100 * number + 50, np.uint8)
                output.mux(stream.encode(av.VideoFrame.from_ndarray(grey, format="gray")))
            output.mux(stream.encode(None))
    return path


@pytest.mark.parametrize("default", [0, 1])
def test_of_two_streams_the_default_is_shown_and_the_other_said(tmp_path: Path, default: int):
    video = open_pictures(two_streams(tmp_path / "a.mkv", default))
    assert abs(int(video.read(0)[20, 20, 0]) - (100 * default + 50)) < 10
    names = ("mpeg4 64 x 48",)
    assert video.notes == (PictureNote(PictureTrait.OTHER_STREAMS, 1, names=names),)


def test_a_fragmented_mp4_that_ends_early_is_said_to_be_cut(tmp_path: Path):
    whole = write_numbered_video(tmp_path / "a.mp4", n=60, g="12")
    path = remux(whole, tmp_path / "b.mp4", movflags="frag_keyframe+empty_moov")
    assert open_pictures(path).notes == ()
    path.write_bytes(path.read_bytes()[: path.stat().st_size * 2 // 3])
    video = open_pictures(path)
    assert numbers_of(video) == [*range(video.n)]
    assert [note.trait for note in video.notes] == [PictureTrait.CUT]


def test_a_recording_that_was_not_closed_is_refused_with_what_may_help(tmp_path: Path):
    path = write_numbered_video(tmp_path / "a.mp4")
    content = path.read_bytes()
    path.write_bytes(content[: content.rindex(b"moov") - 4])
    with pytest.raises(MediaError, match=r"a\.mp4: has no table of contents .*untrunc.*Matroska"):
        open_pictures(path)


@pytest.mark.parametrize(
    ("times", "step", "traits"),
    [
        ([], 0, []),
        ([7], 0, []),
        ([0, 2, 4, 10], 2, [PictureTrait.GAP]),
        ([0, 2, 12], 2, [PictureTrait.GAP]),
        ([4, 2, 0], 0, []),
        ([0, 4, 1, 8], 4, []),
        ([-(2**63), 0, 2**63 - 1], 2**63, []),
    ],
)
def test_the_commonest_step_is_told_of_any_times(times: list[int], step: float, traits: list):
    array = np.array(times, np.int64)
    assert usual_step(array) == step
    assert [note.trait for note in time_notes(array)] == traits


@pytest.mark.parametrize(
    ("step_s", "stated", "rate"),
    [
        (0.05, 50 / 3, 20),
        (0, 25, 25),
        (0.03333, None, 30),
        (0.03337, None, 30 / 1.001),
        (0.03334, 29.99, 29.99),
        (1 / 8.6, None, 8.6),
        (0, None, None),
    ],
)
def test_the_rate_is_that_of_the_step_where_the_stated_one_differs(step_s, stated, rate):
    assert frame_rate(step_s, stated) == pytest.approx(rate)
