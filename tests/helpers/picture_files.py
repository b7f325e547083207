"""Videos and pictures for tests: the picture's number stands in eight blocks of its pixels."""

from __future__ import annotations

import struct
import zipfile
import zlib
from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path

import av
import cv2
import numpy as np

WIDTH, HEIGHT, BLOCK = 64, 48, 8


def numbered(number: int) -> np.ndarray:
    """A grey picture that holds a number below 256."""
    bits = [255 if number >> bit & 1 else 0 for bit in range(8)]
    return np.tile(np.repeat(np.array(bits, np.uint8), BLOCK), (HEIGHT, 1))


def number_in(picture: np.ndarray) -> int:
    """The number that a picture holds."""
    grey = picture if picture.ndim == 2 else picture[..., 1]
    middles = grey[HEIGHT // 2, BLOCK // 2 : 8 * BLOCK : BLOCK] > 128
    return sum(int(bit) << position for position, bit in enumerate(middles))


def write_numbered_video(
    path: Path,
    codec: str = "libx264",
    *,
    n: int = 100,
    container: str | None = None,
    times: list[int] | None = None,
    pixels: str = "yuv420p",
    **options: str,
) -> Path:
    """A video of n numbered pictures at 20 per second, or shown at these 20ths of a second."""
    with av.open(str(path), "w", format=container) as output:
        stream = output.add_stream(codec, rate=20)
        stream.width, stream.height, stream.pix_fmt = WIDTH, HEIGHT, pixels
        stream.options = options
        for number in range(n):
            frame = av.VideoFrame.from_ndarray(numbered(number), format="gray")
            frame.pts = number if times is None else times[number]
            frame.time_base = Fraction(1, 20)
            output.mux(stream.encode(frame))
        output.mux(stream.encode(None))
    return path


def encoded(picture: np.ndarray, ending: str = ".png", options: Sequence[int] = ()) -> bytes:
    """The picture as a file's content."""
    done, content = cv2.imencode(ending, picture, options)
    assert done
    return bytes(content)


def write_picture(path: Path, picture: np.ndarray) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(encoded(picture, path.suffix))
    return path


def write_zip(path: Path, members: dict[str, bytes]) -> Path:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    return path


def png_that_claims(width: int, height: int) -> bytes:
    """A small PNG whose header states a size."""
    header = b"IHDR" + struct.pack(">2L5B", width, height, 8, 0, 0, 0, 0)
    parts = [b"\x89PNG\r\n\x1a\n"]
    for chunk in (header, b"IDAT" + zlib.compress(bytes(1000)), b"IEND"):
        parts.append(
            struct.pack(">L", len(chunk) - 4) + chunk + struct.pack(">L", zlib.crc32(chunk))
        )
    return b"".join(parts)
