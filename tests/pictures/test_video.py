"""Random access to videos is exact; what is no video, or only a part of one, is said."""

from __future__ import annotations

import random
import re
import struct
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from pathlib import Path
from shutil import copy

import av
import numpy as np
import pytest
from picture_files import HEIGHT, WIDTH, number_in, write_numbered_video
from places import ROOT
from video_files import remux

from nvcore.common.errors import MediaError
from nvcore.pictures import open_pictures, png

UNEVEN = np.cumsum([1 + number * 7 % 5 for number in range(100)]).tolist()
KINDS = {
    "long.mp4": {"g": "250", "bf": "3"},
    "open_gop.mp4": {"x264-params": "open-gop=1:keyint=12:bframes=3:scenecut=0"},
    "uneven.mp4": {"times": UNEVEN, "g": "50", "bf": "3"},
    "uneven.mkv": {"times": UNEVEN, "g": "30", "bf": "2"},
    "reordered.avi": {"g": "25", "bf": "3"},
    "mjpeg.avi": {"codec": "mjpeg", "pixels": "yuvj420p"},
    "mpeg4.avi": {"codec": "mpeg4", "g": "25", "bf": "2"},
    "h264.ts": {"container": "mpegts", "g": "25", "bf": "3"},
    "mpeg2.mpg": {"codec": "mpeg2video", "container": "mpeg", "g": "12", "bf": "2"},
    "shifted.vob": {"codec": "mpeg2video", "container": "vob", "g": "7", "bf": "3"},
    "mpeg2.vob": {"codec": "mpeg2video", "container": "vob", "g": "15", "bf": "2"},
    "vp9.webm": {"codec": "libvpx-vp9", "g": "25"},
}


@pytest.fixture(scope="module")
def whole_video(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    """The video of a name of `KINDS`, coded once."""
    folder = tmp_path_factory.mktemp("whole")
    return cache(lambda name: write_numbered_video(folder / name, **KINDS[name]))


@pytest.mark.parametrize("name", KINDS)
def test_any_picture_is_the_one_asked_for(whole_video, name: str):
    video = open_pictures(whole_video(name))
    asked = [*random.Random(3).choices(range(100), k=20), *range(100), *range(99, 69, -1)]
    wrong = [index for index in asked if number_in(video.read(index)) != index]
    assert (video.n, video.width, video.height, wrong) == (100, WIDTH, HEIGHT, [])


def test_another_reader_of_a_video_has_a_place_of_its_own(tmp_path: Path):
    video = open_pictures(write_numbered_video(tmp_path / "a.mp4", g="50"))
    other = video.another()
    order = [(video, 0), (other, 70), (video, 1), (other, 71), (video, 40)]
    assert [number_in(reader.read(index)) for reader, index in order] == [0, 70, 1, 71, 40]
    picture = other.read(71)
    video.close()
    assert other.read(71) is picture  # what it has decoded stays
    assert number_in(video.read(99)) == 99  # the file is opened again


def test_a_video_states_its_frame_rate_and_a_picture_none(tmp_path: Path):
    video = open_pictures(ROOT / "sample_data" / "odd_pose.mp4")
    (tmp_path / "a.png").write_bytes(png(video.read(0)))
    assert (video.fps, open_pictures(tmp_path / "a.png").fps) == (20, None)


def test_several_threads_read_the_right_pictures(tmp_path: Path):
    video = open_pictures(write_numbered_video(tmp_path / "a.mp4", g="20"))
    asked = random.Random(1).choices(range(100), k=80)
    with ThreadPoolExecutor(4) as pool:
        shown = list(pool.map(lambda index: number_in(video.read(index)), asked))
    assert shown == asked


def test_a_picture_cannot_be_changed_by_who_reads_it(tmp_path: Path):
    picture = open_pictures(write_numbered_video(tmp_path / "a.mp4", n=2)).read(1)
    with pytest.raises(ValueError, match="read-only"):
        picture[0, 0] = 1


def test_grey_pictures_of_16_bit_keep_their_depth(tmp_path: Path):
    path = tmp_path / "a.mkv"
    with av.open(str(path), "w") as output:
        stream = output.add_stream("ffv1", rate=20)
        stream.width, stream.height, stream.pix_fmt = WIDTH, HEIGHT, "gray16le"
        values = np.arange(WIDTH * HEIGHT, dtype=np.uint16).reshape(HEIGHT, WIDTH) + 6743
        output.mux(stream.encode(av.VideoFrame.from_ndarray(values, format="gray16le")))
        output.mux(stream.encode(None))
    picture = open_pictures(path).read(0)
    assert picture.dtype == np.uint16
    np.testing.assert_array_equal(picture, values)


@pytest.mark.parametrize("number", [1, 29])
def test_a_video_does_not_grow_beyond_what_is_read(tmp_path: Path, number: int):
    path = write_numbered_video(tmp_path / "a.webm", codec="libvpx-vp9", n=30, g="1")
    digits, sizes = path.read_bytes().hex(), f"{WIDTH - 1:04x}{HEIGHT - 1:04x}"
    # in each key picture 4 bits after this mark, then width - 1 and height - 1 of 16 bits
    at = [found.start() for found in re.finditer(f"498342.{sizes}", digits)][number]
    path.write_bytes(bytes.fromhex(f"{digits[: at + 11]}fff7{digits[at + 15 :]}"))
    video = open_pictures(path)
    with pytest.raises(MediaError, match=r"a\.webm: states a size of 64 x 65528 px"):
        video.read(number)


@pytest.mark.parametrize("index", [-1, 5])
def test_a_picture_beyond_the_last_is_an_error(tmp_path: Path, index: int):
    video = open_pictures(write_numbered_video(tmp_path / "a.mp4", n=5))
    with pytest.raises(MediaError, match=rf"a\.mp4: there is no picture {index}; there are 5"):
        video.read(index)


def cut(path: Path, share: float) -> Path:
    content = path.read_bytes()
    path.write_bytes(content[: int(len(content) * share)])
    return path


@pytest.mark.parametrize("share", [0.65, 0.74])
@pytest.mark.parametrize(
    "name", ["long.mp4", "mpeg4.avi", "reordered.avi", "uneven.mkv", "h264.ts", "mpeg2.mpg"]
)
def test_what_is_left_of_a_cut_video_is_numbered_rightly(
    tmp_path: Path, whole_video, name: str, share: float
):
    path = Path(copy(whole_video(name), tmp_path))
    if name.endswith("mp4"):
        path = remux(path, tmp_path / f"cut_{name}", movflags="+faststart")
    video = open_pictures(cut(path, share))
    wrong, n_lost = [], 0
    for index in range(video.n):
        try:
            number = number_in(video.read(index))
        except MediaError:
            n_lost += 1
        else:
            wrong += [] if number == index else [(index, number)]
    assert not wrong
    assert 5 < video.n < 100
    assert n_lost < video.n / 2


def test_text_in_another_encoding_does_not_make_a_video_unreadable(tmp_path: Path):
    path = write_numbered_video(tmp_path / "a.mkv")
    path.write_bytes(path.read_bytes().replace(b"Lavf", b"La\xdff"))  # the program that wrote it
    with pytest.raises(UnicodeDecodeError):
        av.open(str(path))
    assert number_in(open_pictures(path).read(7)) == 7


def test_a_cut_video_says_how_many_pictures_can_be_read(tmp_path: Path):
    path = write_numbered_video(tmp_path / "a.mp4", bf="0")
    path = remux(path, tmp_path / "b.mp4", movflags="+faststart")
    video = open_pictures(cut(path, 0.6))
    (note,) = video.notes
    assert note.text == f"{video.n} pictures of 100 can be read: the file is damaged or cut off"


@pytest.mark.parametrize("lost", [1, 50])
def test_a_damaged_picture_costs_only_itself(tmp_path: Path, lost: int):
    path = write_numbered_video(tmp_path / "a.avi", "mjpeg", pixels="yuvj420p")
    content = bytearray(path.read_bytes())
    starts = [at for at in range(len(content)) if content[at : at + 3] == b"\xff\xd8\xff"]
    content[starts[lost] : starts[lost + 1] - 8] = bytes(starts[lost + 1] - 8 - starts[lost])
    path.write_bytes(content)
    video = open_pictures(path)
    with pytest.raises(MediaError, match=f"picture {lost} cannot be decoded: the video is damag"):
        video.read(lost)
    assert [number_in(video.read(index)) for index in (0, lost + 1, 99)] == [0, lost + 1, 99]


PLAYLIST = "#EXTM3U\n#EXT-X-TARGETDURATION:10\n#EXTINF:10,\n{}\n#EXT-X-ENDLIST\n"
CONCAT = "ffconcat version 1.0\nfile {}\n"


@pytest.mark.parametrize("script", [PLAYLIST, CONCAT, "[playlist]\nFile1={}\n", "<MPD>{}</MPD>"])
def test_a_script_named_like_a_video_reads_no_other_file(tmp_path: Path, script: str):
    secret = write_numbered_video(tmp_path / "secret.mp4", n=3)
    path = tmp_path / "a.mp4"
    path.write_text(script.format(secret))
    with pytest.raises(MediaError, match=r"a\.mp4: is text, not pictures; expected a video"):
        open_pictures(path)


def test_a_name_that_looks_like_a_protocol_is_only_a_name(tmp_path: Path, monkeypatch):
    write_numbered_video(tmp_path / "concat:b.mp4", n=3, container="mp4")
    monkeypatch.chdir(tmp_path)
    assert open_pictures(Path("concat:b.mp4")).n == 3


def test_pictures_of_an_unknown_coding_are_refused(tmp_path: Path):
    path = write_numbered_video(tmp_path / "a.mkv", "mpeg4", n=3, container="matroska")
    content = path.read_bytes()
    assert b"V_MPEG4/ISO/ASP" in content
    path.write_bytes(content.replace(b"V_MPEG4/ISO/ASP", b"V_MYOWN/ISO/ASP"))
    with pytest.raises(MediaError, match=r"a\.mkv: its pictures are coded in a way that is not k"):
        open_pictures(path)


def test_a_container_of_sound_only_is_refused(tmp_path: Path):
    path = tmp_path / "a.mp4"
    with av.open(str(path), "w") as output:
        stream = output.add_stream("aac", rate=8000, layout="mono")
        frame = av.AudioFrame.from_ndarray(np.zeros((1, 1024), np.float32), "fltp", "mono")
        frame.sample_rate = 8000
        output.mux(stream.encode(frame))
        output.mux(stream.encode(None))
    with pytest.raises(MediaError, match=r"a\.mp4: holds no pictures, only sound or data"):
        open_pictures(path)


def test_a_video_that_states_an_absurd_size_is_refused_unread(tmp_path: Path):
    path = write_numbered_video(tmp_path / "a.avi", "mjpeg", n=2, pixels="yuvj420p")
    content = bytearray(path.read_bytes())
    starts = [at for at in range(len(content)) if content[at : at + 4] == b"\xff\xc0\x00\x11"]
    assert len(starts) == 2
    for at in starts:
        struct.pack_into(">2H", content, at + 5, 60_000, 60_000)
    path.write_bytes(content)
    with pytest.raises(MediaError, match=r"a\.avi: (is|its first picture|states)"):
        open_pictures(path)
