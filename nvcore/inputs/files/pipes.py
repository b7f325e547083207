"""Pipes as inputs: named pipes, and those of a shell's ``<(zcat truth.csv.gz)``.

Files are read more than once: to recognise the format, for their hashes, by the reader. Within
`pipes_kept`, the content of pipes is therefore kept.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from contextvars import ContextVar
from io import BufferedReader
from pathlib import Path
from threading import Lock
from typing import Any, Final

from nvcore.common.errors import InputError

MAX_PIPE_BYTES: Final = 1 << 32
"""Largest content of one pipe."""
_CHUNK: Final = 1 << 20
_OF_THIS_RUN: Final = ("/dev/stdin", "/dev/fd/", "/proc/self/fd/")


class _PipeContents:
    """Contents of pipes in temporary files, by the identity of the pipe."""

    def __init__(self, files: ExitStack):
        self._files = files
        self._paths: dict[tuple[int, int], Path] = {}
        self._lock = Lock()

    def file_of(self, pipe: Path) -> Path:
        status = pipe.stat()
        identity = status.st_dev, status.st_ino
        with self._lock:
            if identity not in self._paths:
                self._paths[identity] = self._read(pipe)
            return self._paths[identity]

    def _read(self, pipe: Path) -> Path:
        # without a name if it can be opened by number, so that a killed process leaves no file
        has_numbers = Path("/proc/self/fd").is_dir()
        content: Any = (
            tempfile.TemporaryFile()  # noqa: SIM115  # closed later
            if has_numbers
            else tempfile.NamedTemporaryFile(prefix="nvcore-pipe-")  # noqa: SIM115  # likewise
        )
        self._files.enter_context(content)
        n_bytes = 0
        with pipe.open("rb") as stream:
            while part := stream.read(_CHUNK):
                n_bytes += len(part)
                if n_bytes > MAX_PIPE_BYTES:
                    raise InputError(
                        f"more than {MAX_PIPE_BYTES >> 30} GiB come through this pipe; give a file",
                        file=pipe,
                    )
                content.write(part)
        content.flush()
        return Path(f"/proc/self/fd/{content.fileno()}" if has_numbers else content.name)


_contents: ContextVar[_PipeContents | None] = ContextVar("pipes", default=None)


@contextmanager
def pipes_kept() -> Iterator[None]:
    """Keep the content of pipes in this context, so that they can be read again like files.

    Nested contexts share the outer one. A thread shares it only if it runs in a copy of the
    caller's `contextvars` context.
    """
    if _contents.get() is not None:
        yield
        return
    with ExitStack() as files:
        token = _contents.set(_PipeContents(files))
        try:
            yield
        finally:
            _contents.reset(token)


def is_pipe(path: Path) -> bool:
    """Whether the path can be read only in this run: a pipe, or a file that a shell opened."""
    if path.as_posix().startswith(_OF_THIS_RUN):
        return True
    try:
        return path.is_fifo()
    except OSError:  # a name that is too long, or an unreadable folder
        return False


def open_stored(path: Path) -> BufferedReader:
    """Open a file without decompressing it, or the kept content of a pipe.

    Raises
    ------
    OSError
        If it cannot be opened.
    InputError
        If it is a pipe outside `pipes_kept`, or its content is too large.
    """
    if not path.is_fifo():
        return path.open("rb")
    contents = _contents.get()
    if contents is None:
        raise InputError("is a pipe; expected a file", file=path.name)
    return contents.file_of(path).open("rb")
