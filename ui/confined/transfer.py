"""Answers between processes, with large arrays in shared memory.

A dataset of a million frames has some 900 MB. Sent through a socket it would be copied four times.
"""

from __future__ import annotations

import mmap
import os
import pickle
from dataclasses import dataclass
from itertools import accumulate
from multiprocessing.connection import Connection
from multiprocessing.reduction import recv_handle, send_handle
from typing import Any, Final, NamedTuple

LEAST_OF_ONE: Final = 1 << 16
"""Smallest array that is shared, bytes."""
LEAST_OF_ALL: Final = 1 << 18
"""Smallest total size of arrays that are shared, bytes: half the time for a 640x480 picture."""
ALIGNED: Final = 64
"""Alignment of each array, bytes."""


@dataclass(frozen=True)
class Fault:
    """Name and text of an exception that is a bug of the program."""

    text: str


class Step(NamedTuple):
    """Progress of a call before its answer: the share done, 0..1, and words."""

    share: float
    words: str


def send_answer(connection: Connection, answer: object) -> None:
    """Send an answer to `receive_answer`."""
    arrays: list[pickle.PickleBuffer] = []

    def stays_inside(array: pickle.PickleBuffer) -> bool:
        if array.raw().nbytes < LEAST_OF_ONE:
            return True
        arrays.append(array)
        return False

    content = pickle.dumps(answer, protocol=5, buffer_callback=stays_inside)
    sizes = [array.raw().nbytes for array in arrays]
    if sum(sizes) < LEAST_OF_ALL or not hasattr(os, "memfd_create"):
        connection.send(None)
        connection.send(answer)
        return
    handle = os.memfd_create("answer")
    try:
        for array, start in zip(arrays, _starts(sizes), strict=True):
            _write(handle, array.raw(), start)
        connection.send(sizes)
        connection.send_bytes(content)
        send_handle(connection, handle, 0)
    finally:
        os.close(handle)


def receive_answer(connection: Connection) -> Any:
    """Return the answer of the other process. Large arrays are read-only.

    Raises
    ------
    EOFError, OSError
        If the other process has ended.
    """
    sizes: list[int] | None = connection.recv()
    if sizes is None:
        return connection.recv()
    content = connection.recv_bytes()
    handle = recv_handle(connection)
    try:
        shared = memoryview(mmap.mmap(handle, 0, access=mmap.ACCESS_READ))
    finally:
        os.close(handle)
    arrays = [shared[start : start + n] for start, n in zip(_starts(sizes), sizes, strict=True)]
    return pickle.loads(content, buffers=arrays)  # noqa: S301  # from our own process


def _starts(sizes: list[int]) -> list[int]:
    """Return the offset of each array."""
    padded = (-(-size // ALIGNED) * ALIGNED for size in sizes)
    return list(accumulate(padded, initial=0))[:-1]


def _write(handle: int, content: memoryview, start: int) -> None:
    """Write all of the content in several calls, as the system takes at most 2 GB at a time."""
    while len(content):
        n_written = os.pwrite(handle, content, start)
        content, start = content[n_written:], start + n_written
