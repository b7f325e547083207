"""Targets for annotations, comparisons, archives, media and requests. The others are imported.

Each takes bytes and an empty folder, and may reject them or return.

A rejection is an `nvcore.common.errors.NvcoreError`. Any other exception is a fault, including an
AssertionError of the checks below.
"""

from __future__ import annotations

import asyncio
import bz2
import gzip
import io
import lzma
import tempfile
import zipfile
from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from functools import cache
from pathlib import Path, PurePosixPath
from typing import Any, Final
from urllib.parse import unquote

import av
import cv2
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from starlette.applications import Starlette

from nvcore.auditing import audit
from nvcore.comparison.compare import compare
from nvcore.comparison.measures.table import MEASURES
from nvcore.dataset.schema import READING_DTYPES
from nvcore.inputs.evaluated_frames import own_frames
from nvcore.inputs.files.find import find_files
from nvcore.inputs.load import load, read_options
from nvcore.inputs.readers import FORMATS
from nvcore.inputs.readers.base import Reading, ReadOptions, SourceFile
from nvcore.inputs.session import Session, Source, SystemSource
from nvcore.pictures.archive import Archive, ArchiveLimits
from nvcore.pictures.open import open_pictures
from nvcore.pictures.recordings import RecordingPictures
from nvcore.pictures.stretch import jpeg
from nvcore.report.terminal import render_findings
from nvcore.settings.objects import PEDESTRIAN
from scripts.fuzz import models, texts  # noqa: F401  # these modules register targets
from scripts.fuzz.target import DATA, PARTS, SAMPLE, TARGETS, target, written
from ui.session.routes import routes_below
from ui.session.uploads import safe_name
from ui.session.workspace import Workspace

__all__ = ["TARGETS"]

NAMES: Final = (
    "truth.csv",
    "a.json",
    "annotations.xml",
    "drive1/gt/gt.txt",
    "set06/V000/I00019.txt",
    "label_02/0016.txt",
    "label_2/000007.txt",
    "drive1/000001.txt",
    "drive1/000007.xml",
    "det.tsv",
)
"""Names of annotation files, as some formats take recording names from them."""
LONGEST: Final = 6000
"""Maximum size of a text that is used as a whole seed. Longer ones are cut to their first lines."""
MAX_FRAMES: Final = 100_000
MAX_UNPACKED_BYTES: Final = 1 << 22
SMALL: Final = ArchiveLimits(members=200, member_bytes=1 << 22, total_bytes=1 << 23)
ANSWERS: Final = frozenset({200, 201, 307, 400, 403, 404, 405, 413, 415, 507})
"""Statuses that the app's own routes may return."""


_VIDEOS: Final = (
    ("mp4", "mpeg4"),
    ("mov", "mjpeg"),
    ("matroska", "ffv1"),
    ("webm", "libvpx-vp9"),
    ("avi", "mpeg4"),
    ("mpegts", "mpeg2video"),
    ("mpeg", "mpeg1video"),
)


def _annotations_seeds() -> Iterator[bytes]:
    """Yield each test data file under each suitable name, with and without its format."""
    folders = {form.name.replace("-", "_"): number for number, form in enumerate(FORMATS, 1)}
    folders |= {"coco": [form.name for form in FORMATS].index("coco") + 1}
    for file in sorted(DATA.rglob("*")):
        if not file.is_file():
            continue
        content = _short(file.read_bytes())
        number = folders.get(file.relative_to(DATA).parts[0], 0)
        role = 1 if "det" in file.as_posix() or "results" in file.as_posix() else 0
        fitting = [i for i, name in enumerate(NAMES) if Path(name).suffix == file.suffix] or [0]
        for name in fitting:
            for chosen in {0, number}:
                yield bytes([chosen, name, role | 64]) + content
    mot = NAMES.index("drive1/gt/gt.txt")
    seqinfo = (DATA / "mot" / "MOT16-02" / "seqinfo.ini").read_bytes()
    truth = (DATA / "mot" / "MOT16-02" / "gt" / "gt.txt").read_bytes()
    yield bytes([0, mot, 0]) + _short(truth) + PARTS + seqinfo


def _comparisons_seeds() -> Iterator[bytes]:
    """Yield truth and detections, as plain CSV with and without recording names, and as MOT."""
    truth, fir, nir = (
        _short((SAMPLE / f"{name}.csv").read_bytes(), 1500) for name in ("truth", "fir", "nir")
    )
    yield PARTS.join((truth, fir, nir))
    yield PARTS.join((truth, fir))
    mot = b"1,1,301,200,30,80,1,1,1.0\n2,1,302,200,30,80,1,1,1.0\n"
    yield PARTS.join((mot, b"1,-1,304,201,30,80,0.1\n2,-1,305,201,30,80,0.2\n", mot[:0]))
    plain = b"frame,x,y,w,h,id,score,ignore\n1,300,200,30,80,1,,0\n2,301,200,30,80,1,,1\n"
    yield PARTS.join((plain, b"frame,x,y,w,h,score\n1,300,200,30,80,0.9\n", b""))


def _parquet_files_seeds() -> Iterator[bytes]:
    """Yield small Parquet files with row groups, several text encodings, and nulls."""
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


def _archives_seeds() -> Iterator[bytes]:
    """Yield archives: compressed and stored, with folders, empty, and ZIP64."""
    yield _zipped({"gt.txt": b"1,1,10,10,5,5,1,1,1\n" * 9})
    yield _zipped({"a/gt/gt.txt": b"1", "a/seqinfo.ini": b"[Sequence]\n", "__MACOSX/x": b"2"}, 0)
    yield _zipped({})
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        with archive.open("large.txt", "w", force_zip64=True) as member:
            member.write(b"x" * 3000)
        archive.comment = b"PK\5\6"
    yield packed.getvalue()


def _packed_seeds() -> Iterator[bytes]:
    """Yield a table compressed by each method, whole and in two parts."""
    rows = b"frame,x,y,w,h,track\n" + b"".join(b"%d,100,200,40,100,1\n" % i for i in range(30))
    methods: tuple[Callable[[bytes], bytes], ...] = (
        gzip.compress,
        bz2.compress,
        lzma.compress,
        _zstd,
    )
    for pack in methods:
        yield pack(rows)
        yield pack(rows[:200]) + pack(rows[200:])


def _zstd(content: bytes) -> bytes:
    """Compress content with Zstandard."""
    return bytes(pa.Codec("zstd").compress(content))


def _media_seeds() -> Iterator[bytes]:
    """Yield pictures in each format, in an archive, and short videos in each container."""
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
    yield _zipped({"1.png": encoded[0], "2.jpg": encoded[2]})
    for container, codec in _VIDEOS:
        yield _video(container, codec, grey)


def _video(container: str, codec: str, picture: np.ndarray) -> bytes:
    """Encode five pictures of 32 x 24 pixels."""
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


def _requests_seeds() -> Iterator[bytes]:
    """Yield a request to each route."""
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


def _zipped(members: dict[str, bytes], method: int = zipfile.ZIP_DEFLATED) -> bytes:
    """Return an archive of these files."""
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", method) as archive:
        for name, content in members.items():
            archive.writestr(zipfile.ZipInfo(name), content, method)
    return packed.getvalue()


def _short(content: bytes, longest: int = LONGEST) -> bytes:
    """Cut long content at the end of a line."""
    if len(content) <= longest:
        return content
    return content[: content.rfind(b"\n", 0, longest) + 1]


@target(_annotations_seeds, share=4.0)
def annotations(content: bytes, folder: Path) -> None:
    """Read one source of one or several files, with its format, role and options chosen by bytes.

    The first three bytes choose the format (0: detect it), the name, and the options.
    """
    if len(content) < 3:
        return
    number, name, bits = content[:3]
    chosen = FORMATS[number % (len(FORMATS) + 1) - 1] if number % (len(FORMATS) + 1) else None
    role = "detections" if bits & 1 else "truth"
    first, *others = content[3:].split(PARTS)[:4]
    path = Path(NAMES[name % len(NAMES)])
    written(folder, str(path), first)
    for index, other in enumerate(others, 2):
        beside = path.parent.parent / "seqinfo.ini" if path.name == "gt.txt" else None
        written(folder, str(beside or path.with_stem(f"{path.stem}{index}")), other)
    source = Source(
        (str(path) if len(others) == 0 or path.name == "gt.txt" else f"{path.parent}/*",),
        format=None if chosen is None else chosen.name,
        classes=("person", "1") if bits & 2 else None,
        frame_base=(None, 0, 1, None)[bits >> 2 & 3],
        box_base=(None, 0, 1, None)[bits >> 4 & 3],
    )
    size = (640, 480) if bits & 64 else None
    truth = _some_truth() if role == "detections" else None
    files, file_format = find_files(source, folder, role)
    reading = file_format.read(files, read_options(source, role, size, truth, PEDESTRIAN))
    _check_reading(reading, len(files))
    if role == "truth":
        own_frames(reading, reading.recordings["name"])


def _check_reading(reading: Reading, n_files: int) -> None:
    boxes = reading.boxes
    assert list(boxes.columns) == list(READING_DTYPES), "columns of a reading"
    for column, dtype in READING_DTYPES.items():
        assert boxes[column].dtype == dtype, f"{column}: {boxes[column].dtype}"
    assert boxes["recording"].isin(reading.recordings["name"]).all(), "a box of no recording"
    assert reading.recordings["name"].is_unique, "two recordings of one name"
    assert boxes["file"].between(0, n_files - 1).all(), "a box of no file"


@cache
def _some_truth() -> Reading:
    """Return recordings and pictures that detections may name."""
    source = Source((str(DATA / "coco" / "kaist.json"),))
    files, file_format = find_files(source, DATA, "truth")
    return file_format.read(files, read_options(source, "truth", None, None, PEDESTRIAN))


@target(_comparisons_seeds, share=1.5)
def comparison(content: bytes, folder: Path) -> None:
    """Read, audit and compare truth and detections of one or two systems."""
    parts = content.split(PARTS)[:3]
    if len(parts) < 2:
        return
    for name, part in zip(("truth.txt", "x.txt", "y.txt"), parts, strict=False):
        written(folder, name, part)
    systems = tuple(
        SystemSource((f"{name}.txt",), name=name, threshold=threshold)
        for name, threshold, _ in zip("xy", (None, 0.5), parts[1:], strict=False)
    )
    session = Session(
        folder=folder, truth=Source(("truth.txt",)), systems=systems, size=(640, 480), fps=20.0
    )
    dataset = load(session, max_frames=MAX_FRAMES)
    findings = audit(dataset)
    render_findings(findings)
    if len(systems) == 2:
        result = compare(dataset)
        for measure in MEASURES:
            for system in (result.x, result.y):
                if measure.of is not None:
                    measure.of(result, system)


@target(_parquet_files_seeds, share=1.0)
def parquet(content: bytes, folder: Path) -> None:
    """Read a Parquet file as truth and as detections."""
    path = written(folder, "a.parquet", content)
    form = next(form for form in FORMATS if form.name == "parquet")
    for role in form.roles:
        _check_reading(form.read([SourceFile(path, path.name)], ReadOptions(role=role)), 1)


@target(_archives_seeds, share=1.0, most_bytes=1 << 15)
def archives(content: bytes, folder: Path) -> None:
    """Check, read and unpack an archive, which must stay below its folder."""
    path = written(folder, "packed.zip", content)
    with Archive(path, SMALL) as archive:
        sizes = [len(archive.read(name)) for name in archive.names]
        assert sum(sizes) <= SMALL.total_bytes, "more than the limit"
        inside = folder / "inside"
        inside.mkdir()
        paths = archive.unpack(inside)
    assert len(paths) == len(sizes), "files that were not unpacked"
    for file in folder.rglob("*"):
        assert file == path or file.is_relative_to(inside), f"{file} lies outside"
        assert not file.is_symlink(), f"{file} is a link"


@target(_packed_seeds, share=0.75)
def packed(content: bytes, folder: Path) -> None:
    """Decompress and read a file of annotations."""
    path = written(folder, "truth.csv.gz", content)
    with SourceFile(path, path.name).open() as stream:
        n_bytes = 0
        while chunk := stream.read(1 << 16):
            n_bytes += len(chunk)
            if n_bytes > MAX_UNPACKED_BYTES:
                return
    files, file_format = find_files(Source((path.name,)), folder, "truth")
    options = read_options(Source((path.name,)), "truth", (640, 480), None, PEDESTRIAN)
    reading = file_format.read(files, options)
    _check_reading(reading, len(files))


@target(_media_seeds, share=2.0, most_bytes=1 << 16)
def media(content: bytes, folder: Path) -> None:
    """Read a picture, video or archive of pictures: header, first pictures and last."""
    path = written(folder, "pictures.bin", content)
    pictures = open_pictures(path)
    try:
        for index in {0, 1, pictures.n // 2, pictures.n - 1}:
            if 0 <= index < pictures.n:
                picture = pictures.read(index)
                assert picture.dtype in (np.uint8, np.uint16), picture.dtype
                jpeg(picture, lo=0.0, hi=99.0, quality=85)
    finally:
        pictures.close()


@target(_requests_seeds, share=1.0)
def routes(content: bytes, _folder: Path) -> None:
    """Send a request to the app's routes: method, path?query, header lines, empty line, body.

    TOKEN in the path stands for the session's own token.
    """
    app, space = _served()
    head, _, body = content.partition(b"\n\n")
    first, *lines = head.split(b"\n")
    method, _, target = first.partition(b" ")
    path, _, query = target.replace(b"TOKEN", space.token.encode()).partition(b"?")
    headers = [tuple(part.strip() for part in line.partition(b":")[::2]) for line in lines]
    scope = {
        "type": "http",
        "method": method.decode("latin-1"),
        "path": unquote(path.decode("latin-1")),
        "raw_path": path,
        "root_path": "",
        "query_string": query,
        "headers": [(name.lower(), value) for name, value in headers if name],
        "http_version": "1.1",
        "scheme": "http",
        "server": ("localhost", 8501),
        "client": ("127.0.0.1", 1),
    }
    status = asyncio.run(_status(app, scope, body))
    assert status in ANSWERS, f"status {status}"
    files = [file for file in space.folder.rglob("*") if file.is_file()]
    paths = {PurePosixPath(file.relative_to(space.folder)) for file in files}
    assert paths == set(space.stored), "files beside those stored"
    assert space.used_bytes == sum(file.stat().st_size for file in files), "bytes not counted"
    for file in files:
        assert safe_name(file.name) == file.name, f"{file.name!r} is not safe"
        file.unlink()
    space.stored.clear()
    space.used_bytes = 0


@cache
def _served() -> tuple[Any, Any]:
    """Return an app with the routes, and a workspace with a picture."""
    space = Workspace()
    space.pictures = RecordingPictures({0: _OnePicture()}, {0: np.array([0, -1])})
    return Starlette(routes=routes_below("")), space


class _OnePicture:
    n, width, height, fps, note, name = 1, 64, 48, None, "", "one"
    numbers, is_video = None, False

    def read(self, _index: int) -> np.ndarray:
        return np.zeros((48, 64), np.uint8)

    def close(self) -> None:
        pass


async def _status(app: Any, scope: dict[str, Any], body: bytes) -> int:
    chunks = [body[:1000], body[1000:]]
    statuses: list[int] = []

    async def receive() -> dict[str, Any]:
        if not chunks:
            return {"type": "http.disconnect"}
        return {"type": "http.request", "body": chunks.pop(0), "more_body": bool(chunks)}

    async def send(message: dict[str, Any]) -> None:
        if message["type"] == "http.response.start":
            statuses.append(message["status"])

    await app(scope, receive, send)
    return statuses[0]
