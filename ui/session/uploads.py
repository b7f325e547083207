"""Uploads: stored in the session's folder under safe names, within limits.

    FOLDER/pictures/N/                videos and archives of pictures of form N, by the upload route
    FOLDER/pictures/N/images/         its single pictures
    FOLDER/upload-N/SLOT/annotations/data/
                                      ground truth, detections and other files of a form
    FOLDER/model-KIND-N/model/annotations/data/
                                      a model

Names from a browser are never joined as they come. A safe base name is kept, since recordings
are named after their files. A file that is sent again in another form has the same name there.
"""

from __future__ import annotations

import os
import shutil
from collections import Counter
from collections.abc import AsyncIterable, Callable, Iterable, Sequence
from dataclasses import replace
from filecmp import cmp
from http import HTTPStatus
from pathlib import Path, PurePosixPath
from typing import IO, Final

from starlette.concurrency import run_in_threadpool
from starlette.requests import ClientDisconnect
from streamlit.typing import UploadedFile

from nvcore.common.errors import InputError, MediaError, NvcoreError
from nvcore.pictures.archive import Archive, ArchiveLimits
from ui.access.files import free_name, safe_name
from ui.session.workspace import PICTURES, Kind, Stored, Workspace, used_by_all
from ui.settings.limits import MEBI, limits_of_environment

MAX_FILE_BYTES: Final = 4 << 30
"""Size limit of one file of pictures."""
MAX_SESSION_BYTES: Final = 8 << 30
"""Size limit of all uploads of a session."""
MAX_FILES: Final = 100_000
SPARE_BYTES: Final = 1 << 30
"""Disk space that must stay free."""
MAX_UNPACKED_BYTES: Final = 2 << 30
"""Size limit of all annotations in one archive."""
WRITE_BYTES: Final = 1 << 20
HEAD_BYTES: Final = 400

# the readers name no recording after these folders (nvcore.inputs.readers.meaning.names)
ANNOTATION_FOLDERS: Final = PurePosixPath("annotations", "data")

_MAGIC: Final[tuple[tuple[int, bytes, Kind], ...]] = (
    (0, b"\x89PNG\r\n\x1a\n", "image"),
    (0, b"\xff\xd8\xff", "image"),
    (0, b"II*\x00", "image"),
    (0, b"MM\x00*", "image"),
    (0, b"BM", "image"),
    (4, b"ftyp", "video"),
    (8, b"AVI ", "video"),
    (0, b"\x1aE\xdf\xa3", "video"),
    (0, b"\x00\x00\x01\xba", "video"),
    (0, b"PK\x03\x04", "zip"),
)
_TRANSPORT_PACKET: Final = 188


class UploadError(NvcoreError):
    """Refusal of an upload, with reason, suggested fix and HTTP status."""

    def __init__(self, message: str, status: HTTPStatus):
        self.status = status
        super().__init__(message)


def kind_of(head: bytes) -> Kind | None:
    """Return the kind of a file by its first bytes, or None if it has no pictures."""
    for offset, magic, kind in _MAGIC:
        if head.startswith(magic, offset):
            return kind
    packets = head[0 : 2 * _TRANSPORT_PACKET + 1 : _TRANSPORT_PACKET]
    return "video" if packets == b"GGG" else None


async def receive(
    space: Workspace, name: str, content: AsyncIterable[bytes], *, n_bytes: int | None = None
) -> Stored:
    """Stream a file of pictures into the session's folder, one chunk in memory at a time.

    Parameters
    ----------
    n_bytes
        Size as the sender states it, if at all. The received bytes are counted anyway.

    Raises
    ------
    UploadError
        If it is too large for a limit, is no picture, archive or video, or breaks off.
    """
    if n_bytes is not None:
        check_room(space, n_bytes)
    part = _PartialFile(space)
    try:
        pending = bytearray()
        async for chunk in content:
            pending += chunk
            if len(pending) >= WRITE_BYTES:
                await run_in_threadpool(part.write, bytes(pending))
                pending.clear()
        await run_in_threadpool(part.write, bytes(pending))
        if n_bytes is not None and part.n_bytes != n_bytes:
            raise UploadError("The upload broke off; send it again.", HTTPStatus.BAD_REQUEST)
        return await run_in_threadpool(part.keep, safe_name(name))
    except ClientDisconnect as error:
        raise UploadError("The upload broke off; send it again.", HTTPStatus.BAD_REQUEST) from error
    except OSError as error:
        raise UploadError(
            f"The file could not be stored ({error.strerror}).", HTTPStatus.INSUFFICIENT_STORAGE
        ) from error
    finally:
        part.drop()


class _PartialFile:
    """A file that is being written. `drop` removes it unless it was kept."""

    def __init__(self, space: Workspace):
        self.space = space
        self.n_bytes = 0
        self.kind: Kind | None = None
        self._file: IO[bytes] | None = None
        self._path = space.folder / PICTURES / f".{next(space.numbers)}.part"

    def write(self, chunk: bytes) -> None:
        if self._file is None:
            self.kind = kind_of(chunk[:HEAD_BYTES])
            if self.kind is None:
                raise UploadError(
                    "This is neither a video (MP4, AVI, MKV, WebM, MPEG), a picture (PNG, JPEG, "
                    "TIFF, BMP) nor a ZIP archive of pictures, whatever its name says.",
                    HTTPStatus.UNSUPPORTED_MEDIA_TYPE,
                )
            self._path.parent.mkdir(parents=True, exist_ok=True)
            self._file = self._path.open("xb")
        check_room(self.space, len(chunk), so_far=self.n_bytes)
        self._file.write(chunk)
        self.n_bytes += len(chunk)
        with self.space.lock:
            self.space.used_bytes += len(chunk)

    def keep(self, name: str) -> Stored:
        assert self._file is not None
        assert self.kind is not None
        self._file.close()
        stored = Stored(name, self.kind, self.n_bytes, self.space.form)
        if self.space.stored.get(stored.place) == stored and cmp(
            self._path, self.space.folder / stored.place, shallow=False
        ):
            return stored  # sent twice
        with self.space.lock:
            if len(self.space.stored) >= MAX_FILES:
                raise UploadError(
                    f"A session takes {MAX_FILES} files; send pictures as a ZIP archive.",
                    HTTPStatus.REQUEST_ENTITY_TOO_LARGE,
                )
            in_form = (o.name for o in self.space.stored.values() if o.form == stored.form)
            stored = replace(stored, name=free_name(name, in_form))
            place = self.space.folder / stored.place
            place.parent.mkdir(parents=True, exist_ok=True)
            self._path.rename(place)
            self.space.stored[stored.place] = stored
        self._file = None
        return stored

    def drop(self) -> None:
        if self._file is None:
            return
        self._file.close()
        self._path.unlink(missing_ok=True)
        with self.space.lock:
            self.space.used_bytes -= self.n_bytes


def remove_pictures(space: Workspace, places: Iterable[PurePosixPath]) -> None:
    """Remove uploaded pictures from the session's folder."""
    with space.lock:
        files = [space.stored.pop(place) for place in list(places) if place in space.stored]
        space.used_bytes -= sum(stored.n_bytes for stored in files)
    for stored in files:
        (space.folder / stored.place).unlink(missing_ok=True)


def begin_form(space: Workspace) -> None:
    """Start a form, and remove uploaded pictures that the open comparison does not show."""
    in_use = set(_paths_in_use(space))
    idle = [
        file.place
        for file in space.stored.values()
        if not in_use & {(place := space.folder / file.place), place.parent}
    ]
    remove_pictures(space, idle)
    space.form += 1
    space.form_folder = None


def _paths_in_use(space: Workspace) -> list[Path]:
    """Return the paths that the open comparison names."""
    if space.opened is None:
        return []
    session = space.opened.session
    return [Path(os.path.normpath(session.folder / path)) for path in session.paths()]


def store_in_form(
    space: Workspace, slot: str, files: Sequence[UploadedFile]
) -> tuple[Path, tuple[str, ...]]:
    """Store the files of a field of the form, replacing its previous files.

    Files that the open comparison uses stay until it is closed.

    Returns
    -------
    folder, paths
        Folder of the form, and the paths relative to it.

    Raises
    ------
    NvcoreError
        See `store_annotations`.
    """
    own = _new_slot(space, slot)
    assert space.form_folder is not None
    return space.form_folder, store_annotations(space, space.form_folder, own.name, files)


def _new_slot(space: Workspace, slot: str) -> Path:
    """Choose a folder below that of the form, and remove those of the slot that are not in use."""
    if space.form_folder is None:
        space.form_folder = new_upload(space)
    remove_unused(space, space.form_folder.glob(f"[0-9]*-{slot}"))
    return space.form_folder / f"{next(space.numbers)}-{slot}"


def store_copy(space: Workspace, slot: str, file: Path, name: str) -> Path:
    """Copy a file of the open comparison into the form's folder under another name.

    Raises
    ------
    UploadError
        If there is no room.
    """
    check_room(space, file.stat().st_size)
    own = _new_slot(space, slot)
    target = own / ANNOTATION_FOLDERS / name
    target.parent.mkdir(parents=True)
    shutil.copyfile(file, target)
    count_folder(space, own)
    return target


def new_upload(space: Workspace) -> Path:
    """Create a folder for annotations, and remove earlier ones that are no longer needed.

    The folders of the open comparison and of the form stay.
    """
    open_folder = None if space.opened is None else space.opened.session.folder
    kept = (open_folder, space.form_folder)
    remove_unused(space, (path for path in space.folder.glob("upload-*") if path not in kept))
    folder = space.folder / f"upload-{next(space.numbers)}"
    folder.mkdir(mode=0o700)
    return folder


def store_model(
    space: Workspace, file: UploadedFile, kind: str, check: Callable[[Path], object]
) -> Path:
    """Store a model, replacing the previous one of its kind.

    Raises
    ------
    NvcoreError
        If there is no room, or by `check`. The previous model then stays.
    """
    before = [*space.folder.glob(f"model-{kind}-*")]
    folder = space.folder / f"model-{kind}-{next(space.numbers)}"
    folder.mkdir(mode=0o700)
    try:
        (name,) = store_annotations(space, folder, "model", [file])
        check(folder / name)
    except NvcoreError:
        remove_folder(space, folder)
        raise
    for old in before:
        remove_folder(space, old)
    return folder / name


def remove_unused(space: Workspace, folders: Iterable[Path]) -> None:
    """Remove folders of the session in which the open comparison uses no file."""
    in_use = _paths_in_use(space)
    for folder in folders:
        if not any(path.is_relative_to(folder) for path in in_use):
            remove_folder(space, folder)


def remove_folder(space: Workspace, folder: Path) -> None:
    """Remove a folder of the session and free its share of the quota."""
    shutil.rmtree(folder, ignore_errors=True)
    with space.lock:
        for counted in [path for path in space.upload_bytes if path.is_relative_to(folder)]:
            space.used_bytes -= space.upload_bytes.pop(counted)


def count_folder(space: Workspace, folder: Path) -> None:
    """Count the bytes a run has written into a folder against the quota, until `remove_folder`.

    Raises
    ------
    UploadError
        If there is no room for it.
    """
    n_bytes = sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())
    n_more = n_bytes - space.upload_bytes[folder]
    check_room(space, n_more)
    _count(space, folder, n_more)


def _count(space: Workspace, folder: Path, n_bytes: int) -> None:
    with space.lock:
        space.used_bytes += n_bytes
        space.upload_bytes[folder] += n_bytes


def refuse_equal_names(files: Sequence[UploadedFile]) -> None:
    """Raise InputError for files of the same name, since browsers send no folders."""
    counts = Counter(file.name for file in files)
    name, n = next(iter(counts.most_common(1)), ("", 0))
    if n > 1:
        raise InputError(
            f"{n} files are called {name}, and cannot be told apart: recordings are named after "
            "their folders, which are not sent along. Send a ZIP archive with the folders, such as "
            f"TUD-Campus/gt/{name}"
        )


def store_annotations(
    space: Workspace, folder: Path, slot: str, files: Sequence[UploadedFile]
) -> tuple[str, ...]:
    """Write the files of one source. Return their paths relative to `folder`.

    A ZIP archive is unpacked into a folder of its name, which becomes the path. So layouts in
    which every file is called ``gt.txt`` keep the recordings' names.

    Raises
    ------
    UploadError
        If there is no room.
    MediaError
        If an archive is damaged or must not be unpacked. None of its content stays.
    """
    target = folder / slot / ANNOTATION_FOLDERS
    target.mkdir(parents=True)
    paths: list[Path] = []
    for file in files:
        content = file.getbuffer()
        try:
            check_room(space, len(content))
        except UploadError as error:
            raise UploadError(f"{safe_name(file.name)}: {error}", error.status) from error
        name = free_name(safe_name(file.name), (path.name for path in target.iterdir()))
        path = target / name
        try:
            path.write_bytes(content)
        except OSError as error:
            path.unlink(missing_ok=True)
            raise UploadError(
                f"{name}: The file could not be stored ({error.strerror}).",
                HTTPStatus.INSUFFICIENT_STORAGE,
            ) from error
        n_bytes = len(content)
        if path.suffix.lower() == ".zip" and kind_of(bytes(content[:HEAD_BYTES])) == "zip":
            path, n_bytes = _unpack(space, path)
        _count(space, folder / slot, n_bytes)
        paths.append(path)
    return tuple(path.relative_to(folder).as_posix() for path in paths)


def _unpack(space: Workspace, packed: Path) -> tuple[Path, int]:
    """Replace an archive by its content. Return the content's folder and its bytes."""
    n_left = max(min(n_left for n_left, _, _ in _limits(space)), 0)
    folder = packed.with_name(
        free_name(packed.stem, (path.name for path in packed.parent.iterdir()))
    )
    folder.mkdir()
    try:
        with Archive(packed, ArchiveLimits(total_bytes=min(MAX_UNPACKED_BYTES, n_left))) as archive:
            paths = archive.unpack(folder)
    except MediaError:
        shutil.rmtree(folder, ignore_errors=True)
        raise
    finally:
        packed.unlink()
    n_bytes = sum(path.stat().st_size for path in paths)
    while True:
        inside = list(folder.iterdir())
        if len(inside) != 1 or not inside[0].is_dir() or inside[0].name in ("gt", "det"):
            return folder, n_bytes
        folder = inside[0]


def _limits(space: Workspace, so_far: int = 0) -> tuple[tuple[int, str, HTTPStatus], ...]:
    """Return the bytes left under each limit, with message and HTTP status of a refusal."""
    return (
        (
            MAX_FILE_BYTES - so_far,
            f"The file is larger than {MAX_FILE_BYTES / 2**30:g} GiB; send the recordings one by "
            "one, or a shorter part.",
            HTTPStatus.REQUEST_ENTITY_TOO_LARGE,
        ),
        (
            MAX_SESSION_BYTES - space.used_bytes,
            f"A session takes {MAX_SESSION_BYTES / 2**30:g} GiB in all; remove uploads that are "
            "no longer needed.",
            HTTPStatus.REQUEST_ENTITY_TOO_LARGE,
        ),
        (
            limits_of_environment().max_disk_mb * MEBI - used_by_all(),
            "The server holds as many uploads as it may; try again later.",
            HTTPStatus.INSUFFICIENT_STORAGE,
        ),
        (
            shutil.disk_usage(space.folder).free - SPARE_BYTES,
            "There is no room left on the server's disk; tell the one who runs it.",
            HTTPStatus.INSUFFICIENT_STORAGE,
        ),
    )


def check_room(space: Workspace, n_bytes: int, *, so_far: int = 0) -> None:
    """Raise UploadError if more bytes exceed the quota, `so_far` of the file being written."""
    for n_left, message, status in _limits(space, so_far):
        if n_bytes > n_left:
            raise UploadError(message, status)
