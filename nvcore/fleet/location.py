"""Folders of files, on a disk or in an S3-compatible store."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from datetime import datetime, timedelta
from functools import cached_property, partial
from io import SEEK_CUR, SEEK_END, SEEK_SET, RawIOBase
from pathlib import Path
from typing import Any, Final, NamedTuple, cast

from nvcore.errors import InputError, StoreError
from nvcore.extras import needs

with needs("fleet", "a store needs"):
    import obstore
    import pyarrow as pa
    from deltalake.exceptions import DeltaError
    from obstore.exceptions import BaseError
    from obstore.store import LocalStore, from_url

MAX_RETRIES: Final = 20
RETRY_TIMEOUT_S: Final = 60
"""Of a request that the server refuses or cuts; the option `max_retries` goes before the number."""
_MAX_WAIT_S: Final = 5
LONGEST_REASON: Final = 400
"""Letters of what a program below says of an error."""
_NOT_IN_NAMES: Final = re.compile(r"[\[\]\\]|%[0-9a-fA-F]{2}")
_NOT_IN_URIS: Final = re.compile(rf"[#?]|{_NOT_IN_NAMES.pattern}")
"""What deltalake and obstore misread in the path of a folder, and in a URI."""
_ANSWER: Final = re.compile(r"<Code>(\w{1,60})</Code>")
_LINE_STARTS: Final = re.compile(r"\s*\n(?:\s|\x1b\[\d+m|↳)*")
_REMOTE: Final = ("s3", "s3a", "gs", "az", "abfs", "abfss")
_DELTA_OPTIONS: Final = {
    "max_retries": str(MAX_RETRIES),
    "retry_timeout": f"{RETRY_TIMEOUT_S}s",
    "backoff_config.max_backoff": f"{_MAX_WAIT_S}s",
    "aws_conditional_put": "etag",
}


class Entry(NamedTuple):
    """A file of a location: its path within it, bytes, time of the last change."""

    path: str
    size: int
    modified: datetime


class Location:
    """A folder, local or S3-compatible. It pickles: another process opens it anew.

    Parameters
    ----------
    uri
        A path, or ``s3://bucket/folder``; ``gs://`` and ``az://`` are passed on, but not tested.
    options
        Keys as object_store has them, such as ``aws_endpoint_url``; what is not given is taken from
        the environment (``AWS_ENDPOINT_URL``, ``AWS_ACCESS_KEY_ID``, ...).

    Attributes
    ----------
    uri
        As given; of a local folder, its absolute path.
    path
        The folder on a disk; None: it is in an object store.

    Raises
    ------
    InputError
        If nothing can read such a URI or path, or an option is unknown.
    """

    def __init__(self, uri: str | Path, options: Mapping[str, str] | None = None):
        scheme, separator, rest = str(uri).partition("://")
        self.options = dict(options or {})
        self.path: Path | None = None
        if separator and scheme in _REMOTE:
            self.uri = str(uri).rstrip("/")
            misread = _NOT_IN_URIS.search(self.uri)
        elif separator and scheme != "file":
            raise InputError(
                f"{scheme}:// is no place for a store; expected a folder, or s3://bucket/folder",
                file=str(uri),
            )
        else:
            self.path = Path(rest if separator else uri).expanduser().absolute()
            self.uri = str(self.path)
            misread = _NOT_IN_NAMES.search(self.path.as_posix())
        if misread:
            raise InputError(
                f"{misread[0]!r} cannot be in the path of a store; name another folder",
                file=self.uri,
            )

    def __getstate__(self) -> dict[str, Any]:
        return {"uri": self.uri, "options": self.options, "path": self.path}

    def __repr__(self) -> str:
        return f"Location({self.uri!r})"

    @property
    def delta_options(self) -> dict[str, str]:
        """Options with which deltalake opens a table in this location."""
        return dict(self.options) if self.path else _DELTA_OPTIONS | self.options

    @cached_property
    def _files(self) -> Any:
        if self.path:
            return LocalStore(self.path, mkdir=True)
        options = {"max_retries": str(MAX_RETRIES), **self.options}
        http = options.pop("aws_allow_http", os.environ.get("AWS_ALLOW_HTTP", "false")).lower()
        try:
            return from_url(
                self.uri,
                config=cast(Any, options),
                client_options={"allow_http": http == "true"},
                retry_config={
                    "max_retries": int(options.pop("max_retries")),
                    "retry_timeout": timedelta(seconds=RETRY_TIMEOUT_S),
                    "backoff": {"max_backoff": timedelta(seconds=_MAX_WAIT_S)},
                },
            )
        except (BaseError, ValueError) as error:
            raise InputError(f"cannot be used ({_reason(error)})", file=self.uri) from error

    @contextmanager
    def at(self, path: str, done: str) -> Iterator[None]:
        """Within it, an error of the storage says where, and what could not be done.

        Raises
        ------
        FileNotFoundError
            If a file that is read or deleted is not there.
        StoreError
            In all other cases: the disk is full, the server is gone, it is not allowed.
        """
        try:
            yield
        except (BaseError, DeltaError, OSError) as error:
            if isinstance(error, FileNotFoundError) and done in ("read", "deleted"):
                raise FileNotFoundError(f"there is no {self.uri}/{path}") from error
            raise StoreError(
                f"cannot be {done} ({_reason(error)})", file=f"{self.uri}/{path}"
            ) from error

    def child(self, path: str) -> Location:
        """A folder within it."""
        return Location(f"{self.uri}/{path}", self.options)

    def read(self, path: str) -> bytes:
        """The bytes of a file; FileNotFoundError if there is none."""
        with self.at(path, "read"):
            if self.path:  # which makes no folder
                return (self.path / path).read_bytes()
            return bytes(obstore.get(self._files, path).bytes())

    def find(self, path: str) -> bytes | None:
        """The bytes of a file; None: there is none, or an empty one of a machine that failed."""
        try:
            return self.read(path) or None
        except FileNotFoundError:
            return None

    def write(self, path: str, content: bytes) -> None:
        """Write a file whole, in place of one that may be there: nobody sees half of it."""
        with self.at(path, "written"):
            obstore.put(self._files, path, content)

    def create(self, path: str, content: bytes) -> bool:
        """Write a file unless there is one; whether it now holds this content.

        Of several at once with different contents, such as their names, one alone is told True,
        also where the answer to its first attempt was lost.
        """
        with self.at(path, "written"):
            try:
                obstore.put(self._files, path, content, mode="create", use_multipart=False)
            except BaseError:
                with suppress(FileNotFoundError):
                    return self.read(path) == content
                raise
            return True

    def list(self, prefix: str = "") -> list[Entry]:
        """Files within a folder and its folders, by path; none of a folder that is not there."""
        with self.at(prefix, "listed"):
            if self.path and not (self.path / prefix).is_dir():
                return []
            found = [
                Entry(entry["path"], entry["size"], entry["last_modified"])
                for part in obstore.list(self._files, prefix or None)
                for entry in part
            ]
        return sorted(found)

    def delete(self, path: str) -> None:
        """Delete a file, if it is there."""
        with self.at(path, "deleted"), suppress(FileNotFoundError):
            obstore.delete(self._files, path)

    def open(self, path: str) -> Any:
        """A file for `pyarrow.parquet`, of which only what is asked for is read.

        Raises
        ------
        FileNotFoundError
            If there is none.
        """
        with self.at(path, "read"):
            if self.path:
                return pa.OSFile(str(self.path / path))
            return pa.PythonFile(_Ranges(self._files, path), mode="r")


class _Ranges(RawIOBase):
    """A file in an object store, of which the ranges that are read are fetched, and no more.

    `obstore.open_reader` cannot be used: pyarrow asks whether a file is closed.
    """

    def __init__(self, files: Any, path: str):
        self._fetch = partial(obstore.get_range, files, path)
        self._size = obstore.head(files, path)["size"]
        self._place = 0

    def readable(self) -> bool:
        return True

    def seekable(self) -> bool:
        return True

    def tell(self) -> int:
        return self._place

    def seek(self, offset: int, whence: int = SEEK_SET, /) -> int:
        self._place = offset + {SEEK_SET: 0, SEEK_CUR: self._place, SEEK_END: self._size}[whence]
        return self._place

    def read(self, size: int = -1, /) -> bytes:
        left = self._size - self._place
        length = left if size < 0 else min(size, left)
        content = bytes(self._fetch(start=self._place, length=length)) if length > 0 else b""
        self._place += len(content)
        return content


def _reason(error: BaseException) -> str:
    """What an error of object_store or deltalake says, in one line without colours."""
    text = str(error).strip().partition("\n\nDebug source")[0]
    if answer := _ANSWER.search(text):
        return f"the server says {answer[1]}"
    return ": ".join(filter(None, _LINE_STARTS.split(text)))[:LONGEST_REASON]
