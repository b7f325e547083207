"""A file that states millions of samples in a few bytes is refused before it takes memory."""

from __future__ import annotations

import struct
from pathlib import Path

import av
import numpy as np
import pytest
from picture_files import write_numbered_video

from nvcore.common.errors import MediaError
from nvcore.pictures import open_pictures
from nvcore.pictures.containers import MOST_SAMPLES, check_samples

MILLIONS = 85_000_000


def box(kind: bytes, *content: bytes) -> bytes:
    return struct.pack(">I4s", 8 + sum(map(len, content)), kind) + b"".join(content)


def sizes(size: int, n: int) -> bytes:
    """Sizes of n samples, all the same."""
    return box(b"stsz", struct.pack(">III", 0, size, n))


def steps(n: int, step: int) -> bytes:
    """Time from each of n samples to the next."""
    return box(b"stts", struct.pack(">IIII", 0, 1, n, step))


def movie(*tables: bytes) -> bytes:
    track = box(b"trak", box(b"mdia", box(b"minf", box(b"stbl", *tables))))
    return box(b"ftyp", b"isom", bytes(4)) + box(b"moov", track)


def written(folder: Path, content: bytes) -> Path:
    path = folder / "a.mp4"
    path.write_bytes(content)
    return path


def test_a_table_of_one_size_for_millions_of_pictures_is_refused(tmp_path: Path):
    content = bytearray(write_numbered_video(tmp_path / "a.mp4", n=3).read_bytes())
    table = content.index(b"stsz")
    content[table + 8 : table + 16] = struct.pack(">II", 1, MILLIONS)
    with pytest.raises(MediaError, match=r"a\.mp4: states 85,000,000 pictures and sounds, at most"):
        open_pictures(written(tmp_path, content))


def test_a_fragment_that_states_millions_of_pictures_is_refused(tmp_path: Path):
    path = tmp_path / "a.mp4"
    with av.open(str(path), "w", options={"movflags": "frag_keyframe+empty_moov"}) as output:
        stream = output.add_stream("libx264", rate=10)
        stream.width = stream.height = 64
        stream.pix_fmt = "yuv420p"
        for _ in range(3):
            picture = np.zeros((64, 64), np.uint8)
            output.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="gray")))
        output.mux(stream.encode(None))
    assert open_pictures(path).n == 3
    content = bytearray(path.read_bytes())
    run = content.index(b"trun")
    content[run + 4 : run + 12] = struct.pack(">II", 5, MILLIONS)  # no bytes for each picture
    with pytest.raises(MediaError, match="states 85,000,000 pictures"):
        open_pictures(written(tmp_path, content))


@pytest.mark.parametrize(
    ("tables", "padding"),
    [
        ((sizes(1, MOST_SAMPLES + 1), steps(MOST_SAMPLES + 1, 2)), 0),
        ((sizes(0, MOST_SAMPLES + 1),), 0),
        ((sizes(4, MOST_SAMPLES), sizes(4, 1)), 0),  # two tables, one over the limit in all
        ((sizes(1, MOST_SAMPLES + 1), steps(MOST_SAMPLES + 1, 1)), 0),  # not in the file
        ((sizes(1, MOST_SAMPLES + 1), steps(MOST_SAMPLES + 1, 2)), MOST_SAMPLES),
    ],
)
def test_more_samples_than_are_read_are_refused(tmp_path: Path, tables, padding: int):
    path = written(tmp_path, movie(*tables) + box(b"mdat", bytes(padding)))
    with pytest.raises(MediaError, match=r"at most 10,000,000 are read"):
        check_samples(path, "a.mp4")


@pytest.mark.parametrize(
    ("tables", "padding"),
    [
        ((sizes(1, MOST_SAMPLES),), 0),
        ((steps(MILLIONS, 2),), 0),  # these alone take no memory
        # uncompressed sound: steps of one, all bytes there
        ((sizes(1, MOST_SAMPLES + 1), steps(MOST_SAMPLES + 1, 1)), MOST_SAMPLES + 1),
    ],
)
def test_as_many_as_are_read_are_let_through(tmp_path: Path, tables, padding: int):
    check_samples(written(tmp_path, movie(*tables) + box(b"mdat", bytes(padding))), "a.mp4")


def test_boxes_without_an_end_and_within_each_other_end_somewhere(tmp_path: Path):
    nested = b""
    for _ in range(2_000):
        nested = box(b"moov", nested)
    for content in (
        nested,
        struct.pack(">I4s", 0, b"moov") + sizes(1, 5),  # up to the end
        struct.pack(">I4sQ", 1, b"moov", 1 << 62) + sizes(1, 5),
    ):
        check_samples(written(tmp_path, content), "a.mp4")
    for content in (
        struct.pack(">I4s", 3, b"moov"),  # smaller than its own head
        struct.pack(">I4s", 1, b"moov"),  # a size that is cut off
        box(b"stsz"),
    ):
        with pytest.raises(MediaError, match="has no table of contents"):
            check_samples(written(tmp_path, content), "a.mp4")
    long = struct.pack(">I4sQ", 1, b"moov", 1 << 62) + sizes(1, MILLIONS)
    with pytest.raises(MediaError, match="states 85,000,000"):
        check_samples(written(tmp_path, long), "a.mp4")


def test_a_compressed_header_is_not_read(tmp_path: Path):
    path = written(tmp_path, box(b"moov", box(b"cmov", bytes(8))))
    with pytest.raises(MediaError, match=r"a\.mp4: has a compressed header.*convert it"):
        open_pictures(path)
