"""Untrusted ZIP archives, checked before a member is read, and read without unpacking.

Refused are members outside the archive's own folder (absolute, ``..``), links, encrypted members,
unusual compression, the same name twice, and more data than the limits allow, both by what the
archive states and by what it holds.
"""

from __future__ import annotations

import re
import stat
import struct
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from threading import Lock
from typing import IO, Final

from nvcore.common.errors import MediaError
from nvcore.common.wording import one_line

_CHUNK: Final = 1 << 20
_MOST_FOLDERS: Final = 32
"""Depth of folders: Python 3.11 cannot remove some thousand again."""
_END: Final = struct.Struct("<4s4H2LH")
_END_64: Final = struct.Struct("<4sQ2H2L4Q")
_LOCATOR_64: Final = struct.Struct("<4sLQL")
_UNREADABLE = (zipfile.BadZipFile, zlib.error, EOFError, RuntimeError, ValueError, struct.error)
"""Exceptions that zipfile raises for a damaged or malicious archive."""


@dataclass(frozen=True)
class ArchiveLimits:
    """Limits on the content of an archive.

    Attributes
    ----------
    members
        Number of files.
    member_bytes, total_bytes, directory_bytes
        Size of one file and of all, unpacked, and of the table of contents.
    ratio
        Unpacked over packed size, for archives that unpack to more than `ratio_from_bytes`.
    """

    members: int = 200_000
    member_bytes: int = 1 << 29
    total_bytes: int = 1 << 34
    ratio: float = 200.0
    ratio_from_bytes: int = 1 << 26
    directory_bytes: int = 1 << 26


class Archive:
    """An open archive that has passed the checks.

    Attributes
    ----------
    name
        File name of the archive, for errors.
    names
        Paths of its files in the archive's order, without those that operating systems add.
    """

    def __init__(self, path: Path, limits: ArchiveLimits | None = None):
        """Open and check.

        Raises
        ------
        MediaError
            If it is no archive, is damaged, or may not be unpacked. Names the member.
        """
        self.name = path.name
        self._limits = limits or ArchiveLimits()
        self._lock = Lock()
        with self._reading():
            _check_directory(path, self._limits)
            self._zip = zipfile.ZipFile(path)
        try:
            # by the name, not by is_dir, which fails where there is none
            members = [item for item in self._zip.infolist() if not item.filename.endswith("/")]
            self._check(members, path)
            self._members = {
                member.filename: member for member in members if not _is_added(member.filename)
            }
        except MediaError:
            self._zip.close()
            raise
        self.names = tuple(self._members)

    def __enter__(self) -> Archive:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the file."""
        self._zip.close()

    def read(self, name: str) -> bytes:
        """Return the content of one file. Any thread may call it.

        Raises
        ------
        MediaError
            If it is damaged, or larger than the archive says.
        """
        member = self._members[name]
        with self._lock, self._reading(name), self._zip.open(member) as stream:
            content = stream.read(member.file_size + 1)
        if len(content) != member.file_size:
            raise self._refuse("is not of the size that the archive says; pack it again", name)
        return content

    def unpack(self, folder: Path) -> list[Path]:
        """Unpack all files below a folder and return their paths, in the archive's order.

        Raises
        ------
        MediaError
            If a member is damaged, or there is no room. Files unpacked before stay.
        """
        paths = []
        for name, member in self._members.items():
            target = folder.joinpath(*PurePosixPath(name.replace("\\", "/")).parts)
            try:
                target.parent.mkdir(parents=True, exist_ok=True)
                with (
                    self._lock,
                    self._reading(name),
                    self._zip.open(member) as stream,
                    target.open("xb") as out,
                ):
                    self._copy(stream, out, member)
            except OSError as error:
                raise self._refuse(f"cannot be unpacked ({error.strerror})", name) from error
            paths.append(target)
        return paths

    def _copy(self, stream: IO[bytes], out: IO[bytes], member: zipfile.ZipInfo) -> None:
        left = member.file_size
        while chunk := stream.read(_CHUNK):
            left -= len(chunk)
            if left < 0:
                raise self._refuse("is larger than the archive says", member.filename)
            out.write(chunk)

    @contextmanager
    def _reading(self, member: str | None = None) -> Iterator[None]:
        try:
            yield
        except _UNREADABLE as error:
            raise self._refuse("is damaged, or no ZIP archive; pack it again", member) from error
        except OSError as error:
            raise self._refuse(f"cannot be read ({error.strerror})", member) from error

    def _refuse(self, message: str, member: str | None = None) -> MediaError:
        where = "" if member is None else f"member {one_line(member)[:100]!r}: "
        return MediaError(where + message, file=self.name)

    def _check(self, members: list[zipfile.ZipInfo], path: Path) -> None:
        limits = self._limits
        if len(members) > limits.members:
            raise self._refuse(f"holds {len(members)} files; at most {limits.members} are read")
        names: set[str] = set()
        # a loop over members: each has a name to be taken apart
        for member in members:
            self._check_member(member)
            if member.filename in names:
                raise self._refuse("occurs twice; pack it again", member.filename)
            names.add(member.filename)
        total = sum(member.file_size for member in members)
        if total > limits.total_bytes:
            raise self._refuse(
                f"unpacks to {total / 2**30:.1f} GiB; at most {limits.total_bytes / 2**30:.1f} GiB "
                "are read: give it in parts"
            )
        packed = max(path.stat().st_size, 1)
        if total > limits.ratio_from_bytes and total / packed > limits.ratio:
            raise self._refuse(
                f"unpacks to {total / packed:.0f} times its size, as only archives made to do "
                "harm do; give the files themselves"
            )

    def _check_member(self, member: zipfile.ZipInfo) -> None:
        name = member.filename
        parts = re.split(r"[/\\]", member.orig_filename)
        if parts[0] == "" or ".." in parts or ":" in parts[0] or "\0" in member.orig_filename:
            raise self._refuse("lies outside the archive's folder; pack it again", name)
        if len(parts) - 1 > _MOST_FOLDERS:
            raise self._refuse(
                f"lies in {len(parts) - 1} folders, one inside the other; pack it with "
                f"{_MOST_FOLDERS} at the most",
                name,
            )
        if stat.S_ISLNK(member.external_attr >> 16):
            raise self._refuse("is a link; pack the file itself", name)
        if member.flag_bits & 1:
            raise self._refuse("is encrypted; pack it without a password", name)
        if member.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
            raise self._refuse("is packed by an unusual method; use the usual one (deflate)", name)
        if member.file_size > self._limits.member_bytes:
            raise self._refuse(
                f"unpacks to {member.file_size / 2**20:.0f} MiB; at most "
                f"{self._limits.member_bytes / 2**20:.0f} MiB are read",
                name,
            )


def _is_added(name: str) -> bool:
    """Whether an operating system put it there: ``__MACOSX/``, ``.DS_Store``, ``Thumbs.db``."""
    parts = PurePosixPath(name).parts
    return (
        "__MACOSX" in parts
        or any(part.startswith(".") for part in parts)
        or parts[-1:] in (("Thumbs.db",), ("desktop.ini",))
    )


def _check_directory(path: Path, limits: ArchiveLimits) -> None:
    """Refuse a table of contents that would fill the memory: zipfile reads it all at once."""
    with path.open("rb") as file:
        n_bytes = file.seek(0, 2)
        start = file.seek(max(0, n_bytes - (1 << 16) - _END.size - _LOCATOR_64.size))
        tail = file.read()
        position = tail.rfind(b"PK\5\6")
        if position < 0 or len(tail) < position + _END.size:
            raise MediaError(
                "is no ZIP archive, or is cut off: its table of contents is missing; pack or copy "
                "it again",
                file=path.name,
            )
        size = _END.unpack_from(tail, position)[5]
        locator = position - _LOCATOR_64.size
        if locator >= 0 and tail[locator : locator + 4] == b"PK\6\7":
            stated = _LOCATOR_64.unpack_from(tail, locator)[2]
            sizes = [0 if size == 0xFFFFFFFF else size]
            # zipfile reads the record before the locator, other programs where the locator says
            for place in (start + locator - _END_64.size, stated):
                file.seek(min(max(place, 0), n_bytes))
                record = file.read(_END_64.size)
                if len(record) == _END_64.size and record.startswith(b"PK\6\6"):
                    sizes.append(_END_64.unpack(record)[8])
            size = max(sizes)
    if size > limits.directory_bytes:
        raise MediaError(
            f"has a table of contents of {size / 2**20:.0f} MiB; at most "
            f"{limits.directory_bytes / 2**20:.0f} MiB are read: give it in parts",
            file=path.name,
        )
