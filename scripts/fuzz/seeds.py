"""What each target of the fuzzer begins with: small files that are read to their end."""

from __future__ import annotations

import bz2
import gzip
import io
import lzma
import tempfile
import zipfile
from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any, Final

import av
import cv2
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from nvcore.inputs.readers import FORMATS
from scripts.fuzz.target import PARTS

ROOT: Final = Path(__file__).resolve().parents[2]
DATA: Final = ROOT / "tests" / "data"
SAMPLE: Final = ROOT / "sample_data"
LONGEST: Final = 6000
"""Bytes of a text that is taken whole; of a longer one its first lines."""

_VIDEOS: Final = (
    ("mp4", "mpeg4"),
    ("mov", "mjpeg"),
    ("matroska", "ffv1"),
    ("webm", "libvpx-vp9"),
    ("avi", "mpeg4"),
    ("mpegts", "mpeg2video"),
    ("mpeg", "mpeg1video"),
)


def annotations(names: Sequence[str]) -> Iterator[bytes]:
    """Each file of the tests' data under each fitting name, its format named and not."""
    folders = {form.name.replace("-", "_"): number for number, form in enumerate(FORMATS, 1)}
    folders |= {"coco": [form.name for form in FORMATS].index("coco") + 1}
    for file in sorted(DATA.rglob("*")):
        if not file.is_file():
            continue
        content = _short(file.read_bytes())
        number = folders.get(file.relative_to(DATA).parts[0], 0)
        role = 1 if "det" in file.as_posix() or "results" in file.as_posix() else 0
        fitting = [i for i, name in enumerate(names) if Path(name).suffix == file.suffix] or [0]
        for name in fitting:
            for chosen in {0, number}:
                yield bytes([chosen, name, role | 64]) + content
    mot = names.index("drive1/gt/gt.txt")
    seqinfo = (DATA / "mot" / "MOT16-02" / "seqinfo.ini").read_bytes()
    truth = (DATA / "mot" / "MOT16-02" / "gt" / "gt.txt").read_bytes()
    yield bytes([0, mot, 0]) + _short(truth) + PARTS + seqinfo


def comparisons() -> Iterator[bytes]:
    """Truth and detections, as plain CSV with names of recordings and without, and as MOT."""
    truth, fir, nir = (
        _short((SAMPLE / f"{name}.csv").read_bytes(), 1500) for name in ("truth", "fir", "nir")
    )
    yield PARTS.join((truth, fir, nir))
    yield PARTS.join((truth, fir))
    rows = [f"{frame},1,{300 + frame},200,30,80,1,1,1.0" for frame in range(1, 9)]
    detections = [f"{frame},-1,{303 + frame},201,30,80,0.{frame}" for frame in range(1, 9)]
    mot = "\n".join(rows).encode()
    yield PARTS.join((mot, "\n".join(detections).encode(), b"1,-1,10,10,5,5,0.5\n"))
    plain = b"frame,x,y,w,h,id,score,ignore\n1,300,200,30,80,1,,0\n2,301,200,30,80,1,,1\n"
    yield PARTS.join((plain, b"frame,x,y,w,h,score\n1,300,200,30,80,0.9\n", b""))


def parquet_files() -> Iterator[bytes]:
    """Of few rows: in groups, with texts by dictionary and by what they begin with, with nulls."""
    boxes = {"frame": [1, 2, 2], "x": [1.5, 2.0, None], "y": [0, 1, 2], "w": [9] * 3, "h": [20] * 3}
    names = {"recording": ["a", "b", "b"], "id": ["p1", None, "7"]}
    flags = {"score": [0.5, None, 1.0], "ignore": [True, False, None], "class": ["person"] * 3}
    table = pa.table(boxes | names | flags)
    ways: Sequence[dict[str, Any]] = (
        {},
        {"compression": "none", "use_dictionary": False, "write_statistics": False},
        {"compression": "zstd", "row_group_size": 1, "data_page_version": "2.0"},
        {"use_dictionary": False, "column_encoding": {"recording": "DELTA_BYTE_ARRAY"}},
    )
    for way in ways:
        content = io.BytesIO()
        pq.write_table(table, content, **way)
        yield content.getvalue()


def archives() -> Iterator[bytes]:
    """Packed and stored, with folders, without a file, and the tables of 64 bits."""
    yield zipped({"gt.txt": b"1,1,10,10,5,5,1,1,1\n" * 9})
    yield zipped({"a/gt/gt.txt": b"1", "a/seqinfo.ini": b"[Sequence]\n", "__MACOSX/x": b"2"}, 0)
    yield zipped({})
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        with archive.open("large.txt", "w", force_zip64=True) as member:
            member.write(b"x" * 3000)
        archive.comment = b"PK\5\6"
    yield packed.getvalue()


def packed() -> Iterator[bytes]:
    """A table packed by each method, whole and in two parts."""
    rows = b"frame,x,y,w,h,track\n" + b"".join(b"%d,100,200,40,100,1\n" % i for i in range(30))
    methods: tuple[Callable[[bytes], bytes], ...] = (
        gzip.compress,
        bz2.compress,
        lzma.compress,
        zstd,
    )
    for pack in methods:
        yield pack(rows)
        yield pack(rows[:200]) + pack(rows[200:])


def zstd(content: bytes) -> bytes:
    """The content packed by Zstandard."""
    return bytes(pa.Codec("zstd").compress(content))


def media() -> Iterator[bytes]:
    """Pictures in each format, in an archive, and short videos in each container."""
    grey = (np.arange(32 * 24).reshape(24, 32) % 251).astype(np.uint8)
    pictures = (
        (".png", grey),
        (".png", grey.astype(np.uint16) * 257),
        (".jpg", np.dstack([grey] * 3)),
        (".tiff", grey.astype(np.float32)),
        (".tiff", grey.astype(np.uint16)),
        (".bmp", grey),
        (".png", np.dstack([grey] * 4)),
    )
    encoded = [bytes(cv2.imencode(ending, picture)[1]) for ending, picture in pictures]
    yield from encoded
    yield bytes(cv2.imencodemulti(".tif", [np.roll(grey, n, 1) for n in range(3)])[1])
    exif = b"Exif\0\0II*\0\x08\0\0\0\1\0\x12\1\3\0\1\0\0\0\6\0\0\0\0\0\0\0"
    yield encoded[2][:2] + b"\xff\xe1\0" + bytes([len(exif) + 2]) + exif + encoded[2][2:]
    yield zipped({"1.png": encoded[0], "2.jpg": encoded[2]})
    for container, codec in _VIDEOS:
        yield _video(container, codec, grey)


def _video(container: str, codec: str, picture: np.ndarray) -> bytes:
    """Five pictures of 32 x 24 pixels."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "video"
        with av.open(str(path), "w", format=container) as output:
            stream = output.add_stream(codec, rate=25)
            stream.width, stream.height = 32, 24
            stream.pix_fmt = "yuvj420p" if codec == "mjpeg" else "yuv420p"
            for number in range(5):
                frame = av.VideoFrame.from_ndarray(np.roll(picture, number, 1), format="gray")
                frame.pts, frame.time_base = number, Fraction(1, 25)
                output.mux(stream.encode(frame))
            output.mux(stream.encode(None))
        return path.read_bytes()


def requests() -> Iterator[bytes]:
    """To each route."""
    png = bytes(cv2.imencode(".png", np.zeros((4, 4), np.uint8))[1])
    same = b"host: h:1\norigin: http://h:1\nsec-fetch-site: same-origin\n"
    yield b"PUT /nv/TOKEN/upload/pictures?name=a%2Fb.png\n" + same + b"\n" + png
    yield (
        b"PUT /nv/TOKEN/upload/pictures?name=..%5Cc.zip\n"
        + same
        + f"content-length: {len(png)}\n\n".encode()
        + png
    )
    yield b"GET /nv/TOKEN/frame/0/0.jpg?lo=1&hi=99.5\n\n"
    yield b"GET /nv/TOKEN/boxes/0/1?v=3\n\n"
    yield b"GET /overview?x=FIR\n\n"


def zipped(members: dict[str, bytes], method: int = zipfile.ZIP_DEFLATED) -> bytes:
    """An archive of these files."""
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", method) as archive:
        for name, content in members.items():
            archive.writestr(zipfile.ZipInfo(name), content, method)
    return packed.getvalue()


def _short(content: bytes, longest: int = LONGEST) -> bytes:
    """The content, cut after a line where it is long."""
    if len(content) <= longest:
        return content
    return content[: content.rfind(b"\n", 0, longest) + 1]
