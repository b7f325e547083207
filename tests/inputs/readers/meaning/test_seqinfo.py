"""Facts of a recording from seqinfo.ini."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
import reader_files

from nvcore.common.errors import FormatError
from nvcore.inputs.readers.base import SourceFile
from nvcore.inputs.readers.meaning.values import SequenceInfo, sequence_info


def source(folder: Path, info: str | bytes, inside: str = "A/gt") -> SourceFile:
    """A file of ground truth, and seqinfo.ini in folder A."""
    reader_files.source(folder, info, "A/seqinfo.ini")
    return reader_files.source(folder, "", f"{inside}/gt.txt")


FULL = "[Sequence]\nname=A\nframeRate=12.5\nseqLength=3\nimWidth=640\nimHeight=480\n"


@pytest.mark.parametrize("folder", ["A", "A/gt", "A/det/faster"])
def test_the_file_is_found_beside_and_up_to_two_folders_above(tmp_path, folder):
    info = sequence_info(source(tmp_path, FULL, folder))
    assert info == SequenceInfo(name="A", width=640, height=480, fps=12.5, n_frames=3)


@pytest.mark.parametrize("change", ["\ufeff" + FULL, FULL.replace("\n", "\r\n")])
def test_a_byte_order_mark_and_windows_line_ends_are_no_fault(tmp_path, change):
    assert sequence_info(source(tmp_path, change)).n_frames == 3


def test_without_the_file_or_its_keys_nothing_is_known(tmp_path):
    info = sequence_info(reader_files.source(tmp_path, "", "B/gt.txt"))
    assert (info.name, info.n_frames) == (None, None)
    assert math.isnan(info.width)
    info = sequence_info(source(tmp_path, "[Sequence]\nseqLength=3\n"))
    assert (info.name, info.n_frames) == (None, 3)
    assert math.isnan(info.fps)


@pytest.mark.parametrize(
    ("info", "words"),
    [
        ("frameRate=30\n", r"expected \[Sequence\]"),
        ("[Other]\nframeRate=30\n", r"expected a section \[Sequence\]"),
        ("[Sequence]\nframeRate=0\n", "expected frameRate as a positive number, found '0'"),
        ("[Sequence]\nframeRate=inf\n", "expected frameRate as a positive number"),
        ("[Sequence]\nimWidth=wide\n", "expected imWidth as a positive number, found 'wide'"),
        ("[Sequence]\nseqLength=3.5\n", "expected seqLength as a whole number"),
        ("[Sequence]\nseqLength=1e15\n", "expected seqLength as a whole number up to 10000000"),
        (b"[Sequence]\nname=\xff\n", "expected UTF-8 text"),
    ],
)
def test_a_fault_is_named_with_the_file_it_belongs_to(tmp_path, info, words):
    with pytest.raises(FormatError, match=rf"^seqinfo\.ini of A/gt/gt\.txt.*{words}"):
        sequence_info(source(tmp_path, info))
