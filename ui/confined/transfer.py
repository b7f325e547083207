"""Answers between processes: large arrays in memory that both share, so that none is copied over.

A dataset of a million frames has some 900 MB. Sent through a socket it would be copied four times.
"""

from __future__ import annotations

import mmap
import os
import pickle
from dataclasses import dataclass
from multiprocessing.connection import Connection
from multiprocessing.reduction import recv_handle, send_handle
from typing import Any, Final

LEAST_OF_ONE: Final = 1 << 16
"""Bytes of an array from which on it goes by itself ..."""
LEAST_OF_ALL: Final = 1 << 18
"""... if all together have so many: a picture of 640x480 in colour takes half the time."""
ALIGNED: Final = 64
"""Bytes that each array starts at a multiple of."""


@dataclass(frozen=True)
class Fault:
    """An exception that is no word to a user: its name and text."""

    text: str


def send_answer(connection: Connection, answer: object) -> None:
    """Send what `receive_answer` receives."""
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
        for array, start in zip(arrays, _starts(sizes), strict=False):
            _write(handle, array.raw(), start)
        connection.send(sizes)
        connection.send_bytes(content)
        send_handle(connection, handle, 0)
    finally:
        os.close(handle)


def receive_answer(connection: Connection) -> Any:
    """What the other process sent; large arrays are read-only.

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
    starts = _starts(sizes)
    arrays = [shared[start : start + n] for start, n in zip(starts, sizes, strict=False)]
    return pickle.loads(content, buffers=arrays)  # noqa: S301  # from our own process


def _starts(sizes: list[int]) -> list[int]:
    """Where each array begins."""
    starts, start = [], 0
    for size in sizes:
        starts.append(start)
        start += -(-size // ALIGNED) * ALIGNED
    return starts


def _write(handle: int, content: memoryview, start: int) -> None:
    """Write all of it: the system takes 2 GB at a time at the most."""
    while len(content):
        n_written = os.pwrite(handle, content, start)
        content, start = content[n_written:], start + n_written
