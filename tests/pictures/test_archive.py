"""Archives made to do harm are refused with a clear message; honest ones are read."""

from __future__ import annotations

import struct
import zipfile
from pathlib import Path

import pytest
from picture_files import write_zip

from nvcore.common.errors import MediaError
from nvcore.pictures import Archive, ArchiveLimits


def test_files_are_read_and_unpacked_below_the_folder(tmp_path: Path):
    members = {"b/gt/gt.txt": b"1,2", "a.txt": b"3", ".DS_Store": b"x", "__MACOSX/a": b"y"}
    with Archive(write_zip(tmp_path / "a.zip", members)) as archive:
        assert archive.names == ("b/gt/gt.txt", "a.txt")
        assert archive.read("a.txt") == b"3"
        written = archive.unpack(tmp_path / "out")
    assert written == [tmp_path / "out/b/gt/gt.txt", tmp_path / "out/a.txt"]
    assert written[0].read_bytes() == b"1,2"


def assert_refused(path: Path, words: str, **limits: int) -> None:
    with pytest.raises(MediaError, match=words) as caught:
        Archive(path, ArchiveLimits(**limits))
    assert caught.value.file == path.name


@pytest.mark.parametrize(
    "name", ["../a", "a/../../b", "/etc/a", "\\a", "..\\a", "C:\\a", "C:a", "a\\..\\b"]
)
def test_members_outside_the_folder_are_refused(tmp_path: Path, name: str):
    path = write_zip(tmp_path / "a.zip", {"ok": b"", name: b"x"})
    assert_refused(path, "outside the archive's folder")


def test_folders_without_end_are_refused(tmp_path: Path):
    deep = "a/" * 32 + "b"
    with Archive(write_zip(tmp_path / "a.zip", {deep: b""})) as archive:
        assert archive.names == (deep,)
    path = write_zip(tmp_path / "b.zip", {"a/" * 33 + "b": b""})
    assert_refused(path, "lies in 33 folders, one inside the other")


def test_a_member_without_a_name_is_refused(tmp_path: Path):
    path = write_zip(tmp_path / "a.zip", {"m": b"x"})
    content = bytearray(path.read_bytes())
    entry = content.index(b"PK\1\2")
    content[entry + 28] = 0  # the name's length, by which the name is taken for a comment
    content[entry + 32] = 1
    path.write_bytes(content)
    assert_refused(path, "member '': lies outside the archive's folder")


def test_links_are_refused(tmp_path: Path):
    member = zipfile.ZipInfo("a.png")
    member.external_attr = 0o120777 << 16
    with zipfile.ZipFile(tmp_path / "a.zip", "w") as archive:
        archive.writestr(member, "/etc/passwd")
    assert_refused(tmp_path / "a.zip", r"member 'a\.png': is a link")


def test_encrypted_members_are_refused(tmp_path: Path):
    path = write_zip(tmp_path / "a.zip", {"a.png": b"x"})
    content = bytearray(path.read_bytes())
    at = content.index(b"PK\1\2")
    content[at + 8] |= 1
    path.write_bytes(content)
    assert_refused(path, "is encrypted; pack it without a password")


def test_unusual_compression_is_refused(tmp_path: Path):
    with zipfile.ZipFile(tmp_path / "a.zip", "w", zipfile.ZIP_LZMA) as archive:
        archive.writestr("a.png", b"x")
    assert_refused(tmp_path / "a.zip", "packed by an unusual method")


def test_the_same_name_twice_is_refused(tmp_path: Path):
    with zipfile.ZipFile(tmp_path / "a.zip", "w") as archive:
        archive.writestr("a.png", b"x")
        with pytest.warns(UserWarning, match="Duplicate name"):
            archive.writestr("a.png", b"y")
    assert_refused(tmp_path / "a.zip", r"member 'a\.png': occurs twice")


@pytest.mark.parametrize(
    ("words", "limits"),
    [
        (r"unpacks to \d+ times its size", {"ratio_from_bytes": 1 << 19}),
        ("member 'a': unpacks to 1 MiB; at most 0 MiB", {"member_bytes": 1 << 19}),
        ("unpacks to 0.0 GiB; at most", {"total_bytes": 1 << 19}),
        ("holds 2 files; at most 1 are read", {"members": 1}),
        ("table of contents of 0 MiB", {"directory_bytes": 10}),
    ],
)
def test_bombs_are_refused_by_ratio_size_and_number(
    tmp_path: Path, words: str, limits: dict[str, int]
):
    path = write_zip(tmp_path / "a.zip", {"a": bytes(1 << 20), "b": b"x"})
    assert_refused(path, words, **limits)


def test_a_bomb_of_the_usual_kind_is_refused_by_default(tmp_path: Path):
    path = write_zip(tmp_path / "a.zip", {f"{n}.bmp": bytes(33 << 20) for n in range(2)})
    assert_refused(path, r"unpacks to \d+ times its size, as only archives made to do harm do")


def test_a_member_that_lies_about_its_size_is_refused(tmp_path: Path):
    path = write_zip(tmp_path / "a.zip", {"a.png": bytes(100_000)})
    content = bytearray(path.read_bytes())
    at = content.index(b"PK\1\2")
    struct.pack_into("<L", content, at + 24, 10)
    path.write_bytes(content)
    with Archive(path) as archive:
        with pytest.raises(MediaError, match=r"'a\.png': is (damaged|not of the size|larger)"):
            archive.read("a.png")
        with pytest.raises(MediaError, match=r"'a\.png': is (damaged|larger)"):
            archive.unpack(tmp_path / "out")


def test_a_damaged_member_is_named(tmp_path: Path):
    path = tmp_path / "a.zip"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("a.png", b"hello hello")
    path.write_bytes(path.read_bytes().replace(b"hello hello", b"hello hellO"))
    with Archive(path) as archive, pytest.raises(MediaError, match=r"member 'a\.png': is damaged"):
        archive.read("a.png")


def test_a_file_and_a_folder_of_one_name_are_an_error(tmp_path: Path):
    path = write_zip(tmp_path / "a.zip", {"a": b"x", "a/b": b"y"})
    with Archive(path) as archive, pytest.raises(MediaError, match="member 'a/b': cannot be unpa"):
        archive.unpack(tmp_path / "out")


@pytest.mark.parametrize("content", [b"", b"PK\3\4" + bytes(100), b"frame,x\n", b"PK\5\6" * 9])
def test_what_is_no_whole_archive_is_refused(tmp_path: Path, content: bytes):
    (tmp_path / "a.zip").write_bytes(content)
    words = "is no ZIP archive, or is cut off: its table of contents is missing; pack or copy it"
    assert_refused(tmp_path / "a.zip", words)


def test_names_are_shown_as_one_harmless_line(tmp_path: Path):
    path = write_zip(tmp_path / "a.zip", {"../\x1b[31m": b"x"})
    assert_refused(path, r"'\.\./\\\\x1b\[31m'")


@pytest.mark.parametrize("stated", [0, 500])
def test_a_large_table_of_contents_told_in_zip64_is_refused(tmp_path: Path, stated: int):
    size = 1 << 33
    record = struct.pack("<4sQ2H2L4Q", b"PK\6\6", 44, 45, 45, 0, 0, 1, 1, size, 0)
    locator = struct.pack("<4sLQL", b"PK\6\7", 0, stated, 1)
    end = struct.pack("<4s4H2LH", b"PK\5\6", 0, 0, 1, 1, 0xFFFFFFFF, 0xFFFFFFFF, 0)
    (tmp_path / "a.zip").write_bytes(bytes(500) + record + locator + end)
    words = "has a table of contents of 8192 MiB; at most 64 MiB are read"
    assert_refused(tmp_path / "a.zip", words)


def test_an_archive_that_cannot_be_opened_is_an_error(tmp_path: Path):
    assert_refused(tmp_path / "none.zip", r"cannot be read \(No such file")
