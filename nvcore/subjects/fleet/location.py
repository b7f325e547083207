"""Folders of files, on a local disk or in an S3-compatible object store."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from datetime import datetime, timedelta
from functools import cached_property
from pathlib import Path
from typing import Any, Final, NamedTuple, cast

from nvcore.common.errors import InputError, StoreError
from nvcore.common.extras import needs

with needs("fleet", "a store needs"):
    import obstore
    import pyarrow as pa
    from deltalake.exceptions import DeltaError
    from obstore.exceptions import BaseError
    from obstore.store import LocalStore, from_url

MAX_RETRIES: Final = 20
RETRY_TIMEOUT_S: Final = 60
"""Time for retries of a request that fails. The option `max_retries` overrides it."""
_MAX_WAIT_S: Final = 5
LONGEST_REASON: Final = 400
"""Longest reason of an error of object_store or deltalake, in characters."""
_NOT_IN_NAMES: Final = re.compile(r"[\[\]\\]|%[0-9a-fA-F]{2}")
_NOT_IN_URIS: Final = re.compile(rf"[#?]|{_NOT_IN_NAMES.pattern}")
"""Characters that deltalake or obstore misread in the path of a folder, and in a URI."""
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
    """Path of a file within its location, its size in bytes and modification time."""

    path: str
    size: int
    modified: datetime


class Location:
    """A local folder or one in an object store. It can be pickled.

    Parameters
    ----------
    uri
        A path, or ``s3://bucket/folder``. ``gs://`` and ``az://`` are passed on, but not tested.
    options
        Options of object_store, such as ``aws_endpoint_url``. The environment sets the others
        (``AWS_ENDPOINT_URL``, ``AWS_ACCESS_KEY_ID``, ...).

    Attributes
    ----------
    uri
        As given, or the absolute path of a local folder.
    path
        The local folder. None for an object store.

    Raises
    ------
    InputError
        If the URI, the path or an option cannot be used.
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
        """Storage options for deltalake."""
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
        """Convert errors of the storage to StoreError with the path and the action that failed.

        A missing file is a FileNotFoundError if it was to be read or deleted.
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
        """Return the location of a subfolder."""
        return Location(f"{self.uri}/{path}", self.options)

    def read(self, path: str) -> bytes:
        """Return the bytes of a file, or raise FileNotFoundError."""
        with self.at(path, "read"):
            if self.path:  # `_files` would create the folder
                return (self.path / path).read_bytes()
            return bytes(obstore.get(self._files, path).bytes())

    def find(self, path: str) -> bytes | None:
        """Return the bytes of a file, or None if it is missing or empty (after a power failure)."""
        try:
            return self.read(path) or None
        except FileNotFoundError:
            return None

    def write(self, path: str, content: bytes) -> None:
        """Write or replace a file atomically."""
        with self.at(path, "written"):
            obstore.put(self._files, path, content)

    def create(self, path: str, content: bytes) -> bool:
        """Write a file unless it exists, and return whether it now holds this content.

        Only one of several callers with different contents gets True, even if the response to its
        first attempt was lost.
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
        """Return the files below a folder, by path, or none if it does not exist."""
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
        """Delete a file if it exists."""
        with self.at(path, "deleted"), suppress(FileNotFoundError):
            obstore.delete(self._files, path)

    def open(self, path: str) -> Any:
        """Open a file for `pyarrow.parquet`, or raise FileNotFoundError."""
        with self.at(path, "read"):
            if self.path:
                return pa.OSFile(str(self.path / path))
            return pa.PythonFile(_RemoteFile(obstore.open_reader(self._files, path)), mode="r")


class _RemoteFile:
    """A reader of obstore with the attribute that pyarrow expects of a file."""

    closed = False

    def __init__(self, reader: Any):
        self._reader = reader

    def __getattr__(self, name: str) -> Any:
        return getattr(self._reader, name)

    def read(self, size: int = -1) -> bytes:
        return bytes(self._reader.read(None if size < 0 else size))


def _reason(error: BaseException) -> str:
    """Return the message of an error of object_store or deltalake in one line."""
    text = str(error).strip().partition("\n\nDebug source")[0]
    if answer := _ANSWER.search(text):
        return f"the server says {answer[1]}"
    return ": ".join(filter(None, _LINE_STARTS.split(text)))[:LONGEST_REASON]
