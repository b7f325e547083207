"""What is fuzzed: each target takes bytes and an empty folder, and may refuse them or return.

A refusal is an `nvcore.errors.NvcoreError`. Any other exception is a fault, an AssertionError of
the checks below among them.
"""

from __future__ import annotations

import asyncio
import gc
import re
import tomllib
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from random import Random
from typing import Any, Final
from urllib.parse import unquote

import numpy as np

from nvcore.auditing import audit
from nvcore.comparison import compare
from nvcore.dataset.provenance import provenance_json, read_provenance
from nvcore.errors import SessionError
from nvcore.inputs.evaluated_frames import own_frames, parse_frames
from nvcore.inputs.facts import is_frame_range
from nvcore.inputs.files import find_files
from nvcore.inputs.load import load, read_options
from nvcore.inputs.readers import FORMATS
from nvcore.inputs.readers.base import Reading, ReadOptions, SourceFile
from nvcore.inputs.recordings_file import read_recordings_file
from nvcore.inputs.session import Session, Source, SystemSource
from nvcore.inputs.session_toml import read_session, write_session
from nvcore.measures.table import MEASURES
from nvcore.objects import PEDESTRIAN
from nvcore.pictures.archive import Archive, ArchiveLimits
from nvcore.pictures.open import open_pictures
from nvcore.pictures.recordings import RecordingPictures
from nvcore.pictures.stretch import jpeg
from nvcore.report.gate.measures import measure_names
from nvcore.report.gate.outcomes import judge
from nvcore.report.gate.rules import read_rules
from nvcore.report.terminal import render_findings
from nvcore.schema import READING_DTYPES
from scripts.fuzz import models, seeds, tables
from scripts.fuzz.tables import written

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
PARTS: Final = b"\n%%\n"
"""Between the files of one input."""
MAX_FRAMES: Final = 100_000
MAX_UNPACKED_BYTES: Final = 1 << 22
SMALL: Final = ArchiveLimits(members=200, member_bytes=1 << 22, total_bytes=1 << 23)
ANSWERS: Final = frozenset({200, 201, 307, 400, 403, 404, 405, 413, 415, 507})
"""Statuses that the app's own routes may give."""


@dataclass(frozen=True)
class Target:
    """One entrance for files from outside.

    Attributes
    ----------
    run
        (content, empty folder) -> None, or an error.
    seeds
        Inputs that it begins with.
    share
        Of the time of a run.
    most_bytes
        Of one input.
    module
        What `run` imports by itself, to be imported before.
    mutate
        (content, source of chance) -> another content, where few bytes make sense; None: any.
    """

    run: Callable[[bytes, Path], None]
    seeds: Callable[[], Iterable[bytes]]
    share: float
    most_bytes: int = 8192
    module: str = ""
    mutate: Callable[[bytes, Random], bytes] | None = None


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


def parquet_files(content: bytes, folder: Path) -> None:
    """A Parquet file, as truth and as detections."""
    path = written(folder, "a.parquet", content)
    form = next(form for form in FORMATS if form.name == "parquet")
    for role in form.roles:
        _check_reading(form.read([SourceFile(path, path.name)], ReadOptions(role=role)), 1)


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


def sessions(content: bytes, folder: Path) -> None:
    """A session file: once written, it is written the same after it was read again.

    Few of the inputs are TOML: what makes it none is left out, line by line.
    """
    path = written(folder, "session.toml", content)
    try:
        session = read_session(path)
    except SessionError as error:
        if not isinstance(error.__cause__, tomllib.TOMLDecodeError):
            raise
        path.write_bytes(without_bad_lines(content))
        session = read_session(path)
    text = write_session(session, version="0", fingerprint="0")
    path.write_bytes(text.encode())
    again = read_session(path)
    assert write_session(again, version="0", fingerprint="0") == text, "the text has changed"
    assert str(again.params) == str(session.params), "settings have changed"
    assert str(again.protocol) == str(session.protocol), "the protocol has changed"


def without_bad_lines(content: bytes) -> bytes:
    """The text without the lines that are no TOML."""
    lines = content.decode("utf-8", "ignore").splitlines()
    while lines:
        try:
            tomllib.loads("\n".join(lines))
        except tomllib.TOMLDecodeError as error:
            place = re.search(r"at line (\d+)", str(error))
            del lines[min(int(place[1]), len(lines)) - 1 if place else -1]
        except (ValueError, RecursionError):
            lines.pop()
        else:
            break
    return "\n".join(lines).encode()


def recordings(content: bytes, folder: Path) -> None:
    """A table of recordings."""
    path = written(folder, "recordings.csv", content)
    for name, (line, entry) in read_recordings_file(path, "recordings.csv").items():
        assert name == entry.name, "another name"
        assert line > 1, "no line"


def provenance(content: bytes, folder: Path) -> None:
    """A record of how detections were made."""
    path = written(folder, "provenance.json", content)
    text = provenance_json(read_provenance(path, "provenance.json"))
    path.write_bytes(text)
    assert provenance_json(read_provenance(path, "again")) == text, "another record"


def frame_lists(content: bytes, folder: Path) -> None:
    """Evaluated frames: a range, or a file of numbers."""
    written(folder, "frames.txt", content)
    text = content.decode("utf-8", "replace")
    own = np.arange(10, 15)
    frames = parse_frames(text if is_frame_range(text) else "frames.txt", folder, own)
    assert (np.diff(frames) > 0).all(), "frames that are not sorted"


def rules(content: bytes, _folder: Path) -> None:
    """Rules of the gate, and what they say of measures with a value and without."""
    names = measure_names()
    lines = [("--rule", text) for text in content.decode("utf-8", "replace").splitlines()]
    read, problems = read_rules(lines, names)
    assert problems or len(read) <= len(lines), "more rules than lines"
    judge(read, dict.fromkeys(names, 0.5))
    judge(read, dict.fromkeys(names, float("nan")))


def routes(content: bytes, _folder: Path) -> None:
    """A request to the app's routes: method, path?query, header lines, an empty line, the body.

    TOKEN in the path is the session's own.
    """
    from ui.session.uploads import safe_name

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
    from starlette.applications import Starlette

    from ui.session.routes import routes_below
    from ui.session.workspace import Workspace

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


def tidy() -> None:
    """What an input may leave behind; called now and then."""
    gc.collect()


TARGETS: Final = {
    "annotations": Target(annotations, lambda: seeds.annotations(NAMES, PARTS), 4.0),
    "comparison": Target(comparison, lambda: seeds.comparisons(PARTS), 1.5),
    "archives": Target(archives, seeds.archives, 1.0, 1 << 15),
    "packed": Target(packed, seeds.packed, 0.75),
    "media": Target(media, seeds.media, 2.0, 1 << 16),
    "sessions": Target(sessions, seeds.sessions, 1.0),
    "recordings": Target(recordings, seeds.recordings, 0.5),
    "provenance": Target(provenance, seeds.provenance, 0.25),
    "frames": Target(frame_lists, seeds.frame_lists, 0.25),
    "rules": Target(rules, seeds.rules, 0.25),
    "parquet": Target(parquet_files, seeds.parquet_files, 1.0),
    "detectors": Target(
        models.detector_models,
        lambda: models.changes("detectors"),
        1.0,
        1024,
        "nvcore.detectors.icf.model_file",
        lambda content, rng: models.mutated(content, "detectors", rng),
    ),
    "estimators": Target(
        models.estimators,
        lambda: models.changes("driver"),
        1.0,
        1024,
        mutate=lambda content, rng: models.mutated(content, "driver", rng),
    ),
    "light": Target(tables.light, tables.light_seeds, 0.5),
    "gaze": Target(tables.gaze, tables.gaze_seeds, 0.25),
    "estimates": Target(tables.estimates, tables.estimates_seeds, 0.5),
    "trials": Target(
        lambda content, folder: tables.trials(content, folder, PARTS),
        lambda: tables.trials_seeds(PARTS),
        1.0,
    ),
    "boxes": Target(tables.study_boxes, tables.study_boxes_seeds, 0.5),
    "ratings": Target(tables.ratings, tables.ratings_seeds, 0.5),
    "answers": Target(
        tables.answers, tables.answers_seeds, 0.25, 2000, "ui.driver.study.on_screen"
    ),
    "names": Target(tables.names_of_frames, tables.names_seeds, 0.5, 2048),
    "folders": Target(tables.names_of_pictures, tables.names_seeds, 0.5, 2048),
    "routes": Target(routes, seeds.requests, 1.0, module="ui.session.routes"),
}
"""By name, as for the command line."""
