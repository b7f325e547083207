"""Whatever a file holds, the readers end in an error that can be mended, or in tables."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from places import DATA

from nvcore.common.errors import NvcoreError
from nvcore.inputs.readers import voc, yolo
from nvcore.inputs.readers.base import Format, ReadOptions, SourceFile
from nvcore.inputs.readers.cvat import images, video

CASES = [
    (video.FORMAT, DATA / "cvat_video" / "annotations.xml"),
    (images.FORMAT, DATA / "cvat_images" / "annotations.xml"),
    (voc.FORMAT, DATA / "voc" / "drive1" / "000007.xml"),
    (yolo.FORMAT, DATA / "yolo" / "drive1" / "000001.txt"),
]
PIECES = [
    *b"nan -1 1e999 1.5 < </box> &amp; &x; \x00 \xff true box track image object person".split(),
    *(
        b"",
        b"inf",
        b"9" * 20,
        b"\n",
        b"0 .5 .5 .1 .1 .5\n",
        b'"',
        b"step=3",
        b"<box/>",
        b"<object/>",
    ),
    "\u0663".encode(),
]
QUICK = settings(
    max_examples=40,
    deadline=None,
    database=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)


def assert_read_or_refused(kind: Format, content: bytes, folder: Path) -> None:
    path = folder / f"drive_1{kind.suffixes[0]}"
    path.write_bytes(content)
    kind.recognise(path.name, content.decode("utf-8", errors="replace"), "truth")
    try:
        told = kind.read([SourceFile(path, path.name)], ReadOptions(size=(640, 480))).conversion
    except NvcoreError as error:
        told = str(error)
    assert told


@pytest.mark.parametrize(("kind", "golden"), CASES, ids=lambda case: getattr(case, "name", ""))
@QUICK
@given(
    changes=st.lists(
        st.tuples(st.floats(0, 1), st.integers(0, 12), st.sampled_from(PIECES)),
        min_size=1,
        max_size=3,
    )
)
def test_damaged_files_are_refused_or_read(
    tmp_path: Path, kind: Format, golden: Path, changes: list[tuple[float, int, bytes]]
) -> None:
    content = golden.read_bytes()
    for share, length, piece in changes:
        at = int(share * len(content))
        content = content[:at] + piece + content[at + length :]
    assert_read_or_refused(kind, content, tmp_path)
