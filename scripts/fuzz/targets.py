"""Targets for annotations, comparisons, archives, media and requests; the others are imported.

Each takes bytes and an empty folder, and may refuse them or return.

A refusal is an `nvcore.errors.NvcoreError`. Any other exception is a fault, an AssertionError of
the checks below among them.
"""

from __future__ import annotations

import asyncio
from functools import cache
from pathlib import Path
from typing import Any, Final
from urllib.parse import unquote

import numpy as np
from starlette.applications import Starlette

from nvcore.auditing import audit
from nvcore.comparison import compare
from nvcore.inputs.evaluated_frames import own_frames
from nvcore.inputs.files import find_files
from nvcore.inputs.load import load, read_options
from nvcore.inputs.readers import FORMATS
from nvcore.inputs.readers.base import Reading, ReadOptions, SourceFile
from nvcore.inputs.session import Session, Source, SystemSource
from nvcore.measures.table import MEASURES
from nvcore.objects import PEDESTRIAN
from nvcore.pictures.archive import Archive, ArchiveLimits
from nvcore.pictures.open import open_pictures
from nvcore.pictures.recordings import RecordingPictures
from nvcore.pictures.stretch import jpeg
from nvcore.report.terminal import render_findings
from nvcore.schema import READING_DTYPES
from scripts.fuzz import models, seeds, texts  # noqa: F401  # they have targets
from scripts.fuzz.target import PARTS, TARGETS, target, written
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
"""What a file of annotations may be called: some formats take names of recordings from there."""
MAX_FRAMES: Final = 100_000
MAX_UNPACKED_BYTES: Final = 1 << 22
SMALL: Final = ArchiveLimits(members=200, member_bytes=1 << 22, total_bytes=1 << 23)
ANSWERS: Final = frozenset({200, 201, 307, 400, 403, 404, 405, 413, 415, 507})
"""Statuses that the app's own routes may give."""


@target(lambda: seeds.annotations(NAMES), share=4.0)
def annotations(content: bytes, folder: Path) -> None:
    """One file, or several, of one source; its format named or not, its role and options by bits.

    The first three bytes choose the format (0: by the content), the name, and the options.
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
    """Recordings and pictures that detections may name."""
    source = Source((str(seeds.DATA / "coco" / "kaist.json"),))
    files, file_format = find_files(source, seeds.DATA, "truth")
    return file_format.read(files, read_options(source, "truth", None, None, PEDESTRIAN))


@target(seeds.comparisons, share=1.5)
def comparison(content: bytes, folder: Path) -> None:
    """Truth and detections of one or two systems: read, audited, compared."""
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


@target(seeds.parquet_files, share=1.0)
def parquet(content: bytes, folder: Path) -> None:
    """A Parquet file, as truth and as detections."""
    path = written(folder, "a.parquet", content)
    form = next(form for form in FORMATS if form.name == "parquet")
    for role in form.roles:
        _check_reading(form.read([SourceFile(path, path.name)], ReadOptions(role=role)), 1)


@target(seeds.archives, share=1.0, most_bytes=1 << 15)
def archives(content: bytes, folder: Path) -> None:
    """An archive: checked, read, unpacked below a folder and nowhere else."""
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


@target(seeds.packed, share=0.75)
def packed(content: bytes, folder: Path) -> None:
    """A packed file of annotations: unpacked, and read."""
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


@target(seeds.media, share=2.0, most_bytes=1 << 16)
def media(content: bytes, folder: Path) -> None:
    """A picture, video or archive of pictures: its header, its first pictures and its last."""
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


@target(seeds.requests, share=1.0)
def routes(content: bytes, _folder: Path) -> None:
    """A request to the app's routes: method, path?query, header lines, an empty line, the body.

    TOKEN in the path is the session's own.
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
    assert {file.name for file in files} == set(space.stored), "files beside those stored"
    assert space.used_bytes == sum(file.stat().st_size for file in files), "bytes not counted"
    for file in files:
        assert safe_name(file.name) == file.name, f"{file.name!r} is not safe"
        file.unlink()
    space.stored.clear()
    space.used_bytes = 0


@cache
def _served() -> tuple[Any, Any]:
    """An app with the routes, and a workspace with a picture."""
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
